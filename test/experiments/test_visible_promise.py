# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What `coast` says that it could see, it sees."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments import visible_promise as promise

ROOT = Path(__file__).parents[2]
RECORDED = ROOT / ".." / "shared" / "flights" / "bags" / "inertialnav__quadOptFlow"


def found(path: Path, every_s: float, multiple: float) -> list[bool]:
    """Whether drifts of this multiple of `smallest_visible` were found."""
    start_ns, samples = promise.samples_of(path)
    places = promise.onsets(samples, every_s, path.name)
    seen = [promise.seen(samples, start_ns, one, multiple * one.visible) for one in places]
    return [one for one in seen if one is not None]


@pytest.mark.parametrize(("multiple", "all_found"), [(1.2, True), (0.4, False)])
def test_the_promise_holds_on_a_simulated_flight(multiple: float, all_found: bool) -> None:
    drifts = found(ROOT / "bags" / "curved_8", 15.0, multiple)
    assert len(drifts) >= 3
    assert set(drifts) == {all_found}


@pytest.mark.slow
@pytest.mark.skipif(not RECORDED.is_dir(), reason="../shared/flights is not here")
def test_the_promise_holds_on_a_recorded_flight() -> None:
    above, below = found(RECORDED, 40.0, 1.2), found(RECORDED, 40.0, 0.8)
    assert len(above) >= 15
    assert sum(above) >= 0.9 * len(above)
    assert sum(below) <= 0.5 * len(below)
