# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Output of the command `journal`."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.table import Table

from hijack_detect.recording import schema
from hijack_detect.recording.journal import files_of
from hijack_detect.recording.journal_reader import JournalReader, Query, utc

FEW = 10
HIDDEN = ("session", "received_ns", "variance_east", "variance_north", "variance_up")
"""Columns that only an export has."""
Row = Mapping[str, Any]


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
    """Print rows; the last `most` of them if the query gives no number."""
    chosen = query if query.limit or query.last else replace(query, last=most)
    rows = deque(reader.rows(chosen))
    console = Console(highlight=False)
    total = reader.count(query)
    if not rows:
        console.print(f"no {query.table} that fit")
        return
    of_all = f", {len(rows)} of {total}" if len(rows) < total else ""
    title = f"{query.table}{of_all}"
    if query.table in HEADLINES:
        _print_entries(console, title, query.table, rows)
    else:
        _print_table(console, title, query.table, rows)


def _alert(row: Row) -> str:
    text = f"ALERT by {row['causes']}" if row["alert"] else "no alert"
    lost = f", silent: {row['lost']}" if row["lost"] else ""
    known = row["confidence"] is not None
    confidence = f"confidence {row['confidence']:.2f}" if known else "no confidence"
    return f"{text}, {row['state']}, {confidence}{lost}"


def _snapshot(row: Row) -> str:
    seconds = (row["until_ns"] - row["from_ns"]) / 1e9
    whole = "" if row["complete"] else ", not whole: the time after the alert is missing"
    gone = ", removed to make room" if row["removed"] else ""
    return f"{seconds:.1f} s, {row['messages']} messages{whole}{gone}"


HEADLINES: dict[str, tuple[Callable[[Row], str], str]] = {
    "alerts": (_alert, "reason"),
    "snapshots": (_snapshot, "path"),
    "verdicts": (
        lambda row: (
            f"{row['detector']} {row['state']}, {row['score']:.4g} of {row['threshold']:.4g}"
        ),
        "reason",
    ),
    "events": (lambda row: str(row["kind"]), "text"),
}
"""Tables with a long text: what stands beside the time, and the column of the text below it."""


def _print_entries(console: Console, title: str, table: str, rows: Iterable[Row]) -> None:
    headline, text = HEADLINES[table]
    console.print(title, style="italic")
    for row in rows:
        console.print(f"  {utc(row[schema.time_column(table)])}  {headline(row)}", soft_wrap=True)
        if text == "path":
            console.print(f"      {row[text]}", soft_wrap=True)
        else:
            console.print(Padding(str(row[text]), (0, 0, 0, 6)))


def _print_table(console: Console, title: str, table: str, rows: Iterable[Row]) -> None:
    time = schema.time_column(table)
    columns = [c for c in schema.TABLES[table] if c not in HIDDEN and c != time]
    drawn = Table(title=title, title_justify="left")
    drawn.add_column("time (UTC)", no_wrap=True)
    for column in columns:
        drawn.add_column(column.removesuffix("_ns").replace("_", ", "), overflow="fold")
    for row in rows:
        drawn.add_row(utc(row[time]), *(_shown(column, row[column]) for column in columns))
    console.print(drawn)


def _shown(column: str, value: Any) -> str:
    if value is None:
        return "running or killed" if column == "ended_ns" else ""
    if column.endswith("_ns"):
        return utc(value)
    if column in ("latitude_deg", "longitude_deg"):
        return f"{value:.7f}"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
