# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Time of the offline path, as ratios to rosbags measured in the same run.

Each job runs in a separate process, by turns, and the medians count.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from jobs import JOBS
from load import load_bag
from rich.console import Console
from rich.progress import track
from rich.table import Table
from section import Section

HERE = Path(__file__).parent
SECONDS, IMU_HZ = 600.0, 250


def measured(name: str, bag: Path) -> dict[str, float]:
    """One job in a fresh process."""
    done = subprocess.run(
        [sys.executable, HERE / "jobs.py", name, bag], check=True, capture_output=True, text=True
    )
    found: dict[str, float] = json.loads(done.stdout)
    return found


def medians(
    names: Sequence[str], bag: Path, repeats: int, what: str
) -> dict[str, dict[str, float]]:
    """Median figures of jobs that take turns."""
    runs: dict[str, list[dict[str, float]]] = {name: [] for name in names}
    turns = [name for _ in range(repeats) for name in names]
    for name in track(turns, f"{what:24}", console=Console(stderr=True)):
        runs[name].append(measured(name, bag))
    return {
        name: {key: statistics.median(one[key] for one in all_of) for key in all_of[0]}
        for name, all_of in runs.items()
    }


def measure(folder: Path, repeats: int) -> Section:
    """Processor time of each job over that of rosbags."""
    bag = load_bag(folder, SECONDS, IMU_HZ)
    found = medians(list(JOBS), bag, repeats, f"{SECONDS:g} s at {IMU_HZ} Hz")
    ratios = {name: one["cpu_s"] / found["rosbags"]["cpu_s"] for name, one in found.items()}
    table = Table("offline", "s", "over rosbags", "peak MB")
    for name, one in found.items():
        table.add_row(name, f"{one['cpu_s']:.2f}", f"{ratios[name]:.2f}", f"{one['peak_mb']:.0f}")
    return Section(ratios, found, table)
