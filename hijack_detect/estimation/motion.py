# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Velocity over ground: that of the GPS, or differences of fixes where it gives none."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.course import displacement
from hijack_detect.estimation.rotation import Array
from hijack_detect.streams.samples import NANOSECONDS, FixSample, VelocitySample


@dataclass(frozen=True, slots=True)
class Motion:
    """A velocity over ground.

    Attributes:
        stamp_ns: Stamp of the message that it came with.
        middle_ns: Stamp at which it was measured; half-way between the two fixes of a difference.
        velocity: ENU, m/s, shape (3,); the vertical component is NaN where it was not measured.
        from_fixes: Whether it is a difference of fixes, with the noise of two positions over
            their interval.
    """

    stamp_ns: int
    middle_ns: int
    velocity: Array
    from_fixes: bool


class GpsMotion:
    """Velocities of one receiver, from its velocities or from its fixes.

    The difference of two fixes is p₂ − p₁ over t₂ − t₁ in the tangent plane at the first one.

    Attributes:
        last_fix: The last fix, None if it had no position.
    """

    def __init__(self, patience_s: float, max_gap_s: float = math.inf) -> None:
        """Start without samples.

        Args:
            patience_s: Differences of fixes count once there was no velocity for longer, s.
            max_gap_s: Two fixes further apart give no velocity, s.
        """
        self._patience_ns = round(patience_s * NANOSECONDS)
        self._max_gap_ns = max_gap_s * NANOSECONDS
        self._velocity_ns: int | None = None
        self.last_fix: FixSample | None = None

    def velocity(self, sample: VelocitySample) -> Motion:
        """Take a GPS velocity."""
        stamp = self._velocity_ns = sample.stamp_ns
        return Motion(stamp, stamp, np.array(sample.velocity), False)

    def fix(self, fix: FixSample) -> Motion | None:
        """Take a fix; the velocity from the one before, None without one."""
        before, self.last_fix = self.last_fix, fix if fix.has_fix else None
        if before is None or not fix.has_fix:
            return None
        dt_ns = fix.stamp_ns - before.stamp_ns
        if not 0 < dt_ns <= self._max_gap_ns:
            return None
        velocity = np.array(displacement(before, fix)) * (NANOSECONDS / dt_ns)
        return Motion(fix.stamp_ns, fix.stamp_ns - dt_ns // 2, velocity, True)

    def measured(self, stamp_ns: int) -> bool:
        """Whether the receiver's own velocities are the ones to use at a stamp."""
        last = self._velocity_ns
        return last is not None and stamp_ns - last <= self._patience_ns


def climb_between(previous: FixSample | None, fix: FixSample) -> float:
    """Climb from one fix to the next, m/s; 0 where it is not known."""
    if previous is None or not (fix.has_fix and fix.has_altitude and previous.has_altitude):
        return 0.0
    dt_ns = fix.stamp_ns - previous.stamp_ns
    return (fix.altitude_m - previous.altitude_m) * NANOSECONDS / dt_ns if dt_ns else 0.0
