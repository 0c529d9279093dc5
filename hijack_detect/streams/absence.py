# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which components of a receiver's samples were measured, and which are only fillers.

Formats without a value for "not measured" carry 0 instead: mavros never fills the vertical
velocity, receivers that speak NMEA have none, some drivers leave the height above the ellipsoid
at 0, and a number of satellites of 255 means unknown in MAVLink.
"""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from typing import TypeVar

from hijack_detect.streams.merge import RESTART_S
from hijack_detect.streams.samples import NANOSECONDS, FixSample, VelocitySample

UNKNOWN_COUNT = 255
"""Number of satellites where the autopilot does not know it (MAVLink, uint8)."""
MOVING = 1.0
"""m/s over ground. No receiver measures a vertical velocity of exactly 0 several times at this
speed: the noise of the quietest (u-blox M8 to F9) is 0.01 to 0.05 m/s at a resolution of 1 mm/s."""
REPEATS = 20
"""Samples in motion after which a component that stays the same is a filler: 2 s at 10 Hz."""
MOVED_M = 30.0
"""A height that is the same to the bit is a filler once the vehicle has moved as far: GPS height
wanders by decimetres in that time, and the coarsest resolution in use is 0.1 m (NMEA)."""
DEGREE_M = 111_320.0
"""Length of a degree of latitude, and of longitude on the equator."""

VERTICAL_VELOCITY, HEIGHT, SATELLITES = "vertical GPS velocity", "GPS height", "satellites"

T = TypeVar("T")


class Absence:
    """Takes the samples of one receiver, in order of arrival, and marks what was not measured.

    The decision on each input depends on the samples of that input alone, so a part that
    subscribes to one input and a part that subscribes to all decide alike. Marking twice is
    marking once.

    * Vertical velocity (NaN): 0 since the stream began; again 0 in REPEATS samples in motion.
    * Height (NaN): 0 since the stream began, or the same to the bit since then while the vehicle
      moved by MOVED_M. A height that has changed once is measured.
    * Satellites (None): UNKNOWN_COUNT, or 0 since the stream began.

    Attributes:
        counts: How many samples in motion lacked a component, by its name.
    """

    def __init__(self) -> None:
        """Start before the first sample."""
        self.counts: Counter[str] = Counter()
        self._velocity = _Velocity()
        self._height = _Height()
        self._counted = False

    def __call__(self, sample: T) -> T | None:
        """The sample with NaN where it was not measured; None if nothing of it was.

        Args:
            sample: A `FixSample`, a `VelocitySample`, or the bare number of satellites; any
                other sample is returned as it is.
        """
        if isinstance(sample, VelocitySample):
            self._velocity = self._velocity.at(sample.stamp_ns)
            if self._velocity.measured(sample):
                return sample
            self.counts[VERTICAL_VELOCITY] += _moves(sample)
            east, north, _ = sample.velocity
            if not sample.has_vertical:
                return sample
            return dataclasses.replace(sample, velocity=(east, north, math.nan))
        if isinstance(sample, FixSample):
            self._height = self._height.at(sample.stamp_ns)
            if not sample.has_fix or self._height.measured(sample):
                return sample
            self.counts[HEIGHT] += 1
            if not sample.has_altitude:
                return sample
            return dataclasses.replace(sample, altitude_m=math.nan)
        if type(sample) is int:
            self._counted = self._counted or sample not in (0, UNKNOWN_COUNT)
            if sample == UNKNOWN_COUNT or not self._counted:
                self.counts[SATELLITES] += 1
                return None
        return sample

    @property
    def names(self) -> list[str]:
        """The components that are lacking for more than a start."""
        return [name for name, count in self.counts.items() if count >= REPEATS]


class _Stream:
    """What is remembered of one input, until its clock runs far backwards: another recording."""

    def __init__(self) -> None:
        self._newest_ns: int | None = None

    def at(self: S, stamp_ns: int) -> S:
        """This, or one that starts at the stamp."""
        newest_ns = self._newest_ns
        if newest_ns is not None and newest_ns - stamp_ns > RESTART_S * NANOSECONDS:
            return type(self)().at(stamp_ns)
        self._newest_ns = stamp_ns if newest_ns is None else max(newest_ns, stamp_ns)
        return self


S = TypeVar("S", bound=_Stream)


class _Velocity(_Stream):
    def __init__(self) -> None:
        super().__init__()
        self._filled = False
        self._zeros = 0

    def measured(self, sample: VelocitySample) -> bool:
        """Whether the vertical component was."""
        up = sample.velocity[2]
        if math.isnan(up):
            return False
        if up != 0.0:
            self._filled, self._zeros = True, 0
        elif _moves(sample):
            self._zeros += 1
            self._filled = self._filled and self._zeros < REPEATS
        return self._filled


class _Height(_Stream):
    def __init__(self) -> None:
        super().__init__()
        self._first: FixSample | None = None
        self._varies = self._moved = False
        self._fixes = 0

    def measured(self, fix: FixSample) -> bool:
        """Whether the height was."""
        if self._varies or not fix.has_altitude:
            return fix.has_altitude
        self._first = first = self._first or fix
        if fix.altitude_m != first.altitude_m:
            self._varies = True
            return True
        self._fixes += 1
        far = self._fixes > REPEATS and _apart_m(first, fix) > MOVED_M
        self._moved = self._moved or far
        return fix.altitude_m != 0.0 and not self._moved


def _moves(sample: VelocitySample) -> bool:
    return math.hypot(sample.velocity[0], sample.velocity[1]) >= MOVING


def _apart_m(one: FixSample, other: FixSample) -> float:
    """Horizontal distance on a sphere, good to a percent over kilometres."""
    east = math.remainder(other.longitude_deg - one.longitude_deg, 360.0)
    north = other.latitude_deg - one.latitude_deg
    return DEGREE_M * math.hypot(east * math.cos(math.radians(one.latitude_deg)), north)
