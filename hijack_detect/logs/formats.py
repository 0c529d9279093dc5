# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which format a file has, and a bag made of it."""

from __future__ import annotations

import contextlib
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.topics import PRESETS
from hijack_detect.bags.writer import BagWriter
from hijack_detect.logs import csv_log, dataflash, mcap, rosbag, tlog, ulog
from hijack_detect.logs.csv_map import ColumnMap
from hijack_detect.logs.csv_table import guessed_form
from hijack_detect.logs.csv_template import advice, known_map
from hijack_detect.logs.logged import ATTITUDE, Notes, Read, Selection

SQLITE = b"SQLite format 3"
TEXT, TEXT_LINE = b"FMT, ", b"\nFMT, 128, 89, FMT, "
MAGICS: dict[bytes, tuple[str, Read]] = {
    b"ULog\x01\x12\x35": ("PX4 ULog", ulog.read),
    dataflash.MAGIC: ("ArduPilot DataFlash", dataflash.read),
    TEXT: ("ArduPilot DataFlash as text", dataflash.read),
    b"#ROSBAG V2.0": ("ROS 1 bag", rosbag.read),
    SQLITE: ("ROS 2 bag in sqlite3", rosbag.read),
}
"""Name and reader of the formats that files begin with."""
TLOG = ("MAVLink telemetry log", tlog.read)
MCAP = b"\x89MCAP0\r\n"
CSV = (csv_log.FORMAT, "with --columns")
TABLES = (".csv", ".tsv", ".txt")
BANNER_BYTES = 4096
"""Terminals wrote a banner before the first FMT of a DataFlash as text; it ends by here.
Chosen."""
TLOG_AT, TLOG_MAGICS = 8, (0xFE, 0xFD)
"""A telemetry log begins with a time, and then a MAVLink packet of version 1 or 2."""


@dataclass
class Converted:
    """A bag that was made of a log.

    Attributes:
        format: Name of the log's format.
        messages: Messages by topic.
        notes: Remarks on the import.
    """

    format: str
    messages: Counter[str] = field(default_factory=Counter)
    notes: Notes = field(default_factory=Notes)


def is_log(path: Path, selection: Selection | None = None) -> bool:
    """Whether a path is a log to be imported, and not an mcap bag or nothing at all.

    An mcap bag is one if it has messages of PX4, or where a namespace of it is selected.
    """
    return _recognised(path, selection or Selection()) is not None


def convert(
    path: Path, out: Path, selection: Selection | None = None, columns: ColumnMap | None = None
) -> Converted:
    """Make the bag `out` of a log: our topics, FLU and ENU, stamps as log times.

    Args:
        path: The log.
        out: The bag, which must not exist.
        selection: Which of several sensors to take.
        columns: What the columns of a CSV are, if it is one.

    Raises:
        BagError: The log is of no known format, cannot be read, has no IMU or GPS, or `out` cannot
            be written.
        ModuleNotFoundError: What reads the format is not installed (the extra `logs`).
    """
    if columns is not None and not path.exists():
        raise BagError(f"{path}: does not exist; check the path")
    selection = selection or Selection()
    found = (
        _recognised(path, selection)
        if columns is None
        else (csv_log.FORMAT, csv_log.reader(columns))
    )
    if found is None:
        if path.is_file() and guessed_form(path) is not None:
            raise BagError(advice(path))
        known = ", ".join(sorted({name for name, _ in (*MAGICS.values(), TLOG, CSV)}))
        raise BagError(f"{path}: has no format that is known; known are {known}")
    name_of_format, read = found
    done = Converted(name_of_format)
    topics = dict(PRESETS["default"].items())
    try:
        with BagWriter(out) as writer:
            for name, stamp_ns, value in read(path, selection, done.notes):
                if isinstance(value, tuple):
                    writer.write_orientation(ATTITUDE, stamp_ns, value)
                else:
                    writer.write(topics[name], value, stamp_ns)
                done.messages[topics.get(name, name)] += 1
    except (BagError, ModuleNotFoundError):
        raise
    except Exception as error:  # the libraries raise anything
        raise BagError(
            f"{path}: cannot be read as {done.format} ({error!r}); copy it again"
        ) from error
    return done


@contextlib.contextmanager
def as_bag(
    path: Path, selection: Selection | None = None, columns: ColumnMap | None = None
) -> Iterator[tuple[Path, Converted | None]]:
    """A bag as it is, or one that is made of a log and taken away afterwards.

    Raises:
        BagError: As `convert`.
    """
    if columns is None and not is_log(path, selection):
        if path.is_file() and path.suffix.lower() in TABLES and guessed_form(path) is not None:
            raise BagError(advice(path))
        yield path, None
        return
    with tempfile.TemporaryDirectory(prefix="hijack_detect_") as folder:
        bag = Path(folder) / path.stem
        yield bag, convert(path, bag, selection, columns)


@contextlib.contextmanager
def opened(
    path: Path, selection: Selection | None = None, columns: ColumnMap | None = None
) -> Iterator[tuple[BagReader, Converted | None]]:
    """A reader of a bag, or of the one that is made of a log; see `as_bag`.

    Raises:
        BagError: As `convert`, or the bag cannot be read.
    """
    with as_bag(path, selection, columns) as (bag, converted):
        made_from = None if converted is None else path
        with BagReader(bag, made_from=made_from) as reader:
            yield reader, converted


def _recognised(path: Path, selection: Selection) -> tuple[str, Read] | None:
    """Name and reader of a log's format."""
    try:
        if path.is_dir():
            if any(path.glob("*.db3")):
                return MAGICS[SQLITE]
            if any(path.glob("*.mcap")):
                return _mcap(path, selection)
            known = known_map(path)
            return None if known is None else ("CSV of ulog2csv", csv_log.reader(known))
        with path.open("rb") as file:
            head = file.read(BANNER_BYTES)
        begin = head[: max(map(len, MAGICS))]
        if begin.startswith(MCAP):
            return _mcap(path, selection)
    except (OSError, BagError):
        return None
    if len(begin) > TLOG_AT and begin[0] == 0 and begin[TLOG_AT] in TLOG_MAGICS:
        return TLOG
    found = next((one for magic, one in MAGICS.items() if begin.startswith(magic)), None)
    return found or (MAGICS[TEXT] if TEXT_LINE in head else None)


def _mcap(path: Path, selection: Selection) -> tuple[str, Read] | None:
    """None for a bag that is read as it is.

    Raises:
        BagError: The bag cannot be read.
    """
    if selection.namespace:
        return "ROS 2 bag in mcap", mcap.read
    return ("ROS 2 bag in mcap with px4_msgs", mcap.read) if mcap.has_px4(path) else None
