# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What SQLite leaves to its users: transactions, and which files and errors belong to it."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path

ERRORS = (sqlite3.Error, UnicodeDecodeError)
"""What SQLite raises; the latter where its words on the damage are none."""


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
