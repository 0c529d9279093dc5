# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""CSV files, read by a column map."""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from hijack_detect.bags.errors import BagError
from hijack_detect.logs.csv_inputs import Fix, Input
from hijack_detect.logs.csv_map import ColumnMap
from hijack_detect.logs.csv_table import Form, named_columns, rows
from hijack_detect.logs.csv_units import nanoseconds
from hijack_detect.logs.csv_words import Column, HasFix, Time
from hijack_detect.logs.logged import Logged, Notes, Read, Selection
from hijack_detect.streams.messages import Limited, limited
from hijack_detect.streams.samples import NANOSECONDS, Quaternion, Sample

WORDS = {
    "angular_velocity": "gyro",
    "linear_acceleration": "accel",
    "magnetic_field": "field",
    "fluid_pressure": "pressure",
    "satellites": "count",
}
"""Names of fields of messages in a column map, where they differ."""


def impossible(reading: Sample | Quaternion) -> str:
    """The field of a reading that no sensor can measure; empty without one."""
    for field, value, unit, low, high in _numbers(reading):
        if not low <= value <= high:
            name = field.split(".")[0]
            shown = f"{value:g} {unit}, beyond {low:g} to {high:g}"
            return f"{WORDS.get(name, name)} would be {shown}"
    return ""


def _numbers(reading: Sample | Quaternion) -> Iterator[Limited]:
    if not isinstance(reading, tuple):
        yield from limited(reading)
        return
    for value in reading:
        yield Limited("quaternion", value, "", -1.001, 1.001)


TRUE, FALSE = ("true", "yes"), ("false", "no")


class _BadRow(ValueError):
    """A row that gives no reading; why, and in which column."""


@dataclass(frozen=True)
class Header:
    """Finds columns by name or number.

    Attributes:
        path: The file, for errors.
        names: Names of the columns, in order.
        form: How the file is written.
    """

    path: Path
    names: Sequence[str]
    form: Form

    def place(self, column: Column, what: str) -> int:
        """Where a column is in a row.

        Raises:
            BagError: There is no such column, or several.
        """
        if isinstance(column, int):
            if column > len(self.names):
                raise BagError(f"{self.path}: {what}: has no column {column}, only {self._all()}")
            return column - 1
        found = [at for at, name in enumerate(self.names) if name == column]
        if len(found) == 1:
            return found[0]
        if found:
            numbers = ", ".join(str(at + 1) for at in found)
            raise BagError(
                f"{self.path}: {what}: several columns are called {column!r}: give a number "
                f"({numbers}) in place of the name"
            )
        raise BagError(f"{self.path}: {what}: has no column {column!r}; it has {self._all()}")

    def _all(self) -> str:
        return ", ".join(self.names) if self.form.header else f"{len(self.names)} columns"


class Source:
    """The readings of one input; see `logged` and `report`."""

    def __init__(self, name: str, given: Input, time: Time, header: Header, decimal: str) -> None:
        """Find its columns.

        Raises:
            BagError: One is not there.
        """
        what = f"inputs.{name}"
        self._name, self._given, self._header, self._decimal = name, given, header, decimal
        self._time = time
        self._time_at = header.place(time.column, what)
        self._at = [header.place(column, what) for column in given.columns()]
        self._has_fix: HasFix | None = given.has_fix if isinstance(given, Fix) else None
        self._has_fix_at = -1
        if self._has_fix is not None:
            self._has_fix_at = header.place(self._has_fix.column, what)
        flags = [] if self._has_fix is None else [self._has_fix_at]
        own_time = [] if given.time is None else [self._time_at]
        self._compared = [*self._at, *flags, *own_time]
        self._before: list[str] = []
        self._last_ns = -1
        self._bad: Counter[str] = Counter()
        self._first_bad: dict[str, str] = {}
        self._taken = self._same = self._backwards = 0
        self._first_backwards = ""

    def logged(self, line: int, row: list[str]) -> Logged | None:
        """The reading of a row, None if it has none or is bad, which is counted."""
        try:
            found = self._reading(row)
        except _BadRow as error:
            column, _, why = str(error).partition(": ")
            key = f"{self._header.path.name}: {self._name}: column {column}"
            self._bad[key] += 1
            self._first_bad.setdefault(key, f"line {line}, column {column}: {why}")
            return None
        if found is None:
            return None
        self._taken += 1
        if found.stamp_ns < self._last_ns:
            back_s = (self._last_ns - found.stamp_ns) / NANOSECONDS
            self._first_backwards = self._first_backwards or f"line {line}, by {back_s:g} s"
            self._backwards += 1
        self._last_ns = found.stamp_ns
        return found

    def report(self, notes: Notes) -> None:
        """Note the rows that were left out, once all were read.

        Raises:
            BagError: No row has given a reading.
        """
        path = self._header.path
        if not self._taken:
            first = "; ".join(self._first_bad.values())
            why = f"all are bad: {first}" if first else "its columns are empty in every row"
            raise BagError(f"{path}: no row gives a reading of {self._name}: {why}")
        for key, count in self._bad.items():
            notes.skipped[f"{key}: bad rows, first {self._first_bad[key]}"] += count
        if self._same:
            notes.skipped[f"{path.name}: {self._name}: rows that repeat the one before"] += (
                self._same
            )
        if self._backwards:
            notes.remarks.append(
                f"{path.name}: time of {self._name} goes backwards {self._backwards} times, first "
                f"in {self._first_backwards}"
            )

    def _reading(self, row: list[str]) -> Logged | None:
        texts = [row[at].strip() if at < len(row) else "" for at in self._compared]
        values = texts[: len(self._at)]
        flag = texts[len(self._at)] if self._has_fix is not None else ""
        has_fix = self._fix_flag(flag) if flag else self._has_fix is None
        needed = values[: len(values) - self._given.optional]
        if (has_fix and not all(needed)) or (not has_fix and not flag):
            return None
        if self._given.when_changed:
            if texts == self._before:
                self._same += 1
                return None
            self._before = texts
        stamp_ns = self._stamp_ns(row)
        if not has_fix:
            assert isinstance(self._given, Fix)
            return self._given.none(stamp_ns)
        numbers = [
            self._number(at, text) if text else math.nan
            for at, text in zip(self._at, values, strict=True)
        ]
        found = self._given.logged(stamp_ns, numbers)
        if why := impossible(found.value):
            names = [self._label(at) for at in self._at]
            raise _BadRow(f"{'/'.join(dict.fromkeys(names))}: {why}: are unit and column right?")
        return found

    def _stamp_ns(self, row: list[str]) -> int:
        text = row[self._time_at].strip() if self._time_at < len(row) else ""
        written = text.replace(",", ".") if self._decimal == "," else text
        try:
            return nanoseconds(written, self._time.unit)
        except ValueError as error:
            raise _BadRow(f"{self._label(self._time_at)}: {text!r} {error}") from error

    def _number(self, at: int, text: str) -> float:
        try:
            value = float(text.replace(",", ".") if self._decimal == "," else text)
        except ValueError as error:
            advice = ": is the decimal a comma?" if "," in text else ""
            raise _BadRow(f"{self._label(at)}: {text!r} is no number{advice}") from error
        if not math.isfinite(value):
            raise _BadRow(f"{self._label(at)}: {text!r} is not finite")
        return value

    def _fix_flag(self, text: str) -> bool:
        assert self._has_fix is not None
        if text.lower() in (*TRUE, *FALSE):
            return text.lower() in TRUE
        return self._number(self._has_fix_at, text) >= self._has_fix.at_least

    def _label(self, at: int) -> str:
        return self._header.names[at]


FORMAT = "CSV"


def reader(columns: ColumnMap) -> Read:
    """The reader of tables that a map describes."""
    return partial(_read, columns)


def _read(columns: ColumnMap, path: Path, selection: Selection, notes: Notes) -> Iterator[Logged]:
    """Read a file, or the files of a folder that the map names; see `Read`."""
    if selection.imu or selection.gps:
        raise BagError(f"{path}: of a CSV the map says which sensors are taken, not --imu or --gps")
    inputs = columns.inputs.given()
    if not any(one.utc for one in (columns.time, inputs["imu"].time) if one is not None):
        notes.remarks.append("the times do not say UTC: stamps count from the autopilot's start")
    form = Form(columns.delimiter, columns.comment, columns.encoding, columns.header)
    names: dict[Path, list[str]] = {}
    for name, given in inputs.items():
        names.setdefault(_file(path, name, given.file), []).append(name)
    streams = []
    for file, of in names.items():
        labels, _ = named_columns(file, form)
        header = Header(file, labels, form)
        sources = []
        for name in of:
            time = inputs[name].time or columns.time
            assert time is not None
            sources.append(Source(name, inputs[name], time, header, columns.decimal))
        streams.append(_logged(file, form, sources, notes))
    yield from heapq.merge(*streams, key=lambda one: one.stamp_ns)


def _logged(file: Path, form: Form, sources: list[Source], notes: Notes) -> Iterator[Logged]:
    table = rows(file, form)
    if form.header:
        next(table, None)
    for line, row in table:
        for source in sources:
            if (found := source.logged(line, row)) is not None:
                yield found
    for source in sources:
        source.report(notes)


def _file(path: Path, name: str, given: str | None) -> Path:
    """The file of an input.

    Raises:
        BagError: There is none.
    """
    if given is None and path.is_dir():
        raise BagError(f"{path}: is a folder: inputs.{name} of the map has to name its file")
    file = path if given is None else (path if path.is_dir() else path.parent) / given
    if not file.is_file():
        raise BagError(f"{file}: is not there; inputs.{name} of the map names it")
    return file
