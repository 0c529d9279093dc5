# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""24 hours of fixes: memory stays flat, and the journal inside its bound."""

from __future__ import annotations

import os
from pathlib import Path

import psutil
import pytest
from recorded import SECOND, Flown, fix

HOURS = 24
HZ = 5
JOURNAL_MB = 16


@pytest.mark.slow
def test_a_day_of_fixes_leaves_memory_flat_and_the_journal_inside_its_bound(quick: Path) -> None:
    flown = Flown(quick, journal_max_mb=JOURNAL_MB, ring_max_mb=4)
    process = psutil.Process()
    memory: list[int] = []
    most = 0
    data = fix(0)
    for count in range(1, HOURS * 3600 * HZ + 1):
        flown.stamp_ns += SECOND // HZ
        header = divmod(flown.stamp_ns, SECOND)
        stamp = header[0].to_bytes(4, "little") + header[1].to_bytes(4, "little")
        flown.receive("fix", data[:4] + stamp + data[12:])
        if count % 1000 == 0:
            flown.recorder.tick()
            most = max(most, sum(os.stat(path).st_size for path in quick.glob("journal*")))
        if count % (3600 * HZ) == 0:
            memory.append(process.memory_info().rss)
    flown.recorder.close()
    report = flown.recorder.report()
    assert report.values["written fixes"] == str(HOURS * 3600 * HZ)
    assert not flown.recorder.journal.dropped
    assert 0.7 * JOURNAL_MB * 1e6 < most <= JOURNAL_MB * 1e6
    assert max(memory[4:]) - memory[3] < 2_000_000
