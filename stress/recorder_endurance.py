# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A day of fixes through the node recorder over DDS, as fast as it goes: a table.

    python -m stress.recorder_endurance [--hours 24] [--journal-mb 16]

Fixes of 5 Hz. Prints the memory (RSS) of the recorder and the bytes of its journal beside the
bound while it runs, and at the end how many fixes the recorder wrote.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

import click
import psutil

sys.path.insert(0, str(Path(__file__).parents[1] / "test"))

from feed import fix
from live import SECOND, values_of
from recorded_node import Recorded
from ros import DOMAINS, Graph

HZ = 5
BATCH = 500
LINES = 13
MEGABYTE = 1_000_000


def on_disk(folder: Path) -> int:
    """Bytes of the journal, its log and its index."""
    return sum(os.stat(path).st_size for path in folder.glob("journal.sqlite3*"))


def written(flown: Recorded) -> int:
    """Fixes that the recorder reports as written."""
    one = flown.status()
    return 0 if one is None else int(values_of(one).get("written fixes", "0"))


def recorder_process() -> psutil.Process:
    """The recorder that this process started."""
    (child,) = psutil.Process().children()
    return child


@click.command()
@click.option("--hours", type=click.FloatRange(0.1), default=24.0, show_default=True)
@click.option("--journal-mb", type=click.IntRange(8), default=16, show_default=True)
def main(hours: float, journal_mb: int) -> None:
    """Fly and print."""
    folder = Path(tempfile.mkdtemp(prefix="recorder_endurance_"))
    total = round(hours * 3600 * HZ)
    made, begun, most = Graph(DOMAINS[-1]), time.monotonic(), 0
    try:
        flown = Recorded(made, folder, journal_max_mb=journal_mb, before_s=60.0, after_s=30.0)
        process = recorder_process()
        publisher = flown.publisher("gps/fix")
        message = fix(flown.stamp_ns)
        print("| hours of flight | s | recorder RSS MB | journal MB (bound) |\n|---|---|---|---|")
        for count in range(1, total + 1):
            flown.stamp_ns += SECOND // HZ
            stamp = message.header.stamp
            stamp.sec, stamp.nanosec = divmod(flown.stamp_ns, SECOND)
            publisher.publish(message)
            if count % BATCH == 0:
                made.spin_until(flown.acknowledged, "acknowledgements", timeout_s=60.0)
                most = max(most, on_disk(folder))
            if count % (total // (LINES - 1)) == 0:
                hour, size = count / HZ / 3600, on_disk(folder) / MEGABYTE
                memory = process.memory_info().rss / MEGABYTE
                wall = time.monotonic() - begun
                print(f"| {hour:.1f} | {wall:.0f} | {memory:.1f} | {size:.1f} ({journal_mb}) |")
        made.spin_until(lambda: written(flown) >= total, "the last fix", timeout_s=60.0)
        code = flown.node.interrupt()
        (kept,) = flown.select("SELECT count(*) FROM fixes")[0]
    finally:
        made.close()
    print(
        f"\n{total} fixes sent, {written(flown)} written, the newest {kept} kept; journal at most "
        f"{most / MEGABYTE:.1f} MB of {journal_mb}; exit code {code}"
    )
    shutil.rmtree(folder)
    sys.exit(0 if most <= journal_mb * MEGABYTE and written(flown) == total else 1)


if __name__ == "__main__":
    main()
