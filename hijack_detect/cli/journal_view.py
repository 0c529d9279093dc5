"""What the command `journal` prints."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rich.console import Console
from rich.table import Table

from hijack_detect.recording import schema
from hijack_detect.recording.journal_export import utc
from hijack_detect.recording.journal_query import JournalReader, Query
from hijack_detect.recording.sqlite_file import files_of

FEW = 10
HIDDEN = ("id", "session", "received_ns", "name", "removed")
"""Columns that only an export has."""


def overview(reader: JournalReader) -> None:
    """Print what is in a journal: tables, sessions, alerts and snapshots."""
    console = Console(highlight=False)
    size = sum(file.stat().st_size for file in files_of(reader.path))
    console.print(f"{reader.path}: {size / 1e6:.1f} MB", soft_wrap=True)
    table = Table("table", "rows", "from (UTC)", "to (UTC)")
    table.columns[1].justify = "right"
    for name in schema.TABLES:
        found = reader.summary(name)
        table.add_row(name, str(found.rows), utc(found.first_ns), utc(found.last_ns))
    console.print(table)
    for name in ("sessions", "alerts", "snapshots"):
        if reader.summary(name).rows:
            show_rows(reader, Query(name), FEW)


def show_rows(reader: JournalReader, query: Query, most: int) -> None:
    """Print rows as a table; the last `most` of them if the query does not say how many."""
    chosen = query if query.limit or query.last else replace(query, last=most)
    rows = deque(reader.rows(chosen))
    console = Console(highlight=False)
    total = reader.count(query)
    if not rows:
        console.print(f"no {query.table} that fit")
        return
    of_all = f", {len(rows)} of {total}" if len(rows) < total else ""
    time = schema.time_column(query.table)
    columns = [c for c in schema.TABLES[query.table] if c not in HIDDEN and c != time]
    table = Table(title=f"{query.table}{of_all}", title_justify="left")
    table.add_column("time (UTC)", no_wrap=True)
    for column in columns:
        table.add_column(column.removesuffix("_ns"), overflow="fold", no_wrap=column == "path")
    for row in rows:
        table.add_row(utc(row[time]), *(_shown(query.table, column, row) for column in columns))
    console.print(table)


def _shown(table: str, column: str, row: Mapping[str, Any]) -> str:
    value = row[column]
    if value is None:
        return "running or killed" if column == "ended_ns" else ""
    if column.endswith("_ns"):
        return utc(value)
    if column in ("alert", "complete"):
        return "yes" if value else "no"
    if column == "path" and row["removed"]:
        return f"{value} (removed)"
    if column in ("latitude_deg", "longitude_deg"):
        return f"{value:.7f}"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
