# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Messages of PX4, as a ULog and px4_msgs have them alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from hijack_detect.logs.frames import enu
from hijack_detect.logs.logged import Logged, fix_sample
from hijack_detect.logs.units import FIX_3D
from hijack_detect.streams.samples import SatelliteSample, VelocitySample

IN_DEGREES = "latitude_deg"
"""A field of SensorGps; older ones have 1e-7 degrees and millimetres."""


def gps(stamp_ns: int, field: Callable[[str], Any], *, in_degrees: bool) -> Iterator[Logged]:
    """The fix of a SensorGps, its velocity and its number of satellites.

    Args:
        stamp_ns: Stamp, nanoseconds.
        field: Gives the value of a field by its name.
        in_degrees: Whether it has the field IN_DEGREES.
    """
    has_fix = bool(field("fix_type") >= FIX_3D)
    if in_degrees:
        names = (IN_DEGREES, "longitude_deg", "altitude_ellipsoid_m")
        place = tuple(float(field(name)) for name in names)
    else:
        scales = (("lat", 1e-7), ("lon", 1e-7), ("alt_ellipsoid", 1e-3))
        place = tuple(float(field(name)) * scale for name, scale in scales)
    fix = fix_sample(stamp_ns, place, float(field("eph")), has_fix=has_fix)
    yield Logged("fix", stamp_ns, fix)
    if has_fix and field("vel_ned_valid"):
        velocity = enu(*(float(field(f"vel_{axis}_m_s")) for axis in "ned"))
        yield Logged("velocity", stamp_ns, VelocitySample(stamp_ns, velocity))
    count = int(field("satellites_used"))
    yield Logged("satellites", stamp_ns, SatelliteSample(stamp_ns, count))
