# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The journal: one SQLite file that survives SIGKILL and stays inside its bound on disk.

Write-ahead logging with a flush at every commit: a row that was committed survives a loss of
power, one that was not leaves no trace. The bound holds for the file, its log and its index: the
file may not have more pages than its share, old rows are deleted before new ones need theirs, and
the log is emptied into the file before it has grown over its share.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from hijack_detect.recording import schema
from hijack_detect.recording.problems import JournalError
from hijack_detect.recording.rows import Row

ERRORS = (sqlite3.Error, UnicodeDecodeError)
"""Errors of SQLite; the latter where its message on the damage is no text."""


class Transaction:
    """Commits when its block ends, and takes everything back when it fails."""

    def __init__(self, database: sqlite3.Connection) -> None:
        self._database = database

    def __enter__(self) -> None:
        self._database.execute("BEGIN IMMEDIATE")

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            try:
                self._database.execute("COMMIT")
                return
            except sqlite3.Error:
                self._undo()
                raise
        self._undo()

    def _undo(self) -> None:
        if self._database.in_transaction:
            self._database.execute("ROLLBACK")


def is_damage(error: Exception) -> bool:
    """Whether an error means that the content of the file is not that of a database."""
    if isinstance(error, UnicodeDecodeError):
        return True
    text = str(error)
    words = ("malformed", "not a database", "unsupported file format", "not decode to UTF-8")
    return isinstance(error, sqlite3.DatabaseError) and any(one in text for one in words)


def files_of(path: Path) -> Iterator[Path]:
    """The files that belong to a database, those that exist."""
    for suffix in ("", "-wal", "-shm"):
        one = Path(f"{path}{suffix}")
        if one.exists():
            yield one


PAGE_BYTES = 4096
"""SQLite: its default."""
LOG_BYTES = 8_000_000
"""Largest write-ahead log. Chosen, not swept; SQLite empties its own at 4 MB."""
INDEX_BYTES = 65_536
"""Share of journal.sqlite3-shm. SQLite: 32 kB for each 4096 pages of the log."""
LOCK_WAIT_S = 0.1
"""Timeout of a lock. Chosen: a reader locks the file for moments, and a tick has 0.1 s."""
PRUNE_ROWS = 500
"""Rows deleted at once. Chosen: small, so that one deletion never fills the log."""


class AlienFileError(JournalError):
    """The file is damaged, or not a journal."""


@dataclass(frozen=True)
class Session:
    """One run of a recorder. `started_ns` is the wall clock, nanoseconds."""

    started_ns: int
    node: str
    version: str


class Journal:
    """An open journal that one process writes.

    Every method can raise `sqlite3.Error`; then the journal is closed and opened again.
    """

    def __init__(self, path: Path, max_bytes: int, session: Session) -> None:
        """Open or make the file.

        Raises:
            JournalError: It was written by a newer version.
            AlienFileError: It is damaged or not a journal.
            sqlite3.Error: It cannot be written.
        """
        self.path = path
        self._session = session
        self._session_id: int | None = None
        self._log_bytes = min(LOG_BYTES, max_bytes // 4)
        self._max_pages = (max_bytes - self._log_bytes - INDEX_BYTES) // PAGE_BYTES
        self.max_transaction_bytes = self._log_bytes // 8
        """Rows of one call of `write` should not be larger."""
        self._database = sqlite3.connect(path, timeout=LOCK_WAIT_S, isolation_level=None)
        try:
            self._prepare()
            self._inode = path.stat().st_ino
        except BaseException:
            self._database.close()
            raise

    def _prepare(self) -> None:
        run = self._database.execute
        try:
            (application,) = run("PRAGMA application_id").fetchone()
            (version,) = run("PRAGMA user_version").fetchone()
            (tables,) = run("SELECT count(*) FROM sqlite_master").fetchone()
        except ERRORS as error:
            if not is_damage(error):
                raise
            raise AlienFileError(f"{self.path}: is damaged or not a database") from error
        if tables and application != schema.APPLICATION_ID:
            raise AlienFileError(f"{self.path}: is a database, but not a journal")
        if version > schema.VERSION:
            raise JournalError(
                f"{self.path}: was written by a newer version (schema {version}, this one knows "
                f"{schema.VERSION}); update this package, or choose another folder"
            )
        if not tables:
            run(f"PRAGMA page_size = {PAGE_BYTES}")
            run("PRAGMA auto_vacuum = INCREMENTAL")
        elif version == schema.VERSION and not set(schema.create()) <= self._statements():
            raise AlienFileError(f"{self.path}: is damaged, its tables are not those of a journal")
        run("PRAGMA journal_mode = WAL")
        run("PRAGMA synchronous = FULL")
        run("PRAGMA wal_autocheckpoint = 0")
        run(f"PRAGMA max_page_count = {self._max_pages}")
        if not tables:
            with self._transaction():
                for statement in schema.create():
                    run(statement)
                run(f"PRAGMA application_id = {schema.APPLICATION_ID}")
                run(f"PRAGMA user_version = {schema.VERSION}")

    def _statements(self) -> set[str]:
        """The statements in the file that made its tables."""
        found = self._database.execute("SELECT sql FROM sqlite_master WHERE type = 'table'")
        return {str(statement) for (statement,) in found}

    @property
    def size(self) -> int:
        """Bytes on disk of the file, its log and its index."""
        return sum(
            path.stat().st_size
            for suffix in ("", "-wal", "-shm")
            if (path := Path(f"{self.path}{suffix}")).exists()
        )

    @property
    def gone(self) -> bool:
        """Whether somebody has deleted or replaced the file."""
        try:
            return self.path.stat().st_ino != self._inode
        except FileNotFoundError:
            return True

    def write(self, rows: Sequence[Row]) -> None:
        """Add rows, all or none.

        Raises:
            sqlite3.Error: They could not be written; then none is.
        """
        self._make_room(sum(row.size for row in rows))
        with self._transaction():
            session = self._session_number()
            for table, of_table in groupby(rows, key=lambda row: row.table):
                self._database.executemany(
                    schema.insert(table), [(session, *row.values) for row in of_table]
                )

    def mark_removed(self, paths: Sequence[str]) -> None:
        """Note that snapshots are about to be deleted, given the paths in their rows."""
        with self._transaction():
            self._database.executemany(
                "UPDATE snapshots SET removed = 1 WHERE path = ?", [(path,) for path in paths]
            )

    def snapshot_paths(self) -> set[str]:
        """Paths in the rows of snapshots that are not deleted."""
        found = self._database.execute("SELECT path FROM snapshots WHERE NOT removed")
        return {path for (path,) in found}

    def end_session(self, ended_ns: int) -> None:
        """Note that the recorder stopped in order."""
        with self._transaction():
            self._database.execute(
                "UPDATE sessions SET ended_ns = ? WHERE id = ?", (ended_ns, self._session_number())
            )

    def tidy(self, oldest_ns: int | None = None) -> None:
        """Delete rows received before a time, and empty the log if it has grown.

        Raises:
            sqlite3.Error: Among others while another program reads for too long: then the log
                cannot be emptied, and nothing more should be written.
        """
        if oldest_ns is not None:
            for table in schema.BULK:
                self._prune(table, "AND received_ns < ?", oldest_ns)
        self._empty_log()

    def close(self) -> None:
        """Close the file; the log is emptied into it."""
        self._database.close()

    def _session_number(self) -> int:
        if self._session_id is None:
            one = self._session
            run = self._database.execute
            found = run(
                "SELECT id FROM sessions WHERE started_ns = ? AND node = ?",
                (one.started_ns, one.node),
            ).fetchone()
            if found is None:
                values = (one.started_ns, None, one.node, one.version)
                self._session_id = run(schema.insert("sessions"), values).lastrowid
            else:
                self._session_id = int(found[0])
        assert self._session_id is not None
        return self._session_id

    def _make_room(self, wanted_bytes: int) -> None:
        """Delete the oldest rows until `wanted_bytes` have room in the file."""
        wanted = 2 * wanted_bytes // PAGE_BYTES + len(schema.TABLES) + 16
        while self._used_pages() + wanted > self._max_pages and self._prune_oldest():
            self._empty_log()
        (pages,) = self._database.execute("PRAGMA page_count").fetchone()
        while pages > self._max_pages:  # the bound was larger in another run
            self._database.execute("PRAGMA incremental_vacuum(256)").fetchall()
            self._empty_log()
            before, (pages,) = pages, self._database.execute("PRAGMA page_count").fetchone()
            if pages >= before:
                return

    def _used_pages(self) -> int:
        (pages,) = self._database.execute("PRAGMA page_count").fetchone()
        (free,) = self._database.execute("PRAGMA freelist_count").fetchone()
        return int(pages) - int(free)

    def _prune_oldest(self) -> bool:
        """Delete rows of the table with the oldest row; return whether there were any."""
        heads = [(head, table) for table in schema.BULK if (head := self._head(table)) is not None]
        if heads:
            return self._prune(min(heads)[1])
        return any(self._head(table) is not None and self._prune(table) for table in schema.KEPT)

    def _head(self, table: str) -> int | None:
        column = "started_ns" if table == "sessions" else "received_ns"
        found = self._database.execute(f"SELECT {column} FROM {table} ORDER BY id LIMIT 1")
        head = found.fetchone()
        return None if head is None else int(head[0])

    def _prune(self, table: str, condition: str = "", *values: int) -> bool:
        oldest = f"SELECT id FROM {table} ORDER BY id LIMIT {PRUNE_ROWS}"
        with self._transaction():
            done = self._database.execute(
                f"DELETE FROM {table} WHERE id IN ({oldest}) {condition}", values
            )
        return done.rowcount > 0

    def _empty_log(self) -> None:
        log = Path(f"{self.path}-wal")
        size = log.stat().st_size if log.exists() else 0
        if size <= self._log_bytes // 2:
            return
        (busy, _, _) = self._database.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()
        if busy and size > self._log_bytes * 3 // 4:
            raise sqlite3.OperationalError(
                "database is locked by another program that has been reading for too long"
            )

    def _transaction(self) -> Transaction:
        return Transaction(self._database)
