# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Kills a recorder many times while alerts come in, and looks at what each left.

    python killed.py FOLDER KILLS

Runs without ROS: one process loads everything and forks each recorder, which is killed after a
random time. Prints one JSON object for each kill.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sqlite3
import sys
import time
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from recorded import SECOND, START_NS, Flown

from hijack_detect.bags.reader import BagReader
from hijack_detect.recording import schema
from hijack_detect.recording.snapshots import SnapshotFolder

GAP_NS = SECOND // 5
LONG_EVERY = 20
"""Every so many kills a long calm flight, in which only the clock commits."""


def fly(folder: Path, start_ns: int, heard: int, *, calm: bool) -> None:
    """Fly for ever, two seconds with an alert and two without unless calm; tell what was heard."""
    flown = Flown(folder, before_s=4, after_s=1, max_snapshots=4)
    flown.stamp_ns = start_ns
    told = 0
    for step in range(10**9):
        flown.fly(0.2, alert=not calm and step // 10 % 2 == 1)
        flown.recorder.tick()
        os.write(heard, f"{time.time_ns()} {flown.stamp_ns}\n".encode())
        for path in flown.announced[told:]:
            os.write(heard, f"{time.time_ns()} {path.name.split('.part')[0]}\n".encode())
        told = len(flown.announced)
        time.sleep(0.002)


def kill_once(
    folder: Path, start_ns: int, seconds: float, *, calm: bool, announced_first: bool
) -> dict[str, Any]:
    """Start a recorder, kill it so many seconds after its first message, look at the files.

    With `announced_first` so many after its first snapshot, however slow the machine is.
    """
    reading, writing = os.pipe()
    pid = os.fork()
    if not pid:
        try:
            fly(folder, start_ns, writing, calm=calm)
        finally:
            os._exit(1)
    os.close(writing)
    with open(reading, encoding="ascii") as pipe:
        lines = [pipe.readline()]
        while announced_first and "alert" not in lines[-1]:
            lines.append(pipe.readline())
        time.sleep(seconds)
        killed_ns = time.time_ns()
        os.kill(pid, signal.SIGKILL)
        lines += pipe.readlines()
    _, status = os.waitpid(pid, 0)
    assert os.WTERMSIG(status) == signal.SIGKILL
    told = [line.split() for line in lines]
    stamps = [(int(wall), int(what)) for wall, what in told if what.isdigit()]
    announced = {what for _, what in told if not what.isdigit()}
    return check(folder, start_ns, killed_ns, stamps, announced)


def check(
    folder: Path,
    start_ns: int,
    killed_ns: int,
    heard: list[tuple[int, int]],
    announced: set[str],
) -> dict[str, Any]:
    """What is in the files, and what is missing."""
    with closing(sqlite3.connect(folder / schema.FILE)) as database:
        (integrity,) = database.execute("PRAGMA integrity_check").fetchone()
        found = database.execute(
            "SELECT * FROM fixes WHERE stamp_ns >= ? ORDER BY id", (start_ns,)
        ).fetchall()
        snapshots = database.execute("SELECT name, path, messages, removed FROM snapshots")
        rows = snapshots.fetchall()
    stamps = [row[3] for row in found]
    newest = max(stamps, default=0)
    lost = [killed_ns - wall for wall, stamp in heard if stamp > newest]
    damaged = [
        path for _, path, messages, gone in rows if not gone and count(folder / path) != messages
    ]
    return {
        "integrity": integrity,
        "fixes": len(stamps),
        "gaps": sum(b - a != GAP_NS for a, b in pairwise(stamps)),
        "half written": sum(value is None for row in found for value in row),
        "lost s": max(lost, default=0) / SECOND,
        "announced": len(announced),
        "not in the journal": sorted(announced - {name for name, *_ in rows}),
        "snapshots": sum(not gone for *_, gone in rows),
        "damaged": damaged,
    }


def count(bag: Path) -> int:
    """Messages that can be read."""
    try:
        with BagReader(bag) as reader:
            return sum(1 for _ in reader.messages())
    except ValueError:
        return -1


def main() -> None:
    """Kill, then let one recorder stop in order and print what it leaves."""
    folder, kills = Path(sys.argv[1]), int(sys.argv[2])
    chance = random.Random(1)
    for number in range(1, kills + 1):
        long = number % LONG_EVERY == 0
        seconds = chance.uniform(1.2, 1.5) if long else chance.uniform(0.0, 0.2)
        start_ns = START_NS + number * 10_000 * SECOND
        late = not long and number % 3 > 0
        found = kill_once(folder, start_ns, seconds, calm=long, announced_first=late)
        print(json.dumps(found), flush=True)
    flown = Flown(folder, max_snapshots=4)
    listed = sorted(os.listdir(folder / "snapshots"))
    left = SnapshotFolder(folder / "snapshots", flown.parameters).superseded()
    flown.recorder.close()
    print(json.dumps({"listed": listed, "superseded": left}))


if __name__ == "__main__":
    main()
