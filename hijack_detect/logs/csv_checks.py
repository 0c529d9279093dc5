# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Whether a reading of a table can be true: a wrong unit or column shows here."""

from __future__ import annotations

from collections.abc import Iterator

from hijack_detect.streams.messages import (
    ALTITUDE_RANGE_M,
    MAX_ANGULAR_VELOCITY,
    MAX_SATELLITES,
    MAX_SPECIFIC_FORCE,
    MAX_SPEED,
    PRESSURE_RANGE_PA,
)
from hijack_detect.streams.samples import (
    FixSample,
    ImuSample,
    MagneticSample,
    PressureSample,
    Quaternion,
    Sample,
    SatelliteSample,
    VelocitySample,
)

Bounded = tuple[str, float, str, float, float]
"""Name, value, unit, lowest and highest."""


def impossible(reading: Sample | Quaternion) -> str:
    """What no sensor can mean in a reading, empty if there is nothing."""
    for name, value, unit, low, high in _bounded(reading):
        if not low <= value <= high:
            return f"{name} would be {value:g} {unit}, beyond {low:g} to {high:g}"
    return ""


def _bounded(reading: Sample | Quaternion) -> Iterator[Bounded]:
    if isinstance(reading, ImuSample):
        for value in reading.angular_velocity:
            yield "gyro", value, "rad/s", -MAX_ANGULAR_VELOCITY, MAX_ANGULAR_VELOCITY
        for value in reading.specific_force:
            yield "accel", value, "m/s2", -MAX_SPECIFIC_FORCE, MAX_SPECIFIC_FORCE
    elif isinstance(reading, FixSample):
        yield "latitude", reading.latitude_deg, "deg", -90.0, 90.0
        yield "longitude", reading.longitude_deg, "deg", -180.0, 180.0
        yield "altitude", reading.altitude_m, "m", *ALTITUDE_RANGE_M
    elif isinstance(reading, VelocitySample):
        for value in reading.velocity:
            yield "velocity", value, "m/s", -MAX_SPEED, MAX_SPEED
    elif isinstance(reading, MagneticSample):
        for value in reading.field:
            yield "field", value, "T", -1.0, 1.0
    elif isinstance(reading, PressureSample):
        yield "pressure", reading.pressure_pa, "Pa", *PRESSURE_RANGE_PA
    elif isinstance(reading, SatelliteSample):
        yield "count", reading.count, "satellites", 0, MAX_SATELLITES
    elif isinstance(reading, tuple):
        for value in reading:
            yield "quaternion", value, "", -1.001, 1.001
