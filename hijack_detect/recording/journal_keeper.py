# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A journal that stays open: batches, retries, and a damaged file moved out of the way."""

from __future__ import annotations

import sqlite3
from collections import Counter, deque
from contextlib import suppress
from datetime import datetime, timezone
from itertools import islice
from pathlib import Path

from hijack_detect.recording import schema
from hijack_detect.recording.journal import (
    ERRORS,
    AlienFileError,
    Journal,
    Session,
    files_of,
    is_damage,
)
from hijack_detect.recording.problems import JournalError, problem_text
from hijack_detect.recording.rows import Row

MAX_BULK = 20_000
"""Rows kept while the disk takes none. Chosen: half an hour with two detectors, some megabytes."""
MAX_KEPT = 1000
"""The same of alerts, snapshots and events. Chosen: far above those of one flight."""


class RowQueue:
    """Waiting rows; while the disk takes none the oldest are dropped and counted.

    Alerts, snapshots and events wait apart from the many others, and are written first.

    Attributes:
        dropped: Rows dropped, by table.
    """

    def __init__(self) -> None:
        self._kept: deque[Row] = deque()
        self._bulk: deque[Row] = deque()
        self.dropped: Counter[str] = Counter()

    def __len__(self) -> int:
        return len(self._kept) + len(self._bulk)

    def add(self, row: Row) -> None:
        """Add a row."""
        bulk = row.table in schema.BULK
        queue, most = (self._bulk, MAX_BULK) if bulk else (self._kept, MAX_KEPT)
        queue.append(row)
        if len(queue) > most:
            self.dropped[queue.popleft().table] += 1

    def first(self, max_bytes: int) -> list[Row]:
        """The rows to be written next, of about `max_bytes`, at least one if there are any."""
        chosen: list[Row] = []
        size = 0
        queue = self._kept or self._bulk
        for row in islice(queue, MAX_BULK):
            size += row.size
            if chosen and size > max_bytes:
                break
            chosen.append(row)
        return sorted(chosen, key=lambda row: row.table)

    def remove(self, count: int) -> None:
        """Forget the first `count` rows of `first`: they are written."""
        queue = self._kept or self._bulk
        for _ in range(count):
            queue.popleft()


RETRY_S = 3.0
"""Period of retries, as in problems.py."""
COMMIT_S = 0.4
"""Longest wait of a row for its commit. Chosen: with a tick of 0.1 s half a second is lost at
most; each commit flushes the disk."""
COMMIT_ROWS = 2000
"""Waiting rows that are committed at once. Chosen, not swept."""
_ERRORS = (*ERRORS, OSError, JournalError)


class JournalKeeper:
    """A writer of rows that waits for a disk that takes none. Nothing is raised.

    Attributes:
        problem: Why nothing can be written at the moment, in one sentence; empty if it can.
        notes: Other events, one sentence each; the caller removes them.
        written: Rows written, by table.
    """

    def __init__(self, path: Path, max_bytes: int, max_age_ns: int, session: Session) -> None:
        self.path = path
        self._max_bytes, self._max_age_ns, self._session = max_bytes, max_age_ns, session
        self._journal: Journal | None = None
        self._queue = RowQueue()
        self._oldest_s: float | None = None
        self._not_before_s = 0.0
        self.problem = ""
        self.notes: list[str] = []
        self.written: Counter[str] = Counter()

    @property
    def dropped(self) -> Counter[str]:
        """Rows dropped because too many were waiting for the disk, by table."""
        return self._queue.dropped

    @property
    def waiting(self) -> int:
        """Rows that are not written yet."""
        return len(self._queue)

    @property
    def size(self) -> int:
        """Bytes of the journal on disk; 0 if it is not open."""
        try:
            return 0 if self._journal is None else self._journal.size
        except OSError:
            return 0

    def add(self, row: Row, wall_s: float) -> None:
        """Take a row, at a time of a steady clock in seconds."""
        self._queue.add(row)
        if self._oldest_s is None:
            self._oldest_s = wall_s

    def tick(self, wall_s: float, wall_ns: int) -> None:
        """Commit what has waited for long enough; to be called ten times a second."""
        old = self._oldest_s is not None and wall_s - self._oldest_s >= COMMIT_S
        if old or self.waiting > COMMIT_ROWS or self.problem or self._journal is None:
            self.commit(wall_s, wall_ns)

    def commit(self, wall_s: float, wall_ns: int, *, retry: bool = False) -> bool:
        """Commit everything now; return whether it is on disk.

        Args:
            wall_s: A steady clock, seconds.
            wall_ns: The wall clock, nanoseconds.
            retry: Whether to try although the last attempt failed a moment ago.
        """
        if wall_s < self._not_before_s and not retry:
            return False
        try:
            journal = self._opened(wall_ns)
            while rows := self._queue.first(journal.max_transaction_bytes):
                journal.write(rows)
                self._queue.remove(len(rows))
                self.written.update(row.table for row in rows)
            self._oldest_s = None
            journal.tidy(wall_ns - self._max_age_ns if self._max_age_ns else None)
        except _ERRORS as error:
            self._failed(error, wall_s, wall_ns)
            return not self._queue
        self.problem = ""
        return True

    def mark_removed(self, paths: list[str], wall_s: float, wall_ns: int) -> bool:
        """Note that snapshots are about to be deleted; return whether that is on disk."""
        if not self.commit(wall_s, wall_ns) or self._journal is None:
            return False
        try:
            self._journal.mark_removed(paths)
        except _ERRORS as error:
            self._failed(error, wall_s, wall_ns)
            return False
        return True

    def snapshot_paths(self, wall_s: float, wall_ns: int) -> set[str] | None:
        """Paths of the snapshots that the journal lists; None if it cannot be read."""
        if not self.commit(wall_s, wall_ns) or self._journal is None:
            return None
        try:
            return self._journal.snapshot_paths()
        except _ERRORS as error:
            self._failed(error, wall_s, wall_ns)
            return None

    def close(self, wall_s: float, wall_ns: int) -> None:
        """Commit what waits, note the end of the session, and close the file."""
        self.commit(wall_s, wall_ns, retry=True)
        if self._journal is not None:
            with suppress(*_ERRORS):
                self._journal.end_session(wall_ns)
        self._close()

    def _opened(self, wall_ns: int) -> Journal:
        if self._journal is not None and self._journal.gone:
            self.notes.append(f"{self.path}: was deleted or replaced; a new journal is begun")
            self._close()
        if self._journal is None:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            try:
                self._journal = Journal(self.path, self._max_bytes, self._session)
            except AlienFileError as error:
                self._move_aside(error, wall_ns)
                self._journal = Journal(self.path, self._max_bytes, self._session)
        return self._journal

    def _failed(self, error: Exception, wall_s: float, wall_ns: int) -> None:
        self._close()
        self.problem = problem_text(self.path, error)
        self._not_before_s = wall_s + RETRY_S
        if is_damage(error):
            with suppress(OSError):
                self._move_aside(error, wall_ns)

    def _move_aside(self, error: Exception, wall_ns: int) -> None:
        moment = datetime.fromtimestamp(wall_ns // 10**9, timezone.utc)
        name = f"{self.path.name}.damaged-{moment:%Y%m%dT%H%M%SZ}"
        for file in files_of(self.path):
            suffix = file.name.removeprefix(self.path.name)
            file.rename(self.path.with_name(name + suffix))
        self.notes.append(
            f"{problem_text(self.path, error)}; moved aside as {name}, a new one is begun"
        )

    def _close(self) -> None:
        if self._journal is not None:
            with suppress(sqlite3.Error):
                self._journal.close()
            self._journal = None
