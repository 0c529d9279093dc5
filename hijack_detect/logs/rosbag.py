# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""ROS 1 bags, and ROS 2 bags in sqlite3 (rosbags): standard messages, and those of px4_msgs."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.topics import TYPES
from hijack_detect.logs import px4
from hijack_detect.logs.frames import flu
from hijack_detect.logs.logged import Logged, Notes, Wanted
from hijack_detect.logs.units import GAUSS_T
from hijack_detect.streams.messages import CONVERTERS, BadMessage
from hijack_detect.streams.samples import (
    ImuSample,
    MagneticSample,
    PressureSample,
)

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
        name = STANDARD.get(one.msgtype) or PX4.get(one.msgtype)
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
    if kind in PX4:
        yield from _px4(name, message)
    else:
        sample = CONVERTERS[name](message)
        yield Logged(name, sample.stamp_ns, sample)


PX4 = {
    "px4_msgs/msg/SensorCombined": "imu",
    "px4_msgs/msg/SensorGps": "fix",
    "px4_msgs/msg/VehicleMagnetometer": "mag",
    "px4_msgs/msg/VehicleAirData": "pressure",
}


def _px4(name: str, message: Any) -> Iterator[Logged]:
    """Readings of a message of PX4, whose stamp is in microseconds."""
    stamp_ns = int(message.timestamp) * 1000
    if name == "imu":
        gyro, force = flu(*message.gyro_rad), flu(*message.accelerometer_m_s2)
        yield Logged(name, stamp_ns, ImuSample(stamp_ns, gyro, force))
    elif name == "mag":
        field = flu(*(float(one) * GAUSS_T for one in message.magnetometer_ga))
        yield Logged(name, stamp_ns, MagneticSample(stamp_ns, field))
    elif name == "pressure":
        pascal = float(message.baro_pressure_pa)
        yield Logged(name, stamp_ns, PressureSample(stamp_ns, pascal))
    else:
        in_degrees = hasattr(message, px4.IN_DEGREES)
        yield from px4.gps(stamp_ns, partial(getattr, message), in_degrees=in_degrees)
