# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""CSV files, with a column map that says what their columns are."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from hijack_detect.bags.errors import BagError
from hijack_detect.logs.csv_map import ColumnMap
from hijack_detect.logs.csv_source import Header, Source
from hijack_detect.logs.csv_table import Form, named_columns, rows
from hijack_detect.logs.logged import Logged, Notes, Read, Wanted

FORMAT = "CSV"


def reader(columns: ColumnMap) -> Read:
    """The reader of tables that a map describes."""
    return partial(_read, columns)


def _read(columns: ColumnMap, path: Path, wanted: Wanted, notes: Notes) -> Iterator[Logged]:
    """Read a file, or the files of a folder that the map names; see `Read`."""
    if wanted.imu or wanted.gps:
        raise BagError(f"{path}: of a CSV the map says which sensors are taken, not --imu or --gps")
    inputs = columns.inputs.given()
    if not any(one.utc for one in (columns.time, inputs["imu"].time) if one is not None):
        notes.said.append("the times do not say UTC: stamps count from the autopilot's start")
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
        source.tell(notes)


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
