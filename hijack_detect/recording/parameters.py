# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the recorder."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.parameters import Parameters, param

MEGABYTE = 1_000_000


@dataclass(frozen=True)
class RecorderParameters(Parameters):
    """Folder of the recorder, its seconds around an alert, and its bounds in bytes."""

    folder: str = param(
        "~/.ros/hijack_detect",
        "Folder of the journal (journal.sqlite3) and of the snapshots (snapshots/). Each recorder "
        "needs a folder of its own: in a fleet on one machine give one for each vehicle.",
        source="chosen: ROS 2 keeps what it writes in ~/.ros",
        basic=True,
    )
    further_detectors: str = param(
        "",
        "Detectors of your own whose verdicts are recorded too: the same names as for `fusion`.",
        source="chosen: none, only the detectors of this package",
    )
    before_s: float = param(
        60.0,
        "A snapshot begins this long before the alert, on header stamps.",
        source=(
            "chosen, not swept; slow attacks are found after tens of seconds "
            "(docs/detection-limits.md)"
        ),
        unit="s",
        low=1.0,
        high=3600.0,
    )
    after_s: float = param(
        30.0,
        "A snapshot ends this long after the alert, on header stamps. Another alert within this "
        "time makes the snapshot longer instead of beginning a second one.",
        source="chosen, not swept; between the hold of an alert and the memory it costs",
        unit="s",
        low=0.0,
        high=3600.0,
    )
    ring_max_mb: int = param(
        64,
        "Memory for messages, at most. Half of it is for messages before an alert, half for "
        "those after it. /diagnostics warn if that is too little for `before_s`.",
        source="chosen, not swept; /diagnostics warn when it is too little",
        unit="MB",
        low=1,
        high=16_000,
    )
    max_snapshots: int = param(
        50,
        "Number of snapshots kept; the oldest is deleted.",
        source="chosen, not swept; `snapshots_max_mb` bounds the disk",
        low=1,
        high=10_000,
    )
    snapshots_max_mb: int = param(
        1000,
        "Size of all snapshots, at most; the oldest is deleted. The newest always stays.",
        source="chosen: 1 GB, a small part of a companion computer's card; not swept",
        unit="MB",
        low=1,
        high=10_000_000,
    )
    journal_max_mb: int = param(
        256,
        "Size of the journal on disk, at most, write-ahead log included. The oldest fixes, "
        "velocities, satellite counts and verdicts make room; alerts, snapshots and events stay "
        "longest.",
        source=(
            "measured: docs/recorder.md, A day of fixes: 16 MB hold 294000 fixes, 16 h at 5 Hz; "
            "256 MB hold ten days of fixes alone"
        ),
        unit="MB",
        low=8,
        high=1_000_000,
    )
    journal_max_age_h: float = param(
        0.0,
        "Fixes, velocities, satellite counts and verdicts received longer ago are deleted, by the "
        "wall clock; 0 keeps them as long as there is room.",
        source="chosen: no limit by age, `journal_max_mb` bounds the disk",
        unit="h",
        low=0.0,
        high=1_000_000.0,
    )
