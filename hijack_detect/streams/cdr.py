# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Header stamps, and samples of a `sensor_msgs/Imu`, from CDR bytes without making the message.

Four bytes of encapsulation precede the message (DDS-XTypes 7.6.2): two are its encoding, two
are options. `std_msgs/Header` begins with the stamp, and the layout of an Imu is fixed but for the
length of the frame's name. Most of what a monitor subscribes to are IMU samples, and most of an Imu
are covariances that no part reads.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from hijack_detect.streams.messages import checked_attitude, checked_imu
from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample, ImuSample

LITTLE_ENDIAN = b"\x00\x01"
"""How plain CDR of little-endian numbers begins; two more bytes follow."""
_STAMPS = struct.Struct(">iI"), struct.Struct("<iI")
"""Seconds and nanoseconds, big-endian and little-endian."""
_STAMP_AT, _STAMP_END = 4, 12
_HEADER = struct.Struct("<4xiII")
"""Seconds, nanoseconds, and the length of the frame's name with its final zero."""
_RAW = struct.Struct("<104x 3d 72x 3d 72x")
"""Angular velocity and specific force, behind orientation and its covariance."""
_WHOLE = struct.Struct("<4d d56xd 3d 72x 3d 72x")
"""Orientation, its covariance [0] and [8], angular velocity, specific force."""


def _read(data: bytes, body: struct.Struct) -> tuple[int, tuple[float, ...]] | None:
    """Stamp in nanoseconds and the numbers of a body; None if the layout is another."""
    if len(data) < _HEADER.size or data[:2] != LITTLE_ENDIAN:
        return None
    seconds, nanoseconds, length = _HEADER.unpack_from(data)
    end = _HEADER.size + length
    begin = end + (4 - end) % 8  # doubles are aligned as if the first four bytes were not there
    if len(data) < begin + body.size:
        return None
    return seconds * NANOSECONDS + nanoseconds, body.unpack_from(data, begin)


def stamp_from_bytes(data: bytes) -> int | None:
    """Stamp of a message that begins with a header, nanoseconds; None if it is too short."""
    if len(data) < _STAMP_END:
        return None
    seconds, nanoseconds = _STAMPS[data[1] & 1].unpack_from(data, _STAMP_AT)
    return int(seconds) * NANOSECONDS + int(nanoseconds)


def with_stamp(data: bytes, stamp_ns: int) -> bytes:
    """A message that begins with a header, with another stamp."""
    stamp = _STAMPS[data[1] & 1].pack(*divmod(stamp_ns, NANOSECONDS))
    return data[:_STAMP_AT] + stamp + data[_STAMP_END:]


def imu_from_bytes(data: bytes) -> ImuSample | None:
    """The sample of a raw Imu; None if the layout is not plain little-endian CDR.

    Raises:
        BadMessage: As `imu_sample`.
    """
    read = _read(data, _RAW)
    if read is None:
        return None
    stamp_ns, (wx, wy, wz, fx, fy, fz) = read
    return checked_imu(stamp_ns, (wx, wy, wz), (fx, fy, fz))


def attitude_from_bytes(data: bytes) -> AttitudeSample | None:
    """The sample of an Imu with orientation; None as in `imu_from_bytes`.

    Raises:
        BadMessage: As `attitude_sample`.
    """
    read = _read(data, _WHOLE)
    if read is None:
        return None
    stamp_ns, (x, y, z, w, roll, yaw, wx, wy, wz, fx, fy, fz) = read
    return checked_attitude(stamp_ns, (x, y, z, w), (roll, yaw), (wx, wy, wz), (fx, fy, fz))


FROM_BYTES: dict[str, Callable[[bytes], Any]] = {
    "imu": imu_from_bytes,
    "attitude": attitude_from_bytes,
}
"""By the input's name, as CONVERTERS; those that are not here need the message."""
