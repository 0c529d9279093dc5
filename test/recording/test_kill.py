# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A recorder that is killed at any moment leaves a journal that opens, and whole snapshots."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

KILLS = 50


@pytest.mark.slow
def test_fifty_kills_while_alerts_come_in(quick: Path) -> None:
    program = Path(__file__).with_name("killed.py")
    done = subprocess.run(
        [sys.executable, program, quick, str(KILLS)],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    *found, last = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(found) == KILLS
    for one in found:
        assert one["integrity"] == "ok"
        assert one["gaps"] == one["half written"] == 0
        assert one["lost s"] <= 1.0
        assert one["not in the journal"] == one["damaged"] == []
    assert sum(one["announced"] for one in found) > KILLS // 2
    assert sum(one["fixes"] for one in found) > 10 * KILLS
    assert not [name for name in last["listed"] if name.startswith(".")]
    assert len(last["listed"]) <= 2 * 4
