# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The file of the journal: all or nothing, inside its bound, and no file is lost to it."""

from __future__ import annotations

import os
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from hijack_detect.recording import schema
from hijack_detect.recording.journal import AlienFileError, Journal, Session
from hijack_detect.recording.journal_keeper import JournalKeeper
from hijack_detect.recording.journal_reader import open_journal
from hijack_detect.recording.problems import JournalError
from hijack_detect.recording.rows import Row, event_row

MEGABYTE = 1_000_000
SESSION = Session(1, "/recorder", "1.0")


def fixes(start: int, count: int) -> list[Row]:
    values = (48.123456789, 11.123456789, 512.3, 0, 1.5, 1.5, 4.0)
    return [Row("fixes", (ns, ns, *values)) for ns in range(start, start + count)]


def verdicts(start: int, count: int) -> list[Row]:
    return [
        Row("verdicts", (ns, ns, "date", "normal", 0.1, 1.0, "calm " * 40, '{"a":1}'))
        for ns in range(start, start + count)
    ]


def on_disk(path: Path) -> int:
    return sum(os.stat(one).st_size for one in path.parent.iterdir())


def select(path: Path, statement: str) -> list[tuple[object, ...]]:
    with closing(sqlite3.connect(path)) as database:
        return database.execute(statement).fetchall()


def test_rows_are_written_all_or_none(quick: Path) -> None:
    path = quick / schema.FILE
    journal = Journal(path, 8 * MEGABYTE, SESSION)
    journal.write(fixes(0, 10))
    broken = Row("fixes", (None,) * 9)
    with pytest.raises(sqlite3.IntegrityError):
        journal.write([*fixes(10, 10), broken])
    journal.write(fixes(10, 1))
    journal.end_session(5)
    journal.close()
    assert select(path, "SELECT count(*), max(stamp_ns) FROM fixes") == [(11, 10)]
    assert select(path, "SELECT * FROM sessions") == [(1, 1, 5, "/recorder", "1.0")]


def test_a_session_that_opens_again_stays_one(quick: Path) -> None:
    path = quick / schema.FILE
    for start in (1, 1, 2):
        journal = Journal(path, 8 * MEGABYTE, Session(start, "/recorder", "1.0"))
        journal.write(fixes(0, 1))
        journal.close()
    assert select(path, "SELECT session FROM fixes") == [(1,), (1,), (2,)]


def test_the_bound_holds_on_disk_and_what_matters_stays(quick: Path) -> None:
    path = quick / schema.FILE
    journal = Journal(path, 8 * MEGABYTE, SESSION)
    journal.write([event_row(0, "start", "first")])
    most = 0
    for start in range(0, 200_000, 500):
        journal.write(fixes(start, 250) + verdicts(start + 250, 250))
        journal.tidy()
        most = max(most, on_disk(path))
    assert 6 * MEGABYTE < most <= 8 * MEGABYTE
    assert journal.size == on_disk(path)
    journal.close()
    (kept, oldest, newest), *_ = select(path, "SELECT count(*), min(id), max(id) FROM fixes")
    assert newest == 100_000
    assert isinstance(newest, int) and isinstance(oldest, int)
    assert kept == newest - oldest + 1 > 5_000
    assert select(path, "SELECT count(*) FROM events") == [(1,)]


def test_events_make_room_when_nothing_else_is_left(quick: Path) -> None:
    path = quick / schema.FILE
    journal = Journal(path, 8 * MEGABYTE, SESSION)
    for start in range(0, 20_000, 200):
        journal.write([event_row(ns, "problem", "x" * 1000) for ns in range(start, start + 200)])
        journal.tidy()
    assert on_disk(path) <= 8 * MEGABYTE
    journal.close()
    assert select(path, "SELECT max(received_ns) FROM events") == [(19_999,)]


def test_a_smaller_bound_makes_the_file_smaller(quick: Path) -> None:
    path = quick / schema.FILE
    journal = Journal(path, 30 * MEGABYTE, SESSION)
    for start in range(0, 60_000, 1000):
        journal.write(verdicts(start, 1000))
        journal.tidy()
    journal.close()
    assert on_disk(path) > 15 * MEGABYTE
    journal = Journal(path, 8 * MEGABYTE, SESSION)
    journal.write(fixes(0, 1))
    journal.tidy()
    assert on_disk(path) <= 8 * MEGABYTE
    journal.close()


def test_old_rows_go(quick: Path) -> None:
    path = quick / schema.FILE
    journal = Journal(path, 8 * MEGABYTE, SESSION)
    journal.write([event_row(0, "start", ""), *fixes(0, 100)])
    journal.tidy(oldest_ns=60)
    journal.close()
    assert select(path, "SELECT min(received_ns), count(*) FROM fixes") == [(60, 40)]
    assert select(path, "SELECT count(*) FROM events") == [(1,)]


def test_a_reader_that_never_ends_stops_the_writing_before_the_bound(quick: Path) -> None:
    path = quick / schema.FILE
    journal = Journal(path, 8 * MEGABYTE, SESSION)
    journal.write(fixes(0, 1))
    with closing(sqlite3.connect(path, isolation_level=None)) as reader:
        reader.execute("BEGIN")
        reader.execute("SELECT * FROM fixes").fetchall()
        with pytest.raises(sqlite3.OperationalError, match="reading for too long"):
            for start in range(0, 100_000, 500):
                journal.write(fixes(start, 500))
                journal.tidy()
        assert on_disk(path) <= 8 * MEGABYTE
    journal.tidy()
    journal.close()


def test_a_newer_file_is_refused(quick: Path) -> None:
    path = quick / schema.FILE
    Journal(path, 8 * MEGABYTE, SESSION).close()
    select(path, f"PRAGMA user_version = {schema.VERSION + 1}")
    with pytest.raises(JournalError, match=r"newer version .schema 2, this one knows 1.; update"):
        Journal(path, 8 * MEGABYTE, SESSION)


def test_a_file_that_is_no_journal_is_told_apart(quick: Path) -> None:
    path = quick / schema.FILE
    path.write_bytes(b"some text, and more of it" * 100)
    with pytest.raises(AlienFileError, match="damaged or not a database"):
        Journal(path, 8 * MEGABYTE, SESSION)
    path.unlink()
    select(path, "CREATE TABLE mine (x)")
    with pytest.raises(AlienFileError, match="not a journal"):
        Journal(path, 8 * MEGABYTE, SESSION)
    assert select(path, "SELECT name FROM sqlite_master") == [("mine",)]


def test_a_deleted_file_is_noticed(quick: Path) -> None:
    path = quick / schema.FILE
    journal = Journal(path, 8 * MEGABYTE, SESSION)
    assert not journal.gone
    path.unlink()
    assert journal.gone
    journal.close()


def test_damage_that_sqlite_cannot_put_into_words(quick: Path) -> None:
    """The words of a table are no longer UTF-8, and SQLite's message quotes them."""
    path = quick / schema.FILE
    Journal(path, 8 * MEGABYTE, SESSION).close()
    content = path.read_bytes()
    assert b"KEY AUTOINCREMENT" in content
    path.write_bytes(content.replace(b"KEY AUTOINCREMENT", b"KEYQ\xf3\x97\xa9OINCREMENT", 1))
    with pytest.raises(AlienFileError, match="damaged"):
        Journal(path, 8 * MEGABYTE, SESSION)
    with pytest.raises(JournalError, match="cannot be read"), open_journal(path):
        pass


@pytest.mark.parametrize("word", [b"sessiom", b"sessi\xffn"])
def test_a_journal_whose_tables_have_other_columns_is_moved_aside(quick: Path, word: bytes) -> None:
    path = quick / schema.FILE
    Journal(path, 8 * MEGABYTE, SESSION).close()
    content = path.read_bytes()
    path.write_bytes(content.replace(b"AUTOINCREMENT, session ", b"AUTOINCREMENT, " + word + b" "))
    keeper = JournalKeeper(path, 8 * MEGABYTE, 0, SESSION)
    keeper.add(fixes(0, 1)[0], 0.0)
    assert keeper.commit(0.0, 1) or keeper.commit(9.0, 1)
    keeper.close(9.0, 1)
    assert "moved aside" in keeper.notes[0]
