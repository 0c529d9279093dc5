# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Input of a check at every fix, and its finding."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from hijack_detect.detectors.verdict import State
from hijack_detect.estimation.course import displacement
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    SatelliteSample,
    Vector3,
    VelocitySample,
)

MAX_AGE_NS = NANOSECONDS
"""A velocity or a count older than this is not used with a fix. Chosen, not swept."""
MAX_EXTRAPOLATION_S = 2.0
"""A step over a longer time is not extrapolated. Chosen, not swept."""


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


ZERO: Vector3 = (0.0, 0.0, 0.0)
RANK = (State.NORMAL, State.SUSPICIOUS, State.ALARM)
"""States of findings, those that claim more last."""
WINDOW_NS = 11 * NANOSECONDS // 10
"""A jump in several smaller steps over 1 s counts as one. Chosen, not swept."""


@dataclass(frozen=True, slots=True)
class Step:
    """From one fix to the next, in the tangent plane at the first (ENU, m, m/s).

    Attributes:
        previous: The fix before.
        fix: The fix.
        dt_s: Time between their stamps, seconds.
        moved: Change of position; up is NaN where a height was not measured.
        before: Velocity reported for the previous fix, None if there was none.
        velocity: Velocity reported for the fix, None if there is none; up may be NaN in both.
        expected: Change of position to expect: the integral of the velocities; from fixes alone
            the step before, extrapolated; None without either. Up is from fixes alone where
            `level`, and NaN where there is nothing to expect it from.
        blind_s: Longest time without a velocity (from fixes alone: without a fix) in the step.
        count: Number of satellites in use, None if it is not known.
        level: Whether a velocity in the step has no vertical component.
    """

    previous: FixSample
    fix: FixSample
    dt_s: float
    moved: Vector3
    before: Vector3 | None
    velocity: Vector3 | None
    expected: Vector3 | None
    blind_s: float
    count: int | None = None
    level: bool = False

    @property
    def stamp_ns(self) -> int:
        """Stamp of the fix."""
        return self.fix.stamp_ns

    @property
    def from_velocity(self) -> bool:
        """Whether `expected` comes from reported velocities."""
        return self.before is not None and self.velocity is not None

    @property
    def residual(self) -> Vector3 | None:
        """`moved - expected`, metres."""
        return None if self.expected is None else minus(self.moved, self.expected)

    @property
    def off_path(self) -> Vector3 | None:
        """The part of the residual that falling short on the expected way does not explain."""
        if self.expected is None:
            return None
        expected, moved = known(self.expected), known(self.moved)
        squared = dot(expected, expected)
        part = dot(moved, expected) / squared if squared else 0.0
        return plus(self.moved, self.expected, -max(0.0, min(1.0, part)))

    @property
    def claimed_m(self) -> float:
        """Larger accuracy that the receiver claims for the two fixes, m; 0 without a claim."""
        return max(self.fix.accuracy_m or 0.0, self.previous.accuracy_m or 0.0)

    def hidden_m(self, acceleration: float, *, by_velocity: bool) -> float:
        """Way that an acceleration (m/s²) hides, m: a dt²/4 between two velocities, else a dt²."""
        return acceleration * self.blind_s**2 * (0.25 if by_velocity else 1.0)

    @property
    def still(self) -> bool:
        """Whether the position repeats bit by bit."""
        return _place(self.fix) == _place(self.previous)


@dataclass(frozen=True, slots=True)
class Finding:
    """The finding of a check at a fix.

    `margin` is its evidence against what makes an alarm; a check that may only be SUSPICIOUS
    stays below 1. What is `innocent` by itself is no contradiction, and its text is complete.
    """

    margin: float = 0.0
    state: State = State.NORMAL
    text: str = ""
    innocent: bool = False

    @property
    def claims(self) -> tuple[int, float]:
        """How much it claims, to compare findings."""
        return RANK.index(self.state), self.margin


class Check(Protocol):
    """One check: takes every step in order of stamp, O(1) each."""

    @property
    def name(self) -> str:
        """Name in reasons and values."""

    def judge(self, step: Step) -> Finding:
        """Judge the newest fix."""


def minus(a: Vector3, b: Vector3) -> Vector3:
    """Difference of two vectors."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def plus(a: Vector3, b: Vector3, times: float = 1.0) -> Vector3:
    """`a + times b`."""
    return (a[0] + times * b[0], a[1] + times * b[1], a[2] + times * b[2])


def dot(a: Vector3, b: Vector3) -> float:
    """Scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def without_part(a: Vector3, b: Vector3, low: float, high: float) -> Vector3:
    """`a` without the multiple of `b`, from `low` to `high`, that leaves the least of it."""
    squared = math.fsum(one * one for one in b)
    if not squared:
        return a
    times = math.fsum(one * other for one, other in zip(a, b, strict=True)) / squared
    return plus(a, b, -max(low, min(high, times)))


def known(a: Vector3) -> Vector3:
    """A vector that is level where its vertical component was not measured."""
    return (a[0], a[1], 0.0) if math.isnan(a[2]) else a


def length(a: Vector3) -> float:
    """Length of a vector."""
    return math.sqrt(dot(a, a))


def _place(fix: FixSample) -> Vector3:
    return known((fix.latitude_deg, fix.longitude_deg, fix.altitude_m))
