# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Reading a journal: also while it is written, and from a disk that cannot be written."""

from __future__ import annotations

import csv
import json
import shutil
import sqlite3
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any, TextIO
from urllib.parse import quote

from hijack_detect.recording import schema
from hijack_detect.recording.journal import ERRORS, files_of
from hijack_detect.recording.problems import JournalError

PAGE_ROWS = 5000
"""Rows of one read. Chosen, not swept. Between two reads the recorder can empty its log, which
would grow without end beside a reader that never pauses."""
PATIENCE_S = 5.0
"""Timeout of a lock. Chosen: the recorder locks the file for moments."""


@dataclass(frozen=True)
class Query:
    """Which rows. Times are nanoseconds since 1970, of `schema.time_column`.

    `last` is the number of rows from the end of those that fit, `limit` that from their start.
    """

    table: str
    since_ns: int | None = None
    until_ns: int | None = None
    detector: str | None = None
    state: str | None = None
    limit: int | None = None
    last: int | None = None


@dataclass(frozen=True)
class TableSummary:
    """Number of rows, and first and last time, nanoseconds."""

    rows: int
    first_ns: int | None
    last_ns: int | None


class JournalReader:
    """A journal that is only read."""

    def __init__(self, database: sqlite3.Connection, path: Path) -> None:
        self._database = database
        self.path = path

    def rows(self, query: Query) -> Iterator[dict[str, Any]]:
        """Yield rows in the order in which they were written, as a dictionary by column.

        Raises:
            JournalError: The table has no column that the query asks for, or the file is damaged.
        """
        where, values = _conditions(query)
        after = self._start(query, where, values)
        left = query.limit
        statement = f"SELECT * FROM {query.table} WHERE id > ?{where} ORDER BY id LIMIT ?"
        while left is None or left > 0:
            wanted = PAGE_ROWS if left is None else min(left, PAGE_ROWS)
            page = self._all(statement, (after, *values, wanted))
            yield from (dict(row) for row in page)
            if len(page) < wanted:
                return
            after = page[-1]["id"]
            left = None if left is None else left - len(page)

    def count(self, query: Query) -> int:
        """Number of rows that fit, without `last` and `limit`."""
        where, values = _conditions(query)
        return int(self._one(f"SELECT count(*) FROM {query.table} WHERE 1{where}", values)[0])

    def summary(self, table: str) -> TableSummary:
        """Rows and time span of a table."""
        time = schema.time_column(table)
        return TableSummary(
            *self._one(f"SELECT count(*), min({time}), max({time}) FROM {table}", ())
        )

    def _start(self, query: Query, where: str, values: tuple[Any, ...]) -> int:
        """The id after which to begin."""
        if query.last is None:
            return 0
        found = self._all(
            f"SELECT id FROM {query.table} WHERE 1{where} ORDER BY id DESC LIMIT 1 OFFSET ?",
            (*values, query.last),
        )
        return int(found[0][0]) if found else 0

    def _one(self, statement: str, values: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(self._all(statement, values)[0])

    def _all(self, statement: str, values: tuple[Any, ...]) -> list[sqlite3.Row]:
        try:
            return self._database.execute(statement, values).fetchall()
        except ERRORS as error:
            raise JournalError(f"{self.path}: cannot be read ({error})") from error


@contextmanager
def open_journal(given: Path) -> Iterator[JournalReader]:
    """Open a journal, given by its file or its folder, without changing anything.

    Raises:
        JournalError: It is missing, damaged, no journal, or of a newer version.
    """
    path = given / schema.FILE if given.is_dir() else given
    if not path.is_file():
        raise JournalError(f"{path}: does not exist; name the journal or its folder")
    with tempfile.TemporaryDirectory() as copies:
        try:
            database = _connect(path, Path(copies))
        except (*ERRORS, OSError) as error:
            raise JournalError(f"{path}: cannot be read as a journal ({error})") from error
        with closing(database):
            database.row_factory = sqlite3.Row
            yield JournalReader(database, path)


def _connect(path: Path, copies: Path) -> sqlite3.Connection:
    """Open read-only; where the disk does not allow the files of a log, open a copy."""
    try:
        return _checked(path, "mode=ro")
    except sqlite3.OperationalError:
        log = Path(f"{path}-wal")
        if not log.exists() or not log.stat().st_size:
            return _checked(path, "mode=ro&immutable=1")
    for file in files_of(path):
        if not file.name.endswith("-shm"):
            shutil.copy(file, copies)
    return _checked(copies / path.name, "mode=rw")


def _checked(path: Path, mode: str) -> sqlite3.Connection:
    address = f"file:{quote(str(path.absolute()))}?{mode}"
    database = sqlite3.connect(address, uri=True, timeout=PATIENCE_S)
    try:
        (application,) = database.execute("PRAGMA application_id").fetchone()
        (version,) = database.execute("PRAGMA user_version").fetchone()
        database.execute("SELECT count(*) FROM sqlite_master").fetchone()
        if application != schema.APPLICATION_ID:
            raise JournalError(f"{path}: is not a journal of the recorder")
        if version > schema.VERSION:
            raise JournalError(
                f"{path}: was written by a newer version (schema {version}, this one knows "
                f"{schema.VERSION}); update this package"
            )
    except BaseException:
        database.close()
        raise
    return database


def _conditions(query: Query) -> tuple[str, tuple[Any, ...]]:
    columns = schema.TABLES[query.table]
    time = schema.time_column(query.table)
    wanted = {
        f"{time} >= ?": query.since_ns,
        f"{time} < ?": query.until_ns,
        "detector = ?": query.detector,
        "state = ?": query.state,
    }
    chosen = {text: value for text, value in wanted.items() if value is not None}
    for text in chosen:
        column = text.split()[0]
        if column not in columns:
            having = [name for name, known in schema.TABLES.items() if column in known]
            raise JournalError(f"{query.table} have no {column}; {' and '.join(having)} have one")
    return "".join(f" AND {text}" for text in chosen), tuple(chosen.values())


_EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)
_MAX_SECONDS = 2**33
"""More than any stamp of ROS 2 can hold."""


def columns_of(table: str) -> list[str]:
    """Columns of an export: the time in UTC, then those of the table."""
    return ["time", "id", *schema.TABLES[table]]


def write_csv(table: str, rows: Iterable[Mapping[str, Any]], file: TextIO) -> int:
    """Write rows as CSV with a line of names; return their number."""
    writer = csv.writer(file, lineterminator="\n")
    columns = columns_of(table)
    writer.writerow(columns)
    count = 0
    for row in rows:
        found = _with_time(table, row)
        writer.writerow([found[column] for column in columns])
        count += 1
    return count


def write_json(table: str, rows: Iterable[Mapping[str, Any]], file: TextIO) -> int:
    """Write rows as a JSON array with one object a line; return their number."""
    count = 0
    file.write("[")
    for row in rows:
        found = _with_time(table, row)
        if "numbers" in found:
            found["numbers"] = json.loads(found["numbers"])
        file.write(("\n" if not count else ",\n") + json.dumps(found, ensure_ascii=False))
        count += 1
    file.write("\n]\n")
    return count


def utc(ns: int | None) -> str:
    """A time in nanoseconds as `2026-11-25T13:35:10.123Z`, empty for None."""
    if ns is None:
        return ""
    moment = _EPOCH + timedelta(milliseconds=ns // 1_000_000)
    return moment.replace(tzinfo=None).isoformat(timespec="milliseconds") + "Z"


def nanoseconds(text: str) -> int:
    """A time given as ISO 8601 (UTC without a zone) or as seconds since 1970.

    Raises:
        ValueError: It is neither.
    """
    try:
        seconds = Decimal(text)
    except InvalidOperation:
        # Python 3.10 reads no Z.
        try:
            moment = datetime.fromisoformat(text.replace("Z", "+00:00"))
        except ValueError as error:
            raise ValueError(
                f"{text!r} is no time; give seconds, or ISO as 2026-11-25T13:35:10.123Z"
            ) from error
        if moment.tzinfo is None:
            moment = moment.replace(tzinfo=timezone.utc)
        return (moment - _EPOCH) // timedelta(microseconds=1) * 1000
    if not seconds.is_finite() or abs(seconds) > _MAX_SECONDS:
        raise ValueError(f"{text!r} is no time in seconds")
    return int(seconds * 1_000_000_000)


def _with_time(table: str, row: Mapping[str, Any]) -> dict[str, Any]:
    return {"time": utc(row[schema.time_column(table)]), **row}
