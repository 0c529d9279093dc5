# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""ROS 1 bags, and ROS 2 bags in sqlite3 (rosbags): standard messages, and those of px4_msgs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.topics import TYPES
from hijack_detect.logs import px4
from hijack_detect.logs.logged import Logged, Notes, Wanted
from hijack_detect.streams.messages import CONVERTERS, BadMessage, check

STANDARD = {kind: name for name, kind in TYPES.items() if name != "satellites"}


def read(path: Path, wanted: Wanted, notes: Notes) -> Iterator[Logged]:
    """Read a bag; see `Read`. Of several topics of a type, by name, the wanted one is taken."""
    from rosbags.highlevel import AnyReader  # noqa: PLC0415  slow to load

    with AnyReader([path]) as reader:
        chosen = _chosen(path, reader.connections, wanted, notes)
        used = [one for one in reader.connections if one.id in chosen]
        for connection, _, data in reader.messages(used):
            try:
                message = reader.deserialize(data, connection.msgtype)
                yield from _logged(chosen[connection.id], connection.msgtype, message)
            except BadMessage as error:
                notes.skipped[f"{connection.topic}: {str(error).split(' is ', maxsplit=1)[0]}"] += 1


def _chosen(path: Path, connections: Any, wanted: Wanted, notes: Notes) -> dict[int, str]:
    """The input of each connection that is used, by its id."""
    numbers = {"imu": wanted.imu, "fix": wanted.gps, "velocity": wanted.gps}
    topics: dict[str, list[str]] = {}
    for one in sorted(connections, key=lambda one: str(one.topic)):
        name = STANDARD.get(one.msgtype) or px4.INPUTS.get(one.msgtype)
        if name is None:
            notes.skipped[f"{one.topic}: {one.msgtype} is no input"] += one.msgcount
        elif one.topic not in topics.setdefault(name, []):
            topics[name].append(one.topic)
    for name in ("imu", "fix"):
        if numbers[name] >= len(topics.get(name, ())):
            have = ", ".join(sorted({f"{one.topic} ({one.msgtype})" for one in connections}))
            raise BagError(f"{path}: has no {name} number {numbers[name]}; it has {have}")
    taken: dict[int, str] = {}
    for name, found in topics.items():
        topic = found[min(numbers.get(name, 0), len(found) - 1)]
        notes.said.append(f"{name} is {topic}")
        taken |= {one.id: name for one in connections if one.topic == topic}
        for other in found:
            if other != topic:
                notes.said.append(f"{other} is left out: another {name} is taken")
    return taken


def _logged(name: str, kind: str, message: Any) -> Iterator[Logged]:
    if kind in px4.INPUTS:
        stamp_ns = px4.stamp_us(name, message) * 1000
        for one in px4.readings(name, message, stamp_ns):
            check(one.value)
            yield one
    else:
        sample = CONVERTERS[name](message)
        yield Logged(name, sample.stamp_ns, sample)
