# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Change of position against the integral of the reported velocity, over several horizons."""

from __future__ import annotations

import itertools
import math
from collections import deque
from dataclasses import dataclass

from hijack_detect.detectors.gnss_checks.latency import (
    LatencyMark,
    LatencySeen,
    Passed,
    unexplained,
    without_lag,
)
from hijack_detect.detectors.gnss_checks.step import ZERO, Finding, Step, minus, plus
from hijack_detect.detectors.persistence import Persistence
from hijack_detect.estimation.learning import LearnedLevel
from hijack_detect.streams.samples import NANOSECONDS, Vector3

HORIZONS_S = (2.0, 5.0, 10.0, 20.0)
"""T of the limits, s. Chosen, not swept."""
MAX_GAP_S = 2.0
"""After a gap in fixes or velocities of this length everything starts over. Chosen, not swept."""
MOVING = 2.0
"""m/s; at rest a receiver is better, and worse while it starts, than in flight.
Chosen, not swept."""
WITHOUT_CLIMB = math.sqrt(2.0)
"""What is learnt is the larger of two differences; where only the horizontal one is known, the
limit is this much wider: the mean of the larger of two half-normal values over that of one."""
MAX_RATE = (5.0, 10.0)
"""m/s, horizontally and vertically: what a step differs by beyond this rate is a jump, which is
for the jump check, and must not weigh on 20 s. Chosen, not swept."""
WORTH_EXPLAINING = 0.4
"""Margin from which on latency is asked for an explanation: below, it would change nothing.
Chosen, not swept."""
LEAST_S = 0.05
"""A growth of less is not named: it would read as 0.0 s."""
LATER_NS = 10 * NANOSECONDS
"""A latency that was needed for an explanation is named for this long. Chosen, not swept."""


@dataclass(frozen=True)
class MismatchLimits:
    """See `GnssSanityParameters`."""

    base_m: float
    rate_m_s: float
    path_fraction: float
    vertical_base_m: float
    vertical_rate_m_s: float
    persist_s: float
    floor: float
    gain: float


@dataclass(frozen=True, slots=True)
class _Mark:
    stamp_ns: int
    difference: Vector3
    velocity: Vector3
    path_m: float
    passed: Passed


@dataclass(frozen=True, slots=True)
class _Difference:
    """Over one horizon.

    Attributes:
        level: The larger difference in units of its full limit.
        without: The same if nothing were laid to latency.
        text: The larger one in words.
    """

    level: float
    without: float
    text: str


class VelocityMismatchCheck:
    """Largest difference over the horizons, each against its limit, in plane and height.

    The limits are those of poor receivers times a part that a good receiver earns in flight,
    see `LearnedLevel`. What a latency that changes explains is taken off, see `unexplained`.
    """

    name = "velocity_mismatch"

    def __init__(self, limits: MismatchLimits, latency: LatencySeen) -> None:
        """Start without history; `latency` is given every step before this check is."""
        self._limits = limits
        self._latency = latency
        self.later_s: float | None = None
        """By how much later the fixes have become, where without that the margin would have been 1
        or more within the last LATER_NS; None where it would not."""
        self._later_ns = 0
        self._learned = LearnedLevel(limits.floor, limits.gain)
        self._persistence = Persistence(limits.persist_s)
        self._level = False
        self.begin()

    def begin(self) -> None:
        """Restart all horizons: at a take-off, since receivers wander on the ground."""
        self._windows: dict[float, deque[_Mark]] = {one: deque() for one in HORIZONS_S}
        self._mark = _Mark(0, ZERO, ZERO, 0.0, Passed(ZERO, ZERO, LatencyMark()))
        self._persistence.reset()

    @property
    def part(self) -> float:
        """The present limits as a part of those of a poor receiver."""
        part = self._learned.part
        return WITHOUT_CLIMB * part if self._level else part

    def judge(self, step: Step) -> Finding:
        """See Check."""
        residual, velocity, expected = step.residual, step.velocity, step.expected
        if self.later_s is not None and step.stamp_ns - self._later_ns > LATER_NS:
            self.later_s = None
        if residual is None or velocity is None or step.before is None or expected is None:
            self.begin()
            return Finding()
        if step.blind_s > MAX_GAP_S:
            self.begin()
            return Finding()
        self._level = step.level or math.isnan(residual[2])
        if self._level:  # no height and climb to compare
            residual = (residual[0], residual[1], 0.0)
            velocity = (velocity[0], velocity[1], 0.0)
            expected = (expected[0], expected[1], 0.0)
        before = self._mark
        self._mark = _Mark(
            step.stamp_ns,
            plus(before.difference, _clipped(residual, step.dt_s)),
            velocity,
            before.path_m + math.hypot(velocity[0], velocity[1]) * step.dt_s,
            Passed(expected, velocity, self._latency.now),
        )
        found = [self._over(horizon_s) for horizon_s in HORIZONS_S]
        level, text = max((one.level, one.text) for one in found)
        margin = level / self.part
        if margin >= 1.0:
            self.later_s = None
        elif max(one.without for one in found) >= self.part:
            later_s = max(self.later_s or 0.0, self._latency.now.seen_s)
            if later_s >= LEAST_S:
                self._later_ns, self.later_s = step.stamp_ns, later_s
        moving = math.hypot(*velocity) >= MOVING and margin < 1.0
        self._learned.add(step.stamp_ns, level, moving=moving)
        state = self._persistence.state(step.stamp_ns, margin >= 1.0)
        text = f"{text}, limits {100 * self.part:.0f} %, margin {margin:.2f}"
        return Finding(margin, state, text)

    def _over(self, horizon_s: float) -> _Difference:
        """Larger of the two differences over a horizon, each in units of its full limit."""
        p, mark, window = self._limits, self._mark, self._windows[horizon_s]
        window.append(mark)
        while mark.stamp_ns - window[0].stamp_ns > horizon_s * NANOSECONDS:
            window.popleft()
        first = window[0]
        d = without_lag(
            minus(mark.difference, first.difference), minus(mark.velocity, first.velocity)
        )
        path = p.path_fraction * (mark.path_m - first.path_m)
        limit = p.base_m + p.rate_m_s * horizon_s + path
        limit_up = p.vertical_base_m + p.vertical_rate_m_s * horizon_s + path
        across, up = math.hypot(d[0], d[1]), abs(d[2])
        without = max(across / limit, up / limit_up)
        if without >= WORTH_EXPLAINING * self.part and len(window) > 1:
            steps = [one.passed for one in itertools.islice(window, 1, None)]
            left = unexplained(d, first.passed.latency, steps)
            across, up = min(across, left[0]), min(up, left[1])
        level, level_up = across / limit, up / limit_up
        seconds = (mark.stamp_ns - first.stamp_ns) / NANOSECONDS
        if level_up > level:
            text = f"height off reported velocity by {up:.1f} m in {seconds:.0f} s"
            return _Difference(level_up, without, text)
        text = f"position off reported velocity by {across:.1f} m in {seconds:.0f} s"
        return _Difference(level, without, text)


def _clipped(residual: Vector3, dt_s: float) -> Vector3:
    """A residual no larger than a drift makes it."""
    across = math.hypot(residual[0], residual[1])
    part = min(1.0, MAX_RATE[0] * dt_s / across) if across else 1.0
    most = MAX_RATE[1] * dt_s
    return (part * residual[0], part * residual[1], max(-most, min(most, residual[2])))
