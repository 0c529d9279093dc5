# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Bags in mcap that are not read as they are: with px4_msgs, or of several vehicles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.topics import TYPES
from hijack_detect.logs.logged import Logged, Notes, Selection
from hijack_detect.logs.rosbag import PX4, readings


@dataclass(frozen=True)
class _Connection:
    id: int
    topic: str
    msgtype: str
    msgcount: int


class _Messages:
    """A bag as `readings` wants it, with the definitions that are in it."""

    def __init__(self, reader: BagReader) -> None:
        self._reader = reader
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self.connections = [
            _Connection(number, topic, kind, reader.message_counts[topic])
            for number, (topic, kind) in enumerate(sorted(reader.topics.items()))
        ]
        for one in self.connections:
            if one.msgtype in PX4 and one.msgtype not in self._store.fielddefs:
                self._define(one)

    def messages(self, connections: Sequence[_Connection]) -> Iterator[tuple[Any, int, bytes]]:
        by_topic = {one.topic: one for one in connections}
        for raw in self._reader.messages(by_topic.keys()):
            yield by_topic[raw.topic], raw.log_ns, raw.data

    def deserialize(self, data: bytes, kind: str, /) -> Any:
        return self._store.deserialize_cdr(data, kind)

    def _define(self, one: _Connection) -> None:
        definition = self._reader.definition(one.topic)
        if not definition:
            raise BagError(f"{self._reader.path}: {one.topic}: {one.msgtype} has no definition")
        found = get_types_from_msg(definition, one.msgtype)
        known = self._store.fielddefs
        self._store.register({name: of for name, of in found.items() if name not in known})


def read(path: Path, selection: Selection, notes: Notes) -> Iterator[Logged]:
    """Read a bag; see `Read`."""
    with BagReader(path) as reader:
        yield from readings(path, _Messages(reader), selection, notes)


def has_px4(path: Path) -> bool:
    """Whether a bag has messages of PX4, and not the Imu and NavSatFix that are read as they are.

    Raises:
        BagError: It cannot be read.
    """
    with BagReader(path) as reader:
        kinds = set(reader.topics.values())
    return bool(kinds & PX4.keys()) and not {TYPES["imu"], TYPES["fix"]} <= kinds
