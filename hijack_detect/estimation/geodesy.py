# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Fixes in a local tangent plane."""

from __future__ import annotations

import math
from functools import lru_cache

import pymap3d
from pymap3d.ecef import uvw2enu

from hijack_detect.streams.samples import FixSample, Vector3


class LocalFrame:
    """East, north, up in metres about the first fix (WGS-84 tangent plane).

    Attributes:
        origin: The first fix.
        has_height: Whether the height of the origin was measured.
    """

    def __init__(self, origin: FixSample) -> None:
        """Put the origin at a fix, on the ellipsoid if its height was not measured.

        At 1 km of height that makes a horizontal distance wrong by 1.6e-4 of itself.
        """
        self.origin = origin
        self.has_height = origin.has_altitude
        height = origin.altitude_m if self.has_height else 0.0
        self._origin = (origin.latitude_deg, origin.longitude_deg, height)

    def enu(self, fix: FixSample) -> Vector3:
        """Position of a fix in this frame, metres; up is NaN unless both heights were measured."""
        height = fix.altitude_m if fix.has_altitude else self._origin[2]
        x, y, z = _ecef(fix.latitude_deg, fix.longitude_deg, height)
        x0, y0, z0 = _ecef(*self._origin)
        east, north, up = uvw2enu(x - x0, y - y0, z - z0, *self._origin[:2])
        measured = self.has_height and fix.has_altitude
        return float(east), float(north), float(up) if measured else math.nan


@lru_cache(maxsize=64)
def _ecef(latitude_deg: float, longitude_deg: float, altitude_m: float) -> Vector3:
    """Earth-centred coordinates, m. Many parts ask for those of the same fixes."""
    x, y, z = pymap3d.geodetic2ecef(latitude_deg, longitude_deg, altitude_m)
    return float(x), float(y), float(z)
