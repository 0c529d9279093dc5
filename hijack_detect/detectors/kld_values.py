# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From GPS samples to the counts whose Poisson distributions are compared.

Each class takes fixes, velocities and numbers of satellites in order of stamp and returns the
counts of the parameters that the sample tells of; None where a parameter cannot be told now.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Protocol

from hijack_detect.detectors.kld_parameters import KldParameters
from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    GpsSample,
    SatelliteSample,
    VelocitySample,
)

Counts = Mapping[str, float | None]

ALTITUDES_M, SPEEDS, SATELLITES = (0.0, 1000.0), (0.0, 40.0), (0.0, 34.0)
"""Ranges of Table 2: metres, m/s, number."""
ALTITUDE_M, SPEED, ANGLE_DEG = 0.1, 0.1, 1e-7
"""Units of Table 2: metres, m/s, degrees of latitude and longitude."""


class Values(Protocol):
    """A way to make counts."""

    def __call__(self, sample: GpsSample) -> Counts:
        """Counts by the name of the parameter."""
        ...


class Table2Values:
    """The values themselves, in the units of Table 2 of Basan 2022, within its ranges.

    Altitude, speed and satellites are cut off at the ends of their ranges. Angles are negative in
    half of the world, where no Poisson distribution is: the track angle is shifted by 180° to
    0-360, and latitude and longitude are the change since the first fix, shifted by the 90° and
    180° of their ranges. The track angle therefore leaps by 360 where it passes South.
    """

    def __init__(self, *, within_ranges: bool = True) -> None:
        """Start without a first fix; without ranges nothing is cut off."""
        self._first: FixSample | None = None
        self._within_ranges = within_ranges

    def __call__(self, sample: GpsSample) -> Counts:
        """See Values."""
        if isinstance(sample, SatelliteSample):
            return {"satellites": self._cut(sample.count, SATELLITES)}
        if isinstance(sample, VelocitySample):
            east, north, _ = sample.velocity
            return {
                "speed": float(round(self._cut(math.hypot(east, north), SPEEDS) / SPEED)),
                "track": float(round(math.degrees(math.atan2(east, north))) + 180),
            }
        self._first = first = self._first or sample
        longitude = math.remainder(sample.longitude_deg - first.longitude_deg, 360.0)
        return {
            "altitude": self._altitude(sample),
            "latitude": _shifted(sample.latitude_deg - first.latitude_deg, 90.0),
            "longitude": _shifted(longitude, 180.0),
        }

    def _altitude(self, fix: FixSample) -> float | None:
        if not fix.has_altitude:
            return None
        return float(round(self._cut(fix.altitude_m, ALTITUDES_M) / ALTITUDE_M))

    def _cut(self, value: float, limits: tuple[float, float]) -> float:
        return _within(value, limits) if self._within_ranges else value


class Changes:
    """How far each value is from going on as before, in whole steps.

    Position and height go on with the velocity of the last two fixes, speed, track angle and
    satellites stay. A step is what noise and an ordinary manoeuvre make of a value between two
    fixes, so that a flight has few of them at every rate, and a forged value of some metres many.
    """

    def __init__(self, parameters: KldParameters) -> None:
        """Start without samples."""
        self._parameters = parameters
        self._fixes: list[tuple[int, tuple[float, float, float]]] = []
        self._frame: LocalFrame | None = None
        self._velocity: VelocitySample | None = None
        self._count: int | None = None

    def __call__(self, sample: GpsSample) -> Counts:
        """See Values."""
        if isinstance(sample, SatelliteSample):
            before, self._count = self._count, sample.count
            return {"satellites": None if before is None else float(abs(sample.count - before))}
        if isinstance(sample, VelocitySample):
            last, self._velocity = self._velocity, sample
            return self._motion(last, sample)
        return self._position(sample)

    def _position(self, fix: FixSample) -> Counts:
        """Second differences of height, North and East, in steps."""
        p = self._parameters
        self._frame = frame = self._frame or LocalFrame(fix)
        east, north, _ = frame.enu(fix)
        place = (east, north, fix.altitude_m)
        earlier, self._fixes = self._fixes, [*self._fixes[-1:], (fix.stamp_ns, place)]
        names = ("longitude", "latitude", "altitude")
        if len(earlier) < 2:
            return dict.fromkeys(names)
        (t0, first), (t1, second) = earlier
        before_s, now_s = (t1 - t0) / NANOSECONDS, (fix.stamp_ns - t1) / NANOSECONDS
        ratio = now_s / before_s
        # White noise of three fixes in their second difference, against that of equal times.
        noise_m = p.scale_m * math.sqrt((1.0 + (1.0 + ratio) ** 2 + ratio**2) / 6.0)
        step_m = noise_m + p.acceleration * now_s * 0.5 * (before_s + now_s)
        return {
            name: _steps(abs(c - b - ratio * (b - a)) / step_m)
            for name, a, b, c in zip(names, first, second, place, strict=True)
        }

    def _motion(self, last: VelocitySample | None, now: VelocitySample) -> Counts:
        """Changes of ground speed and track angle, in steps."""
        p = self._parameters
        if last is None:
            return {"speed": None, "track": None}
        seconds = (now.stamp_ns - last.stamp_ns) / NANOSECONDS
        (east, north, _), (e0, n0, _) = now.velocity, last.velocity
        speed, before = math.hypot(east, north), math.hypot(e0, n0)
        counts: dict[str, float | None] = {
            "speed": float(round(abs(speed - before) / (p.acceleration * seconds))),
            "track": None,
        }
        if min(speed, before) > p.min_speed:
            turned = math.degrees(math.atan2(e0 * north - n0 * east, e0 * east + n0 * north))
            counts["track"] = float(round(abs(turned) / (p.turn_rate_deg_s * seconds)))
        return counts


def _steps(value: float) -> float | None:
    """A number in whole steps; None where it was not measured."""
    return None if math.isnan(value) else float(round(value))


def _within(value: float, limits: tuple[float, float]) -> float:
    return min(max(value, limits[0]), limits[1])


def _shifted(change_deg: float, shift_deg: float) -> float:
    """A change of angle in 1e-7 degrees, made positive."""
    return float(round((_within(change_deg, (-shift_deg, shift_deg)) + shift_deg) / ANGLE_DEG))
