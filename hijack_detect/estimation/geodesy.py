# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Fixes in a local tangent plane."""

from __future__ import annotations

import dataclasses
import math
from functools import lru_cache
from typing import TypeAlias

import pymap3d
from pymap3d.ecef import enu2uvw, uvw2enu

from hijack_detect.streams.samples import FixSample, Vector3, VelocitySample


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


Geodetic: TypeAlias = tuple[float, float]
"""Latitude and longitude in degrees, longitude within [-180, 180]."""


class TangentPlane(LocalFrame):
    """East, North, Up in metres about one fix, and the way back."""

    def geodetic(self, position: Vector3) -> Geodetic:
        """Latitude and longitude of a position in this plane (metres).

        The height is left to the caller: over kilometres a flat plane rises above the ground.
        """
        east, north, up = position
        latitude, longitude, _ = pymap3d.enu2geodetic(
            east, north, 0.0 if math.isnan(up) else up, *self._origin
        )
        return (float(latitude), float(longitude))

    def velocity_at(self, velocity: Vector3, place: Geodetic) -> Vector3:
        """Turn a horizontal velocity of this plane into East and North of another place.

        North is not the same direction everywhere; 10 km from a pole 100 m of distance turn it by
        half a degree. The vertical part is handed through.
        """
        return turned(velocity, self._origin[:2], place)


def turned(velocity: Vector3, origin: Geodetic, place: Geodetic) -> Vector3:
    """Express the horizontal part of an ENU velocity at `origin` in ENU at `place`."""
    if origin == place:
        return velocity
    uvw = enu2uvw(velocity[0], velocity[1], 0.0, *origin)
    east, north, _ = uvw2enu(*uvw, *place)
    return (float(east), float(north), velocity[2])


def moved(fix: FixSample, place: Geodetic, altitude_m: float) -> FixSample:
    """Return the fix with another position and its own stamp.

    A receiver that does not measure the height (NaN) reports none elsewhere either.
    """
    height = altitude_m if fix.has_altitude else math.nan
    return dataclasses.replace(
        fix, latitude_deg=place[0], longitude_deg=place[1], altitude_m=height
    )


def with_velocity(true: VelocitySample, velocity: Vector3) -> VelocitySample:
    """Return the sample with another velocity, vertically only where the receiver measures it."""
    east, north, up = velocity
    return dataclasses.replace(true, velocity=(east, north, up if true.has_vertical else math.nan))


def separation_m(one: FixSample, other: FixSample) -> float:
    """Straight distance between two fixes in three dimensions, metres; in two without heights."""
    east, north, up = TangentPlane(one).enu(other)
    up = 0.0 if math.isnan(up) else up
    return float((east * east + north * north + up * up) ** 0.5)
