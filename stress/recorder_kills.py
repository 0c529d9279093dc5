# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The recorder as a node over DDS, killed with SIGKILL while alerts come in: a table.

    python -m stress.recorder_kills [--kills 50]

After each kill the journal is checked (it opens, PRAGMA integrity_check, no row half written, no
fix missing between two that are there), every snapshot that was announced is read to its last
message, and the age of the newest row is compared with what had been sent.
"""

from __future__ import annotations

import random
import shutil
import signal
import sqlite3
import sys
import tempfile
import time
from contextlib import closing
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import click

sys.path.insert(0, str(Path(__file__).parents[1] / "test"))

from feed import GPS_NS, START_NS
from live import SECOND
from recorded_node import Recorded
from ros import DOMAINS, Graph

from hijack_detect.bags.reader import BagReader

BEFORE_S, AFTER_S = 10.0, 3.0
RUN_S = (0.5, 3.0)
"""Wall seconds of flight until the kill; flown at about real time."""


@dataclass
class Tally:
    """What was found after all kills."""

    kills: int = 0
    opened: int = 0
    fixes: int = 0
    gaps: int = 0
    half_written: int = 0
    alerts: int = 0
    announced: set[str] = field(default_factory=set)
    read: int = 0
    damaged: list[str] = field(default_factory=list)
    lost_s: list[float] = field(default_factory=list)


def check(folder: Path, since_ns: int, tally: Tally) -> int:
    """Look at the files after a kill; return the newest stamp that is kept, nanoseconds."""
    tally.kills += 1
    with closing(sqlite3.connect(folder / "journal.sqlite3")) as database:
        run = database.execute
        tally.opened += run("PRAGMA integrity_check").fetchall() == [("ok",)]
        rows = run("SELECT * FROM fixes WHERE stamp_ns > ? ORDER BY id", (since_ns,)).fetchall()
        snapshots = run("SELECT name, path, messages FROM snapshots WHERE NOT removed").fetchall()
        (tally.alerts,) = run("SELECT count(*) FROM alerts WHERE alert").fetchone()
    stamps = [row[3] for row in rows]
    tally.fixes += len(stamps)
    tally.gaps += sum(b - a != GPS_NS for a, b in pairwise(stamps))
    tally.half_written += sum(value is None for row in rows for value in row)
    listed = {name for name, _, _ in snapshots}
    tally.damaged += [f"{name} is not in the journal" for name in tally.announced - listed]
    for _, path, messages in snapshots:
        try:
            with BagReader(folder / path) as reader:
                found = sum(1 for _ in reader.messages())
        except ValueError as error:
            tally.damaged.append(str(error))
            continue
        tally.read += 1
        if found != messages:
            tally.damaged.append(f"{path} has {found} messages, announced were {messages}")
    return max(stamps, default=0)


def fly_until_killed(flown: Recorded, seconds: float, tally: Tally) -> None:
    """Fly at real time, half a second with an alert in every one and a half; then kill."""
    since_ns, begun = flown.stamp_ns, time.monotonic()
    sent: list[tuple[float, int]] = []
    while time.monotonic() - begun < seconds:
        flown.fly(GPS_NS / SECOND, alert=len(sent) % 8 >= 5)
        sent.append((time.monotonic(), flown.stamp_ns))
        flown.graph.spin_until(lambda: time.monotonic() - sent[-1][0] > 0.05, "the next interval")
    killed = time.monotonic()
    flown.node.signal(signal.SIGKILL)
    flown.node.wait()
    flown.graph.spin_until_quiet()
    tally.announced |= {Path(m.data).name.split(".part")[0] for m in flown.paths.messages}
    newest = check(flown.folder, since_ns, tally)
    tally.lost_s.append(max((killed - wall for wall, stamp in sent if stamp > newest), default=0.0))


@click.command()
@click.option("--kills", type=click.IntRange(min=1), default=50, show_default=True)
def main(kills: int) -> None:
    """Kill and check, and print a table."""
    folder = Path(tempfile.mkdtemp(prefix="recorder_kills_"))
    tally, chance, begun = Tally(), random.Random(1), time.monotonic()
    made = Graph(DOMAINS[-1])
    try:
        flown = Recorded(made, folder, before_s=BEFORE_S, after_s=AFTER_S, max_snapshots=500)
        for number in range(kills):
            fly_until_killed(flown, chance.uniform(*RUN_S), tally)
            if number + 1 < kills:
                flown.start_again()
    finally:
        made.close()
    print(f"| checked after each of {tally.kills} kills | |\n|---|---|")
    print(f"| journal opens, integrity_check says ok | {tally.opened} of {tally.kills} |")
    print(f"| fixes kept; half written; gaps | {tally.fixes}; {tally.half_written}; {tally.gaps} |")
    print(f"| alerts in the journal | {tally.alerts} |")
    print(f"| snapshots announced | {len(tally.announced)} |")
    print(f"| readings of a snapshot to its end | {tally.read} |")
    print(f"| damaged or missing | {len(tally.damaged)} |")
    print(f"| lost before a kill, at most | {max(tally.lost_s):.2f} s |")
    print(f"\n{time.monotonic() - begun:.0f} s, stamps from {START_NS // SECOND}")
    for text in tally.damaged:
        print(text)
    shutil.rmtree(folder)
    wrong = tally.damaged or tally.gaps or tally.half_written or tally.opened < tally.kills
    sys.exit(1 if wrong or max(tally.lost_s) > 1.0 else 0)


if __name__ == "__main__":
    main()
