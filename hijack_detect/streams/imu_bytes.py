# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From the bytes of a `sensor_msgs/Imu` to samples, without making the message.

Most of what a monitor hears are IMU samples, and most of an Imu are covariances that nobody reads.
In CDR its layout is fixed but for the length of the frame's name.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from hijack_detect.streams.messages import checked_attitude, checked_imu
from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample, ImuSample

LITTLE_ENDIAN = b"\x00\x01"
"""How plain CDR of little-endian numbers begins; two more bytes follow."""
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
    """The stamp of an Imu, nanoseconds; None if the bytes are laid out in another way."""
    if len(data) < _HEADER.size or data[:2] != LITTLE_ENDIAN:
        return None
    seconds, nanoseconds, _ = _HEADER.unpack_from(data)
    return int(seconds) * NANOSECONDS + int(nanoseconds)


def imu_from_bytes(data: bytes) -> ImuSample | None:
    """The sample of a raw Imu; None if the bytes are laid out in another way.

    Raises:
        BadMessage: As `imu_sample`.
    """
    read = _read(data, _RAW)
    if read is None:
        return None
    stamp_ns, (wx, wy, wz, fx, fy, fz) = read
    return checked_imu(stamp_ns, (wx, wy, wz), (fx, fy, fz))


def attitude_from_bytes(data: bytes) -> AttitudeSample | None:
    """The sample of an Imu with orientation; None if the bytes are laid out in another way.

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
