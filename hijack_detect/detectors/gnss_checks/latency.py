# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A receiver whose fixes and velocities become later: what that does to steps of position."""

from __future__ import annotations

import math
import statistics
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hijack_detect.detectors.gnss_checks.step import WINDOW_NS, Step, without_part
from hijack_detect.estimation.lag_ekf import GROWTH, MOST_GROWTH_S
from hijack_detect.streams.samples import NANOSECONDS, Vector3

MAX_SHORT_RATE = 1.0
"""s/s. `short_s` rises no faster than this in a step. The noise of a step, 0.1 m at 5 Hz, is
0.1 s/s at 5 m/s and has to cancel, so both signs of it count; a jump is far above it."""
FORGET_PER_S = 1.0 / 600.0
"""`short_s` and `backlog_s` decay at this relative rate, s⁻¹: on clean flights, too, positions fall
short by 0.1 to 0.3 s, and by up to 1.3 s on quad106 and vancouver, where they disagree with the
velocities."""
MOVING = 2.0
"""m/s; slower, the noise of a step is no time. Chosen, not swept."""
BLIND_S, BLIND_PERIODS = 0.5, 1.5
"""A step without a velocity for longer than both shows no latency: the trapezoid over a
brake from 12 to 3 m/s in a hole of 3 s is 1.5 s wrong."""
PERIODS, PERIOD_S = 50, 600.0
"""The receiver's period is the mean of its first 50 intervals, then of all, later of 600 s, which a
growth within a minute hardly changes. Chosen, not swept."""
CLIP_JITTERS, CLIP_PERIOD = 3.0, 0.01
"""An interval moves the mean as if it were off by at most this many mean deviations, or this part
of the period if that is more: a growth early in a flight would else count as a longer period.
Chosen, not swept."""
MAX_INTERVAL_S = 2.0
"""A longer interval is an outage, and shows neither period nor latency.
Chosen, not swept."""
NEAR = 0.3
"""An interval within this part of the period counts for the period. One further off is a lost fix
or a backlog. Chosen, not swept."""
CHANGED = 0.2
"""If the median of the last PERIODS intervals is off the period by more than this part of it, the
receiver has another rate, and its period is learnt again. A growth changes it by GROWTH.
Chosen, not swept."""
MAX_JITTER = 0.15
"""If the intervals differ from the period by more than this part of it in the mean, they are too
uneven to measure a latency. Chosen, not swept."""
SLACK_S = 0.1
"""Change of the latency that the intervals may miss: recorded stamps vary by this much."""
LAG_S = 0.2
"""Receivers' positions may lead or lag their velocities by this: a change of velocity Δv then
shows as a difference of up to 0.2 s · Δv, which is taken off."""
AROUND = np.array([[math.cos(math.pi * k / 16), math.sin(math.pi * k / 16)] for k in range(32)]).T
UP_AND_DOWN = np.array([[1.0, -1.0]])
"""Unit vectors that a difference is looked at from, beside those across the mean velocity."""


class FixIntervals:
    """Learns the period of a receiver from the intervals between its fixes."""

    def __init__(self) -> None:
        """Start without intervals."""
        self._recent: deque[float] = deque(maxlen=PERIODS)
        self._count = 0
        """Intervals in the period; 0 while it is not known."""
        self._jitter_s = 0.0
        """Mean deviation from the period."""
        self.period_s = 0.0
        """Seconds; 0 while it is not known."""

    @property
    def even(self) -> bool:
        """Whether they measure a change of latency."""
        return self._count > 0 and self._jitter_s < MAX_JITTER * self.period_s

    def add(self, dt_s: float) -> float:
        """Growth of the latency by the next interval, s; 0 where it does not show."""
        if dt_s > MAX_INTERVAL_S:
            return 0.0
        self._recent.append(dt_s)
        if not self._count:
            if len(self._recent) == PERIODS:
                self._learn()
            return 0.0
        period_s = self.period_s
        if abs(statistics.median(self._recent) - period_s) > CHANGED * period_s:
            self._recent.clear()
            self._count, self.period_s = 0, 0.0
            return 0.0
        if abs(dt_s - period_s) >= NEAR * period_s:
            return dt_s - max(1, round(dt_s / period_s)) * period_s
        self._count += 1
        weight = max(1.0 / self._count, min(1.0, dt_s / PERIOD_S))
        most_s = max(CLIP_JITTERS * self._jitter_s, CLIP_PERIOD * period_s)
        off_s = max(-most_s, min(most_s, dt_s - period_s))
        self._jitter_s += weight * (abs(off_s) - self._jitter_s)
        self.period_s += weight * off_s
        return dt_s - period_s

    def _learn(self) -> None:
        """Take the period from the recent intervals, without lost fixes and backlogs."""
        middle_s = statistics.median(self._recent)
        near = [one for one in self._recent if abs(one - middle_s) <= NEAR * middle_s]
        if near:
            self._count, self.period_s = len(near), math.fsum(near) / len(near)
            self._jitter_s = math.fsum(abs(one - self.period_s) for one in near) / len(near)


@dataclass(frozen=True, slots=True)
class LatencyMark:
    """What is known of the latency at a fix, seconds."""

    short_s: float = 0.0
    """Seconds of its way that the position has fallen short, within 0 and MOST_GROWTH_S."""
    backlog_s: float = 0.0
    """Growth that the intervals show and that has not fallen again, within 0 and MOST_GROWTH_S;
    0 where they are uneven."""
    bound_s: float = 0.0
    """Sum of what the latency can have grown in each step: by the interval, falls included, where
    these are even, otherwise by GROWTH."""

    @property
    def seen_s(self) -> float:
        """Growth by either measure. A fall is explained up to this, if the intervals show it."""
        return max(self.short_s, self.backlog_s)


class LatencySeen:
    """Measures how much later fixes have become, by their positions and by their intervals.

    While the latency grows by r s/s, both the position and the velocity of a stamp are late, and
    the position moves by (1 - r) times the velocity. `short_s` sums up what is missing. In a hover
    nothing is missing; there it follows the intervals.

    A receiver takes fixes at even times. A latency that grows makes the intervals between stamps
    longer, one that falls makes them shorter, whatever the position does. So a position that is
    pulled back is explained only as far as intervals became longer meanwhile, and one that runs
    ahead only as far as they became shorter. Where they are uneven, running ahead is not explained.
    """

    def __init__(self) -> None:
        """Start without growth."""
        self._intervals = FixIntervals()
        self.now = LatencyMark()
        """At the newest fix."""
        self.before = LatencyMark()
        """At the fix before."""

    def add(self, step: Step) -> None:
        """Take the next step."""
        self.before = before = self.now
        known = self._intervals.period_s > 0.0
        grown_s = self._intervals.add(step.dt_s)
        even = self._intervals.even
        if known and not self._intervals.period_s:
            before = LatencyMark(bound_s=before.bound_s)
        kept = max(0.0, 1.0 - FORGET_PER_S * step.dt_s)
        short_s = min(self._short(step, grown_s), MAX_SHORT_RATE * step.dt_s)
        self.now = LatencyMark(
            _bounded(kept * before.short_s + short_s),
            _bounded(kept * before.backlog_s + grown_s) if even else 0.0,
            before.bound_s + (grown_s if even else GROWTH * step.dt_s),
        )

    def change_s(self, start: LatencyMark, seconds: float) -> tuple[float, float]:
        """Largest growth and largest fall of the latency since a mark, s.

        Args:
            start: The mark.
            seconds: Time since then.
        """
        if not self._intervals.even:
            return GROWTH * min(seconds, WINDOW_NS / NANOSECONDS), 0.0
        grown_s = self.now.bound_s - start.bound_s
        return (
            min(GROWTH * seconds, max(0.0, grown_s) + SLACK_S),
            min(start.seen_s, max(0.0, -grown_s) + SLACK_S),
        )

    def measured_s(self, start: LatencyMark) -> tuple[float, float]:
        """Growth and fall since a mark that the intervals show, s, without slack; 0 if uneven."""
        grown_s = self.now.bound_s - start.bound_s if self._intervals.even else 0.0
        return max(0.0, grown_s), min(start.seen_s, max(0.0, -grown_s))

    def _short(self, step: Step, grown_s: float) -> float:
        """Seconds that the position falls short in a step; by the interval where it is unclear."""
        residual, velocity = step.residual, step.velocity
        blind = step.blind_s > max(BLIND_S, BLIND_PERIODS * self._intervals.period_s)
        if residual is None or velocity is None or not step.from_velocity or blind:
            return grown_s
        squared = velocity[0] ** 2 + velocity[1] ** 2
        if squared < MOVING**2:
            return grown_s
        return -(residual[0] * velocity[0] + residual[1] * velocity[1]) / squared


def _bounded(seconds: float) -> float:
    return max(0.0, min(MOST_GROWTH_S, seconds))


@dataclass(frozen=True, slots=True)
class Passed:
    """A step, for `unexplained`."""

    expected: Vector3
    """Change of position by the velocities, m."""
    velocity: Vector3
    """At its end, m/s."""
    latency: LatencyMark
    """At its end."""


def unexplained(
    difference: Vector3, start: LatencyMark, passed: Sequence[Passed]
) -> tuple[float, float]:
    """Least length of a difference that no admitted change of latency explains, m.

    A growth of g seconds during a step takes g times its velocity off the position, a fall puts it
    on. Admitted are growths of up to GROWTH in each step, together of what is left to
    MOST_GROWTH_S and of what the intervals between the fixes admit, and falls of as much as the
    intervals show. What they can reach is a convex set; the distance to it is the largest that the
    difference goes beyond it in any direction.

    Args:
        difference: Change of position less the integral of the velocity.
        start: The latency before the steps.
        passed: The steps in which it came about, not empty.

    Returns:
        Horizontally and in height, each by itself.
    """
    bound_s = np.array([start.bound_s, *(one.latency.bound_s for one in passed)])
    grown_s = float((bound_s - np.minimum.accumulate(bound_s)).max())
    left_s = min(MOST_GROWTH_S - start.short_s, grown_s + SLACK_S)
    seen_s = max(start.seen_s, *(one.latency.seen_s for one in passed))
    fallen_s = float((np.maximum.accumulate(bound_s) - bound_s).max())
    fall_s = min(seen_s, fallen_s + SLACK_S)
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
        ahead = fall_s * np.maximum(speed, 0.0).max(axis=0)
        beyond = np.array(difference[axes]) @ directions - back - ahead
        found.append(max(0.0, float(beyond.max())))
    return found[0], found[1]


def without_latency(
    residual: Vector3, first: Vector3, last: Vector3, growth_s: float, fall_s: float
) -> Vector3:
    """What no admitted change of latency explains of what a position moved too far, m.

    Only along the path, and in motion. What a backlog on a circle hides is the chord of its arc,
    whose direction is the mean of the two velocities at its ends.

    Args:
        residual: Change of position less the expected one.
        first: Velocity before it, m/s.
        last: Velocity after it, m/s.
        growth_s: Largest growth meanwhile, s: the position falls short by it.
        fall_s: Largest fall meanwhile, s: the position is ahead by it.
    """
    velocity = (0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1]))
    squared = velocity[0] ** 2 + velocity[1] ** 2
    if squared < MOVING**2:
        return residual
    return without_part(residual, (*velocity, 0.0), -growth_s, fall_s)


def without_lag(difference: Vector3, change: Vector3) -> Vector3:
    """The part of a difference that no lag within LAG_S explains.

    Args:
        difference: Change of position less the integral of the velocity, m.
        change: Of the velocity, m/s.
    """
    return without_part(difference, change, -LAG_S, LAG_S)


def later_words(later_s: float) -> str:
    """A growth of the latency in words."""
    return f"the GPS has become later by {later_s:.1f} s, which explains its position"
