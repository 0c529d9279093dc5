# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Journal and snapshots together: what one says of the other."""

from __future__ import annotations

import os
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from recorded import Flown

from hijack_detect.bags.reader import BagReader
from hijack_detect.recording import schema
from hijack_detect.recording.snapshots import Snapshot, SnapshotFolder


def select(folder: Path, statement: str) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(folder / schema.FILE)) as database:
        return database.execute(statement).fetchall()


def alerted(folder: Path, alerts: int, **parameters: Any) -> Flown:
    """A flight with alerts, each with its whole snapshot."""
    flown = Flown(folder, before_s=2, after_s=1, **parameters)
    for number in range(1, alerts + 1):
        flown.fly(5)
        flown.fly(5, alert=True)
        flown.tick_until(lambda wanted=number: complete(flown) == wanted)
    return flown


def complete(flown: Flown) -> int:
    return sum(".part" not in path.name for path in flown.announced)


def test_what_is_deleted_for_room_is_marked_before(tmp_path: Path) -> None:
    alerted(tmp_path, 4, max_snapshots=2).recorder.close()
    rows = select(tmp_path, "SELECT path, removed FROM snapshots ORDER BY id")
    assert [removed for _, removed in rows] == [1, 1, 0, 0]
    assert [(tmp_path / path).is_dir() for path, _ in rows] == [False, False, True, True]


def test_a_snapshot_is_in_the_journal_before_it_is_announced(tmp_path: Path) -> None:
    flown = Flown(tmp_path, before_s=2, after_s=1)
    known: list[list[tuple[Any, ...]]] = []

    def look(path: Path) -> None:
        statement = f"SELECT complete FROM snapshots WHERE path = 'snapshots/{path.name}'"
        known.append(select(tmp_path, statement))

    flown.on_announced = look
    flown.fly(5)
    flown.fly(0.2, alert=True)
    flown.tick_until(lambda: known)
    flown.fly(5, alert=True)
    flown.tick_until(lambda: len(known) == 2)
    flown.recorder.close()
    assert known == [[(0,)], [(1,)]]


def test_a_part_that_was_announced_stays_if_the_whole_was_not(tmp_path: Path) -> None:
    flown = alerted(tmp_path, 2)
    flown.recorder.close()
    kept = SnapshotFolder(tmp_path / "snapshots", flown.parameters)
    # As if the recorder was killed after the renaming of the first and before its announcement,
    # and after the announcement of the second and before the removal of its part.
    for path in flown.announced:
        if ".part" not in path.name:
            with BagReader(path) as reader:
                kept.write(Snapshot(path.name, 1, (0,), list(reader.messages())))
    with closing(sqlite3.connect(tmp_path / schema.FILE)) as database:
        database.execute("UPDATE snapshots SET path = path || '.part1' WHERE id = 1")
        database.commit()
    Flown(tmp_path).recorder.close()
    for (path,) in select(tmp_path, "SELECT path FROM snapshots"):
        assert (tmp_path / path).is_dir()
    assert len(os.listdir(tmp_path / "snapshots")) == 3


def test_an_alert_that_is_there_at_the_start_has_a_snapshot(tmp_path: Path) -> None:
    """A recorder that died after an alert comes back while it is still latched."""
    flown = Flown(tmp_path, before_s=2, after_s=1)
    flown.fly(5, alert=True)
    flown.tick_until(lambda: complete(flown))
    flown.recorder.close()
    assert select(tmp_path, "SELECT alert FROM alerts") == [(1,)]
