# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the recorder."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.parameters import Parameters, param

MEGABYTE = 1_000_000


@dataclass(frozen=True)
class RecorderParameters(Parameters):
    """Where the recorder writes, how much around an alert, and how much at most."""

    folder: str = param(
        "~/.ros/hijack_detect",
        "Folder of the journal (journal.sqlite3) and of the snapshots (snapshots/). Each recorder "
        "needs a folder of its own: in a fleet on one machine give one for each vehicle.",
    )
    further_detectors: str = param(
        "",
        "Detectors of your own whose verdicts are kept too: the same names as for `fusion`.",
    )
    before_s: float = param(
        60.0,
        "A snapshot begins this long before the alert, on header stamps.",
        unit="s",
        low=1.0,
        high=3600.0,
    )
    after_s: float = param(
        30.0,
        "A snapshot ends this long after the alert, on header stamps. Another alert within this "
        "time makes the snapshot longer instead of beginning a second one.",
        unit="s",
        low=0.0,
        high=3600.0,
    )
    ring_max_mb: int = param(
        64,
        "Most memory for messages. Half of it is for what was before an alert, half for what "
        "comes after. /diagnostics warn if that is too little for `before_s`.",
        unit="MB",
        low=1,
        high=16_000,
    )
    max_snapshots: int = param(
        50, "So many snapshots are kept; the oldest is deleted.", low=1, high=10_000
    )
    snapshots_max_mb: int = param(
        1000,
        "So many bytes of snapshots are kept; the oldest is deleted. The newest always stays.",
        unit="MB",
        low=1,
        high=10_000_000,
    )
    journal_max_mb: int = param(
        256,
        "Most bytes of the journal on disk, write-ahead log included. The oldest fixes, "
        "velocities, satellite counts and verdicts make room; alerts, snapshots and events stay "
        "longest.",
        unit="MB",
        low=8,
        high=1_000_000,
    )
    journal_max_age_h: float = param(
        0.0,
        "Fixes, velocities, satellite counts and verdicts received longer ago are deleted, by the "
        "wall clock; 0 keeps them as long as there is room.",
        unit="h",
        low=0.0,
        high=1_000_000.0,
    )
