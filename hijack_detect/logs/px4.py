# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Messages of PX4: those of px4_msgs, and what a ULog has like them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from hijack_detect.logs.frames import FIX_3D, GAUSS_T, enu, flu
from hijack_detect.logs.logged import Logged, fix_sample
from hijack_detect.streams.messages import UNKNOWN_COUNT, BadMessage
from hijack_detect.streams.samples import (
    ImuSample,
    MagneticSample,
    PressureSample,
    SatelliteSample,
    VelocitySample,
)

IN_DEGREES = "latitude_deg"
"""A field of SensorGps; older ones have 1e-7 degrees and millimetres."""
PACKAGE = "px4_msgs"
INPUTS = {
    f"{PACKAGE}/msg/SensorCombined": "imu",
    f"{PACKAGE}/msg/VehicleImu": "imu",
    f"{PACKAGE}/msg/SensorGps": "fix",
    f"{PACKAGE}/msg/VehicleMagnetometer": "mag",
    f"{PACKAGE}/msg/VehicleAirData": "pressure",
}
"""Types of px4_msgs that are read, and the input of each; a SensorGps brings all of the GPS."""
ABOVE_SEA = "the height above the ellipsoid is not filled: heights are above the sea"
LONGEST_DELAY_US = 1_000_000
"""A sample older than this at its publication was not stamped. Chosen: far above any delay."""
LATEST_US = 2**31 * 1_000_000
"""The seconds of a stamp in ROS end here, in 2038."""


def stamp_us(name: str, message: Any) -> int:
    """When the sample in a message of px4_msgs was taken, microseconds of its clock.

    That is `timestamp_sample` where there is one. The GPS has it too, but not every driver fills
    it; its `timestamp` is that of position and velocity.

    Args:
        name: The input, see INPUTS.
        message: The message.

    Raises:
        BadMessage: There is no time in it, or one that no stamp can hold.
    """
    published = int(message.timestamp)
    sampled = int(getattr(message, "timestamp_sample", published))
    if published == 0:
        raise BadMessage("timestamp is 0, which PX4 never publishes")
    if published >= LATEST_US:
        raise BadMessage(f"timestamp is {published} µs, after 2038")
    filled = name != "fix" and 0 <= published - sampled < LONGEST_DELAY_US
    return sampled if filled else published


def readings(name: str, message: Any, stamp_ns: int) -> Iterator[Logged]:
    """The readings of a message of px4_msgs, in FLU, ENU and SI.

    Args:
        name: The input, see INPUTS.
        message: The message.
        stamp_ns: Stamp to give, nanoseconds.

    Raises:
        BadMessage: An IMU integrated over no time.
    """
    if name == "imu":
        yield Logged(name, stamp_ns, _imu(message, stamp_ns))
    elif name == "mag":
        field = flu(*(float(one) * GAUSS_T for one in message.magnetometer_ga))
        yield Logged(name, stamp_ns, MagneticSample(stamp_ns, field))
    elif name == "pressure":
        pascal = float(message.baro_pressure_pa)
        yield Logged(name, stamp_ns, PressureSample(stamp_ns, pascal))
    else:
        in_degrees = hasattr(message, IN_DEGREES)
        yield from gps(stamp_ns, partial(getattr, message), in_degrees=in_degrees)


def _imu(message: Any, stamp_ns: int) -> ImuSample:
    """The rates of a SensorCombined, or the increments of a VehicleImu over their time."""
    if hasattr(message, "gyro_rad"):
        return ImuSample(stamp_ns, flu(*message.gyro_rad), flu(*message.accelerometer_m_s2))
    vectors = []
    for field in ("delta_angle", "delta_velocity"):
        seconds = 1e-6 * float(getattr(message, f"{field}_dt"))
        if seconds <= 0.0:
            raise BadMessage(f"{field}_dt is 0")
        vectors.append(flu(*(float(one) / seconds for one in getattr(message, field))))
    return ImuSample(stamp_ns, *vectors)


def gps(stamp_ns: int, field: Callable[[str], Any], *, in_degrees: bool) -> Iterator[Logged]:
    """The fix of a SensorGps, its velocity and its number of satellites.

    Args:
        stamp_ns: Stamp, nanoseconds.
        field: Gives the value of a field by its name.
        in_degrees: Whether it has the field IN_DEGREES.
    """
    has_fix = bool(field("fix_type") >= FIX_3D)
    if in_degrees:
        place = (float(field(IN_DEGREES)), float(field("longitude_deg")))
    else:
        place = (float(field("lat")) * 1e-7, float(field("lon")) * 1e-7)
    height, _ = height_m(field, in_degrees=in_degrees)
    fix = fix_sample(
        stamp_ns,
        (*place, height),
        float(field("eph")),
        has_fix=has_fix,
        vertical_accuracy_m=_optional(field, "epv"),
    )
    yield Logged("fix", stamp_ns, fix)
    if has_fix and field("vel_ned_valid"):
        velocity = enu(*(float(field(f"vel_{axis}_m_s")) for axis in "ned"))
        yield Logged("velocity", stamp_ns, VelocitySample(stamp_ns, velocity))
    count = int(field("satellites_used"))
    if count != UNKNOWN_COUNT:
        yield Logged("satellites", stamp_ns, SatelliteSample(stamp_ns, count))


def height_m(field: Callable[[str], Any], *, in_degrees: bool) -> tuple[float, bool]:
    """Height of a SensorGps, m, and whether it is the one above the sea.

    That is taken where a driver has left the height above the ellipsoid at 0.
    """
    ellipsoid, sea, scale = "alt_ellipsoid", "alt", 1e-3
    if in_degrees:
        ellipsoid, sea, scale = "altitude_ellipsoid_m", "altitude_msl_m", 1.0
    height = float(field(ellipsoid)) * scale
    if height == 0.0 and (above_sea := _optional(field, sea) * scale) not in (0.0, math.nan):
        return above_sea, not math.isnan(above_sea)
    return height, False


def _optional(field: Callable[[str], Any], name: str) -> float:
    """The value of a field; NaN where the message has no such field."""
    try:
        return float(field(name))
    except (AttributeError, KeyError):
        return math.nan
