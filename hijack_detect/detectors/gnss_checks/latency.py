# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A receiver whose fixes and velocities become later: what that does to steps of position."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hijack_detect.detectors.gnss_checks.step import Step
from hijack_detect.streams.samples import Vector3

GROWTH = 0.15
"""s/s. The latency grows no faster: a link that fills up, 1.5 s within 10 s. It may fall at once,
as a backlog drains."""
MOST_S = 1.5
"""s. It grows by no more: what a link holds back without a loss that is seen as one."""
SEEN = 1.0
"""s/s. A step back counts for no faster growth of what was seen: the noise of a step, 0.1 m at
5 Hz, is 0.1 s/s at 5 m/s and must count with both signs, a jump must not count."""
FORGET_PER_S = 1.0 / 600.0
"""What was seen is forgotten at this relative rate, s⁻¹: on clean flights, too, 0.1 to 0.3 s are
seen, and up to 1.3 s on quad106 and vancouver, whose positions and velocities disagree."""
MOVING = 2.0
"""m/s; slower, the noise of a step is no time."""
PERIODS, PERIOD_S = 50, 600.0
"""The receiver's period is the mean of its intervals so far, and later that of 600 s, which a
growth within a minute hardly changes; used once so many were seen."""
EVEN = 0.3
"""An interval further from the period, as a part of it, is of a lost fix or a backlog."""
UNEVEN = 0.15
"""Where intervals are off the period by this part of it in the mean, they do not say how late the
fixes are."""
SLACK_S = 0.1
"""So much growth may be missed by the intervals: stamps of recorded flights vary by up to that."""
AROUND = np.array([[math.cos(math.pi * k / 16), math.sin(math.pi * k / 16)] for k in range(32)]).T
UP_AND_DOWN = np.array([[1.0, -1.0]])
"""Unit vectors that a difference is looked at from, beside those across the mean velocity."""


class LatencySeen:
    """By how much later fixes have become since the earliest, from what they fall short.

    At a latency that grows by r s/s both the position and the velocity of a stamp are late, and
    the position moves by (1 - r) times the velocity. The sum of what it falls short on its way,
    in seconds of it, is the growth. In a hover there is no such way: there the intervals between
    fixes say it, which a receiver takes at even times and which a growth makes longer. Where they
    are even they also bound it: a position that is pulled back does not make them longer. It says
    nothing of who makes it.
    """

    def __init__(self) -> None:
        """Start without growth."""
        self.late_s = 0.0
        """Growth of the latency, within 0 and MOST_S, seconds."""
        self.before_s = 0.0
        """The same before the newest step."""
        self.may_s = 0.0
        """Sum of what the latency may have grown by in each step by the intervals, seconds; falls
        count as well."""
        self._uneven_s = 0.0
        """Mean deviation of the intervals from the period."""
        self._period_s = 0.0
        self._fixes = 0

    def add(self, step: Step) -> None:
        """Take the next step."""
        self.before_s = self.late_s
        grown_s = self._by_interval(step.dt_s)
        even = self._fixes > PERIODS and self._uneven_s < UNEVEN * self._period_s
        self.may_s += grown_s if even else GROWTH * step.dt_s
        residual, velocity = step.residual, step.velocity
        if residual is not None and velocity is not None and step.from_velocity:
            squared = velocity[0] ** 2 + velocity[1] ** 2
            if squared >= MOVING**2:
                grown_s = -(residual[0] * velocity[0] + residual[1] * velocity[1]) / squared
        kept_s = self.late_s * max(0.0, 1.0 - FORGET_PER_S * step.dt_s)
        self.late_s = max(0.0, min(MOST_S, kept_s + min(grown_s, SEEN * step.dt_s)))

    def _by_interval(self, dt_s: float) -> float:
        """Growth by the interval between two fixes, of which some may have been lost, seconds."""
        period_s = self._period_s
        if self._fixes and abs(dt_s - period_s) >= EVEN * period_s and self._fixes >= PERIODS:
            return dt_s - max(1, round(dt_s / period_s)) * period_s
        self._fixes += 1
        weight = max(1.0 / self._fixes, min(1.0, dt_s / PERIOD_S))
        self._uneven_s += weight * (abs(dt_s - period_s) - self._uneven_s)
        self._period_s += weight * (dt_s - period_s)
        return dt_s - period_s if self._fixes > PERIODS else 0.0


@dataclass(frozen=True, slots=True)
class Passed:
    """What latency may have done over a step (m, m/s, s, s; see `unexplained`, `LatencySeen`)."""

    expected: Vector3
    velocity: Vector3
    late_s: float
    may_s: float


def unexplained(difference: Vector3, passed: Sequence[Passed]) -> tuple[float, float]:
    """Least length of a difference that no admitted change of latency explains, m.

    A growth of g seconds during a step takes g times its velocity off the position, a fall puts it
    on. Admitted are growths of up to GROWTH in each step, together of what is left to MOST_S and
    of what the intervals between the fixes admit, and falls of as much as had been seen of growth.
    What they can reach is a convex set; the distance to it is the largest that the difference goes
    beyond it in any direction.

    Args:
        difference: Change of position less the integral of the velocity.
        passed: The steps in which it came about, not empty.

    Returns:
        Horizontally and in height, each by itself.
    """
    may_s = max(one.may_s for one in passed) - passed[0].may_s + SLACK_S
    left_s = min(MOST_S - passed[0].late_s, may_s)
    seen_s = max(one.late_s for one in passed)
    expected = np.array([one.expected for one in passed])
    velocity = np.array([one.velocity for one in passed])
    found = []
    way = expected[:, :2].sum(axis=0)
    length = float(np.hypot(way[0], way[1]))
    aside = np.array([[-way[1], way[1]], [way[0], -way[0]]]) / (length or 1.0)
    around = np.hstack((AROUND, aside))
    for axes, directions in ((slice(0, 2), around), (slice(2, 3), UP_AND_DOWN)):
        along, speed = expected[:, axes] @ directions, velocity[:, axes] @ directions
        growing = GROWTH * np.maximum(-along, 0.0).sum(axis=0)
        back = np.minimum(growing, left_s * np.maximum(-speed, 0.0).max(axis=0))
        ahead = seen_s * np.maximum(speed, 0.0).max(axis=0)
        beyond = np.array(difference[axes]) @ directions - back - ahead
        found.append(max(0.0, float(beyond.max())))
    return found[0], found[1]


def without_latency(residual: Vector3, velocity: Vector3, seconds: float, seen_s: float) -> Vector3:
    """What no admitted change of latency explains of what a position moved too far, m.

    Only along the path, and in motion: it falls short by what GROWTH makes in the time, or is ahead
    by what had been seen of growth.

    Args:
        residual: Change of position less the expected one.
        velocity: Velocity, m/s.
        seconds: In which it came about.
        seen_s: `late_s` before that.
    """
    squared = velocity[0] ** 2 + velocity[1] ** 2
    if squared < MOVING**2:
        return residual
    along_s = (residual[0] * velocity[0] + residual[1] * velocity[1]) / squared
    taken_s = max(-GROWTH * seconds, min(seen_s, along_s))
    return (residual[0] - taken_s * velocity[0], residual[1] - taken_s * velocity[1], residual[2])


def later_words(later_s: float) -> str:
    """A growth of the latency in words."""
    return f"the GPS has become later by {later_s:.1f} s, which explains its position"
