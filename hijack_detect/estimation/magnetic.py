# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Heading from a magnetometer."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

from pygeomag import GeoMag

from hijack_detect.estimation.rotation import rotate
from hijack_detect.streams.samples import Quaternion, Vector3

MODEL_YEAR = 2025.0
"""Epoch of the World Magnetic Model. A fixed one keeps results reproducible; declination moves
by less than 0.2° a year, far below a magnetometer's own error."""

NANOTESLA = 1e-9


@cache
def _model() -> GeoMag:
    return GeoMag()


def _field(latitude_deg: float, longitude_deg: float, altitude_m: float) -> Any:
    """The model's field; at sea level where the height is NaN (0.05 % weaker each km above)."""
    height_km = 0.0 if math.isnan(altitude_m) else altitude_m / 1000.0
    return _model().calculate(glat=latitude_deg, glon=longitude_deg, alt=height_km, time=MODEL_YEAR)


def declination(latitude_deg: float, longitude_deg: float, altitude_m: float) -> float:
    """Angle from true to magnetic North, radians, positive East (World Magnetic Model)."""
    return math.radians(_field(latitude_deg, longitude_deg, altitude_m).d)


def field_enu(latitude_deg: float, longitude_deg: float, altitude_m: float) -> Vector3:
    """The Earth's magnetic field, tesla in ENU (World Magnetic Model)."""
    found = _field(latitude_deg, longitude_deg, altitude_m)
    return (found.y * NANOTESLA, found.x * NANOTESLA, -found.z * NANOTESLA)


def heading_error(
    attitude: Quaternion, field: Vector3, declination_rad: float
) -> tuple[float, Vector3]:
    """Angle by which the attitude must turn about Up to agree with the measured field.

    The field turned into ENU must point at magnetic North, `declination_rad` East of North.

    Returns:
        The angle in radians, and its derivatives by the attitude error in ENU: where the field
        is steep, a small error of tilt turns its horizontal part a lot.
    """
    east, north, up = rotate(attitude, field)
    level = east * east + north * north
    if level == 0.0:
        return 0.0, (0.0, 0.0, 0.0)
    angle = math.remainder(math.pi / 2 - declination_rad - math.atan2(north, east), math.tau)
    return angle, (-up * east / level, -up * north / level, 1.0)
