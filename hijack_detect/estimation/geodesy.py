"""Fixes in a local tangent plane."""

from __future__ import annotations

import pymap3d

from hijack_detect.streams.samples import FixSample, Vector3


class LocalFrame:
    """East, north, up in metres about the first fix (WGS-84 tangent plane)."""

    def __init__(self, origin: FixSample) -> None:
        """Put the origin at a fix."""
        self._origin = (origin.latitude_deg, origin.longitude_deg, origin.altitude_m)

    def enu(self, fix: FixSample) -> Vector3:
        """Position of a fix in this frame, metres."""
        east, north, up = pymap3d.geodetic2enu(
            fix.latitude_deg, fix.longitude_deg, fix.altitude_m, *self._origin
        )
        return float(east), float(north), float(up)
