# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Makes steps of fixes, velocities and numbers of satellites."""

from __future__ import annotations

import math

from hijack_detect.detectors.gnss_checks.step import ZERO, Step, known, plus
from hijack_detect.estimation.course import displacement
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    SatelliteSample,
    Vector3,
    VelocitySample,
)

MAX_AGE_NS = NANOSECONDS
"""A velocity older than this says nothing of a fix, and a count nothing either."""
MAX_EXTRAPOLATION_S = 2.0
"""A step over a longer time is not extrapolated."""


class Track:
    """Holds the newest samples; the integral of velocity is by trapezoids between its stamps."""

    def __init__(self) -> None:
        """Start without samples."""
        self._velocity: VelocitySample | None = None
        self._integral: Vector3 = ZERO
        self._longest_s = 0.0
        self._count: SatelliteSample | None = None
        self._fix: FixSample | None = None
        self._at_fix: tuple[Vector3, Vector3] | None = None
        """Velocity and its integral at the last fix."""
        self._level = False
        """Whether a velocity since the last fix has no vertical component."""
        self._speed: Vector3 | None = None
        """Mean velocity of the step before."""

    def velocity(self, sample: VelocitySample) -> None:
        """Integrate up to a velocity."""
        before, self._velocity = self._velocity, sample
        if before is None:
            return
        dt = (sample.stamp_ns - before.stamp_ns) / NANOSECONDS
        both = plus(known(before.velocity), known(sample.velocity))
        self._integral = plus(self._integral, both, 0.5 * dt)
        self._level = self._level or not (before.has_vertical and sample.has_vertical)
        self._longest_s = max(self._longest_s, dt)

    def satellites(self, sample: SatelliteSample) -> None:
        """Note a number of satellites."""
        self._count = sample

    def fix(self, fix: FixSample) -> Step | None:
        """The step that ends with a fix; None at the first one."""
        previous, self._fix = self._fix, fix
        before, self._at_fix = self._at_fix, self._integral_at(fix.stamp_ns)
        longest_s, self._longest_s = self._longest_s, 0.0
        newest = self._velocity
        flat = newest is not None and not newest.has_vertical
        level, self._level = self._level or flat, flat
        if previous is None:
            return None
        dt = (fix.stamp_ns - previous.stamp_ns) / NANOSECONDS
        moved = displacement(previous, fix)
        mean, self._speed = self._speed, None
        if dt <= MAX_EXTRAPOLATION_S:
            self._speed = (moved[0] / dt, moved[1] / dt, moved[2] / dt)
        now = self._at_fix
        if before is not None and now is not None:
            expected: Vector3 | None = plus(now[1], before[1], -1.0)
            if level and expected is not None:
                up = math.nan if mean is None else mean[2] * dt
                expected = (expected[0], expected[1], up)
        else:
            expected = None if mean is None else plus(ZERO, mean, dt)
        return Step(
            previous,
            fix,
            dt,
            moved,
            None if before is None else before[0],
            None if now is None else now[0],
            expected,
            max(dt, longest_s),
            self._count.count
            if self._count is not None and fix.stamp_ns - self._count.stamp_ns <= MAX_AGE_NS
            else None,
            level and before is not None and now is not None,
        )

    def _integral_at(self, stamp_ns: int) -> tuple[Vector3, Vector3] | None:
        newest = self._velocity
        if newest is None or stamp_ns - newest.stamp_ns > MAX_AGE_NS:
            return None
        ahead_s = (stamp_ns - newest.stamp_ns) / NANOSECONDS
        return newest.velocity, plus(self._integral, known(newest.velocity), ahead_s)
