# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Messages of MAVLink, as a telemetry log and a live link have them alike.

No message has the vertical velocity that the receiver measured: GPS_RAW_INT has speed and course
over ground, and GLOBAL_POSITION_INT what the autopilot's filter made of all its sensors, the IMU
among them. So velocities are those of GPS_RAW_INT, and their vertical component is absent (NaN).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from hijack_detect.logs.frames import (
    FIX_3D,
    GAUSS_T,
    HECTOPASCAL_PA,
    MILLI,
    MILLIGAUSS_T,
    MILLIGRAVITY,
    flu,
)
from hijack_detect.logs.logged import Logged, fix_sample
from hijack_detect.streams.messages import UNKNOWN_COUNT
from hijack_detect.streams.samples import (
    ImuSample,
    MagneticSample,
    PressureSample,
    SatelliteSample,
    VelocitySample,
)

NO_CLIMB = "MAVLink has no vertical velocity of the GPS: velocities are horizontal"
NO_MOTION = 0xFFFF
"""MAVLink: vel and cog that are unknown."""
MAG_UPDATED, PRESSURE_UPDATED = 0b111 << 6, 1 << 9
"""Bits of fields_updated of a HIGHRES_IMU."""


def own_time_us(message: Any) -> int:
    """When the autopilot measured a message, by its own clock, microseconds."""
    own = getattr(message, "time_usec", None)
    return int(message.time_boot_ms) * 1000 if own is None else int(own)


def has_fix(message: Any) -> bool:
    """Whether a GPS_RAW_INT has a place."""
    return bool(message.fix_type >= FIX_3D)


def imu(message: Any, stamp_ns: int) -> Iterator[Logged]:
    """The Imu of a HIGHRES_IMU, SCALED_IMU or RAW_IMU, and its field and pressure if they are new.

    A RAW_IMU is read in the units of a SCALED_IMU, as ArduPilot fills it.
    """
    si = message.get_type() == "HIGHRES_IMU"
    force_scale, gyro_scale, field_scale = (
        (1.0, 1.0, GAUSS_T) if si else (MILLIGRAVITY, MILLI, MILLIGAUSS_T)
    )
    # A sender that does not fill the bits has none set.
    updated = (si and message.fields_updated) or MAG_UPDATED | PRESSURE_UPDATED
    gyro = flu(*(getattr(message, f"{axis}gyro") * gyro_scale for axis in "xyz"))
    force = flu(*(getattr(message, f"{axis}acc") * force_scale for axis in "xyz"))
    yield Logged("imu", stamp_ns, ImuSample(stamp_ns, gyro, force))
    field = flu(*(getattr(message, f"{axis}mag") * field_scale for axis in "xyz"))
    if any(field) and updated & MAG_UPDATED:
        yield Logged("mag", stamp_ns, MagneticSample(stamp_ns, field))
    if si and updated & PRESSURE_UPDATED:
        yield from _pressure(message.abs_pressure, stamp_ns)


def gps(message: Any, stamp_ns: int) -> Iterator[Logged]:
    """The fix of a GPS_RAW_INT (height above the sea), its velocity and number of satellites."""
    place = (message.lat * 1e-7, message.lon * 1e-7, message.alt * 1e-3)
    accuracy_m = getattr(message, "h_acc", 0) * 1e-3 or math.nan
    fix = fix_sample(
        stamp_ns,
        place,
        accuracy_m,
        has_fix=has_fix(message),
        vertical_accuracy_m=getattr(message, "v_acc", 0) * 1e-3 or math.nan,
    )
    yield Logged("fix", stamp_ns, fix)
    if has_fix(message) and NO_MOTION not in (message.vel, message.cog):
        speed, course = message.vel * 1e-2, math.radians(message.cog * 1e-2)
        velocity = (speed * math.sin(course), speed * math.cos(course), math.nan)
        yield Logged("velocity", stamp_ns, VelocitySample(stamp_ns, velocity))
    count = int(message.satellites_visible)
    if count != UNKNOWN_COUNT:
        yield Logged("satellites", stamp_ns, SatelliteSample(stamp_ns, count))


def pressure(message: Any, stamp_ns: int) -> Iterator[Logged]:
    """The pressure of a SCALED_PRESSURE."""
    yield from _pressure(message.press_abs, stamp_ns)


def _pressure(hectopascal: float, stamp_ns: int) -> Iterator[Logged]:
    if hectopascal > 0.0:
        pascal = float(hectopascal) * HECTOPASCAL_PA
        yield Logged("pressure", stamp_ns, PressureSample(stamp_ns, pascal))
