# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""ROS 1 bags, and ROS 2 bags of any storage: standard messages, and those of px4_msgs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.samples import CONVERT
from hijack_detect.bags.topics import NEEDED, PRESETS, TYPES
from hijack_detect.logs import px4
from hijack_detect.logs.frames import attitude
from hijack_detect.logs.logged import ATTITUDE, Logged, Notes, Selection
from hijack_detect.streams.messages import BadMessage, check
from hijack_detect.streams.satellites import SATELLITES, SatelliteStamps

STANDARD = {kind: name for name, kind in TYPES.items() if name != "satellites"}


STANDARD_SATELLITES = ("std_msgs/msg/UInt32", PRESETS["mavros"].satellites or "")
"""A number can be anything: it is one of satellites where mavros calls it so."""


class Connection(Protocol):
    """A topic of a bag."""

    id: int
    topic: str
    msgtype: str
    msgcount: int


class Bag(Protocol):
    """A bag of any storage, as rosbags' AnyReader is one."""

    connections: Any

    def messages(self, connections: Any) -> Any:
        """Connection, log time and bytes of the messages of some connections."""

    def deserialize(self, data: bytes, kind: str, /) -> Any:
        """The message."""


def read(path: Path, selection: Selection, notes: Notes) -> Iterator[Logged]:
    """Read a bag; see `Read`. Of several topics of a type, by name, the selected one is taken.

    The names of mavros and of this package go first, for mavros has its estimates under others.
    """
    from rosbags.highlevel import AnyReader  # noqa: PLC0415  slow to load

    with AnyReader([path]) as reader:
        yield from readings(path, reader, selection, notes)


def readings(path: Path, bag: Bag, selection: Selection, notes: Notes) -> Iterator[Logged]:
    """The readings of a bag that is open.

    Raises:
        BagError: It has no IMU or no GPS.
    """
    stamps = SatelliteStamps()
    chosen = _chosen(path, bag.connections, selection, notes)
    used = [one for one in bag.connections if one.id in chosen]
    for place, (connection, _, data) in enumerate(bag.messages(used)):
        name, kind = chosen[connection.id], connection.msgtype
        try:
            message = bag.deserialize(data, kind)
            if kind in PX4:
                yield from _px4(name, message)
                continue
            converted = CONVERT[name](message)
            for of, sample in stamps.samples(name, place, converted):
                yield Logged(of, sample.stamp_ns, sample)
        except BadMessage as error:
            notes.skipped[f"{connection.topic}: {str(error).split(' is ', maxsplit=1)[0]}"] += 1


def _input(one: Connection) -> str | None:
    """The input that a topic can be, None if it can be none."""
    kind, satellites = STANDARD_SATELLITES
    if one.msgtype == kind and one.topic.endswith(satellites):
        return SATELLITES
    return STANDARD.get(one.msgtype) or PX4.get(one.msgtype)


def _chosen(path: Path, connections: Any, selection: Selection, notes: Notes) -> dict[int, str]:
    """The input of each connection that is used, by its id."""
    numbers = {
        "imu": selection.imu,
        **dict.fromkeys(("fix", "velocity", SATELLITES), selection.gps),
    }
    space = f"/{selection.namespace.strip('/')}/".replace("//", "/")
    topics: dict[str, list[str]] = {}
    for one in sorted(connections, key=lambda one: str(one.topic)):
        name = _input(one) if one.topic.startswith(space) else None
        if one.topic.startswith("/truth/") or name is None:
            notes.skipped[f"{one.topic}: {one.msgtype} is no input"] += one.msgcount
        elif one.topic not in topics.setdefault(name, []):
            topics[name].append(one.topic)
    for name in NEEDED:
        if numbers[name] >= len(topics.get(name, ())):
            have = ", ".join(sorted({f"{one.topic} ({one.msgtype})" for one in connections}))
            of = "" if space == "/" else f" in the namespace {selection.namespace}"
            raise BagError(f"{path}: has no {name} number {numbers[name]}{of}; it has {have}")
    taken: dict[int, str] = {}
    for name, found in topics.items():
        found.sort(key=lambda topic: (not _is_known(name, topic), topic))
        topic = found[min(numbers.get(name, 0), len(found) - 1)]
        notes.remarks.append(f"{name} is {topic}")
        taken |= {one.id: name for one in connections if one.topic == topic}
        for other in found:
            if other != topic:
                notes.remarks.append(f"{other} is left out: another {name} is taken")
    return taken


def _is_known(name: str, topic: str) -> bool:
    """Whether an input is called so by mavros or by this package, in any namespace."""
    return any(topic.endswith(getattr(preset, name, None) or "\0") for preset in PRESETS.values())


PX4 = {
    **px4.INPUTS,
    f"{px4.PACKAGE}/msg/VehicleGpsPosition": "fix",
    f"{px4.PACKAGE}/msg/VehicleAttitude": ATTITUDE,
}
"""The input of each message of PX4, by any name of its topic: /fmu/out/vehicle_attitude has
become /fmu/out/vehicle_attitude_v1 where the definition has changed."""


def _px4(name: str, message: Any) -> Iterator[Logged]:
    """Readings of a message of PX4. Raises BadMessage."""
    stamp_ns = px4.stamp_us(name, message) * 1000
    if name == ATTITUDE:
        w, x, y, z = map(float, message.q)
        yield Logged(name, stamp_ns, attitude((x, y, z, w)))
        return
    for one in px4.readings(name, message, stamp_ns):
        check(one.value)
        yield one
