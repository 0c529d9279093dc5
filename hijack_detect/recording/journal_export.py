# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Rows of a journal as CSV or JSON, written one by one; and times as people read them."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Mapping
from datetime import datetime, timedelta, timezone
from decimal import Decimal, InvalidOperation
from typing import Any, TextIO

from hijack_detect.recording import schema

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
    """A time given as ISO 8601 (UTC unless it says otherwise) or as seconds since 1970.

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
