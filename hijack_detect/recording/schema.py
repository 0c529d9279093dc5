# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Tables of the journal, as its writer and its readers know them."""

from __future__ import annotations

APPLICATION_ID = 0x484A4443
"""Marks the file as a journal of this package ("HJDC")."""
VERSION = 1
"""Version of the tables, in `PRAGMA user_version`."""
FILE = "journal.sqlite3"

_COMMON = {"session": "INTEGER NOT NULL", "received_ns": "INTEGER NOT NULL"}
_STAMPED = {**_COMMON, "stamp_ns": "INTEGER"}

TABLES: dict[str, dict[str, str]] = {
    "sessions": {
        "started_ns": "INTEGER NOT NULL",
        "ended_ns": "INTEGER",
        "node": "TEXT NOT NULL",
        "version": "TEXT NOT NULL",
    },
    "alerts": {
        **_STAMPED,
        "alert": "INTEGER NOT NULL",
        "state": "TEXT NOT NULL",
        "alert_since_ns": "INTEGER",
        "confidence": "REAL",
        "causes": "TEXT NOT NULL",
        "lost": "TEXT NOT NULL",
        "reason": "TEXT NOT NULL",
    },
    "snapshots": {
        **_STAMPED,
        "name": "TEXT NOT NULL UNIQUE",
        "path": "TEXT NOT NULL",
        "from_ns": "INTEGER NOT NULL",
        "until_ns": "INTEGER NOT NULL",
        "messages": "INTEGER NOT NULL",
        "bytes": "INTEGER NOT NULL",
        "alerts": "INTEGER NOT NULL",
        "complete": "INTEGER NOT NULL",
        "removed": "INTEGER NOT NULL DEFAULT 0",
    },
    "verdicts": {
        **_STAMPED,
        "detector": "TEXT NOT NULL",
        "state": "TEXT NOT NULL",
        "score": "REAL NOT NULL",
        "threshold": "REAL NOT NULL",
        "reason": "TEXT NOT NULL",
        "numbers": "TEXT NOT NULL",
    },
    "fixes": {
        **_STAMPED,
        "latitude_deg": "REAL",
        "longitude_deg": "REAL",
        "altitude_m": "REAL",
        "status": "INTEGER NOT NULL",
        "variance_east": "REAL",
        "variance_north": "REAL",
        "variance_up": "REAL",
    },
    "velocities": {**_STAMPED, "east": "REAL", "north": "REAL", "up": "REAL"},
    "satellites": {**_STAMPED, "count": "INTEGER NOT NULL"},
    "events": {**_COMMON, "kind": "TEXT NOT NULL", "text": "TEXT NOT NULL"},
}
"""Columns with their types; before them each table has `id`, which grows.

`received_ns` is the wall clock of the recorder, `stamp_ns` the header stamp of the message; both
in nanoseconds since 1970. A number that is no number is NULL. `numbers` is a JSON object.
"""

BULK = ("fixes", "velocities", "satellites", "verdicts")
"""Tables that make room for new rows."""
KEPT = ("events", "alerts", "snapshots", "sessions")
"""Tables that make room only when nothing is left in the others, in this order."""


def create() -> list[str]:
    """Statements that make all tables."""
    return [
        f"CREATE TABLE {name} (id INTEGER PRIMARY KEY AUTOINCREMENT, "
        + ", ".join(f"{column} {kind}" for column, kind in columns.items())
        + ")"
        for name, columns in TABLES.items()
    ]


def insert(table: str) -> str:
    """Statement that adds a row; a snapshot that is there already is brought up to date."""
    columns = [name for name in TABLES[table] if name != "removed"]
    statement = (
        f"INSERT INTO {table} ({', '.join(columns)}) VALUES ({', '.join('?' * len(columns))})"
    )
    if table != "snapshots":
        return statement
    later = ("path", "from_ns", "until_ns", "messages", "bytes", "alerts", "complete")
    changes = ", ".join(f"{column} = excluded.{column}" for column in later)
    return f"{statement} ON CONFLICT (name) DO UPDATE SET {changes}"


def time_column(table: str) -> str:
    """The column by which rows of a table are chosen and shown."""
    if table == "sessions":
        return "started_ns"
    return "stamp_ns" if "stamp_ns" in TABLES[table] else "received_ns"
