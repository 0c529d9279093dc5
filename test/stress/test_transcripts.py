# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A change indicator: nothing that the monitor says of four replays changes unnoticed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from kept import kept

from hijack_detect.replay.offline import OfflineRun
from stress.transcripts.transcript import REPLAYS, Replay, digest, transcript

ROOT = Path(__file__).parents[2]


def run(replay: Replay) -> OfflineRun:
    return kept(f"transcript {replay.name}", replay.run)


@pytest.mark.parametrize("replay", REPLAYS, ids=lambda replay: replay.name)
def test_the_monitor_says_what_it_said(replay: Replay) -> None:
    """After a change that is meant: python -m stress.transcripts, and look at the diff."""
    assert transcript(run(replay)) == replay.path.read_text(encoding="utf-8")


def test_another_process_gives_the_same_bits() -> None:
    name = REPLAYS[2].name
    command = [sys.executable, "-m", "stress.transcripts", "--digest", name]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    own = {replay.name: digest(run(replay)) for replay in REPLAYS}
    assert done.stdout.splitlines() == [f"{own[name]} {name}"]
    assert len(set(own.values())) == len(REPLAYS)


def test_the_transcripts_show_alerts_and_scores() -> None:
    texts = {replay.name: replay.path.read_text(encoding="utf-8") for replay in REPLAYS}
    assert "alert true" in texts["curved_8-carry_off-default"]
    assert "alert true" not in texts["curved_no_velocity_5-clean-default"]
    assert all("stamp_ns fusion correlation" in text for text in texts.values())
