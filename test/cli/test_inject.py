# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `inject`, as it is typed."""

from __future__ import annotations

from pathlib import Path

import pytest
from command import hijack_detect
from ros import ROOT

from hijack_detect.bags.reader import BagReader
from hijack_detect.replay.truth import known_attack
from hijack_detect.streams.samples import NANOSECONDS

BAG = ROOT / "bags/straight_3"


def test_it_writes_a_bag_and_says_what(tmp_path: Path) -> None:
    done = hijack_detect("inject", BAG, tmp_path / "out", "--scenario", "jump", "--onset", "40")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "fixes spoofed" in done.stdout
    with BagReader(tmp_path / "out") as reader:
        attack, _ = known_attack(reader)
        assert attack is not None
        # The first spoofed fix, at most one interval of 0.2 s after the onset.
        assert 40.0 <= (attack.onset_ns - reader.start_ns) / NANOSECONDS < 40.2


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nowhere", "out", "--scenario", "jump"), "nowhere"),
        ((BAG, "out", "--scenario", "no_such"), "no_such: cannot be read"),
        ((BAG, "out", "--scenario", "jump", "--onset", "1000"), "outside the flight"),
        ((BAG, BAG, "--scenario", "jump"), "exists; remove it or choose another name"),
    ],
)
def test_bad_input_is_one_line_and_code_2(
    arguments: tuple[str | Path, ...], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = hijack_detect("inject", *arguments)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    assert list(tmp_path.iterdir()) == []
