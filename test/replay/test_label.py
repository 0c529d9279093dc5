# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A label that cannot be one is refused with its path."""

from __future__ import annotations

from pathlib import Path

import pytest

from hijack_detect.bags.errors import BagError
from hijack_detect.replay.truth import read_label


@pytest.mark.parametrize(
    "attack",
    [
        '{"t_start": 1.0}',
        '{"t_start": 5.0, "t_end": 2.0}',
        '{"t_start": -1.0, "t_end": 2.0}',
        '{"t_start": 1.0, "t_end": Infinity}',
        '{"t_start": NaN, "t_end": 2.0}',
        '{"t_start": "a", "t_end": "b"}',
        "[" * 100_000,
    ],
)
def test_times_that_no_flight_has(tmp_path: Path, attack: str) -> None:
    (tmp_path / "label.json").write_text(f'{{"kind": "hijack", "attack": {attack}}}')
    with pytest.raises(BagError, match=r"label\.json"):
        read_label(tmp_path)
