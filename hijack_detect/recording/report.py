# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How the recorder is doing, for /diagnostics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hijack_detect.level import Level
from hijack_detect.recording import schema
from hijack_detect.recording.black_box import BlackBox
from hijack_detect.recording.journal_keeper import JournalKeeper
from hijack_detect.recording.parameters import MEGABYTE, RecorderParameters
from hijack_detect.recording.problems import Problems

WRITTEN = [table for table in schema.TABLES if table != "sessions"]


@dataclass(frozen=True)
class Report:
    """A level, a sentence, and figures by name."""

    level: Level
    text: str
    values: dict[str, str]


@dataclass(frozen=True)
class SnapshotCounts:
    """Snapshots made, and lost because too many were waiting for the disk."""

    made: int
    lost: int


def report(
    parameters: RecorderParameters,
    journal: JournalKeeper,
    box: BlackBox,
    snapshots: SnapshotCounts,
    problems: Problems,
    refused: Mapping[str, int],
) -> Report:
    """Sum up a recorder; `refused` counts messages left out, by topic."""
    ring = box.ring
    values = {f"written {table}": str(journal.written[table]) for table in WRITTEN}
    values |= {f"dropped {table}": str(n) for table, n in journal.dropped.items()}
    values |= {f"left out {topic}": str(n) for topic, n in refused.items()}
    values |= {
        "rows waiting": str(journal.waiting),
        "journal bytes": str(journal.size),
        "journal bound": str(parameters.journal_max_mb * MEGABYTE),
        "ring seconds": f"{ring.seconds:.1f}",
        "ring bytes": str(box.size),
        "ring bound": str(parameters.ring_max_mb * MEGABYTE),
        "snapshots made": str(snapshots.made),
        "snapshots lost": str(snapshots.lost),
        "last problem": problems.last,
    }
    if problems.current:
        return Report("error", problems.text, values)
    if ring.short:
        text = (
            f"the ring holds {ring.seconds:.0f} s of the {parameters.before_s:g} s before an "
            "alert; raise ring_max_mb or lower before_s"
        )
        return Report("warning", text, values)
    text = "collecting what follows an alert" if box.collecting else "recording"
    return Report("info", f"{text} in {journal.path.parent}", values)
