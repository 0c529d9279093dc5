# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Whether the clock that stamps a stream runs at another rate than the receiver's."""

from __future__ import annotations

import math
import statistics
from collections import deque

from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.streams.samples import NANOSECONDS, FixSample, VelocitySample

WINDOW_S = 2.0
"""Positions and velocities are compared over this: long against their noise and lags.
Chosen, not swept; 3 s before."""
MAX_GAP_S = 1.0
"""A window with a longer gap between velocities is not used. Chosen, not swept."""
MOVING = 1.0
"""m/s: at less speed the noise of velocities decides the ratio. Chosen, not swept."""
LEAST_WINDOWS, MOST_WINDOWS = 10, 100
"""Windows before a rate is believed, and of the newest that count. Chosen, not swept; 20 before."""
LEAST_RATIO = 0.03
"""Ratios of 37 recorded and simulated flights with a good clock and a good receiver are within
0.99 and 1.01, of the two with one that runs at 12/13 (1.083) 1.06 and 1.09."""
LEAST_OFF = 0.025
"""Receivers measure once in 1/n s, to better than 1 % (those flights: 0.1 %, one 0.9 %)."""
AGREE = 0.05
"""The two ways to see the rate agree this well. Chosen, not swept."""
KEPT_FIXES = 200
JITTER = 0.25
"""Stamps jitter by less of an interval (10 to 20 ms of 0.2 s); what is further off is a gap.
Chosen, not swept."""


class ClockRateCheck:
    """Two witnesses, each weak and together conclusive, that need no receiver's time.

    The way between two fixes is true, that which the velocities give is stamped; and receivers
    measure in intervals of 1/n s. Give it fixes and velocities in order of stamp.

    Attributes:
        rate: True seconds in one of the clock's; None while nothing shows that it is not 1.
    """

    def __init__(self) -> None:
        """Start without samples."""
        self._start: FixSample | None = None
        self._last_ns: int | None = None
        self._velocity: VelocitySample | None = None
        self._way = (0.0, 0.0)
        self._gap_s = 0.0
        self._ratios: deque[float] = deque(maxlen=MOST_WINDOWS)
        self._intervals: deque[float] = deque(maxlen=KEPT_FIXES)
        self.rate: float | None = None

    def velocity(self, sample: VelocitySample) -> None:
        """Take a GPS velocity."""
        last, self._velocity = self._velocity, sample
        if last is None:
            return
        dt = (sample.stamp_ns - last.stamp_ns) / NANOSECONDS
        self._gap_s = max(self._gap_s, dt)
        (e0, n0, _), (e1, n1, _) = last.velocity, sample.velocity
        self._way = (self._way[0] + 0.5 * dt * (e0 + e1), self._way[1] + 0.5 * dt * (n0 + n1))

    def fix(self, fix: FixSample) -> None:
        """Take a fix."""
        if not fix.has_fix:
            self._start = self._last_ns = None
            return
        if self._last_ns is not None:
            self._intervals.append((fix.stamp_ns - self._last_ns) / NANOSECONDS)
        self._last_ns = fix.stamp_ns
        if self._start is not None:
            seconds = (fix.stamp_ns - self._start.stamp_ns) / NANOSECONDS
            if seconds < WINDOW_S:
                return
            self._compare(self._start, fix, seconds)
        self._start, self._way, self._gap_s = fix, (0.0, 0.0), 0.0

    def _compare(self, start: FixSample, end: FixSample, seconds: float) -> None:
        x, y = self._way
        way = math.hypot(x, y)
        if self._gap_s <= MAX_GAP_S and seconds < 2.0 * WINDOW_S and way > MOVING * seconds:
            east, north, _ = LocalFrame(start).enu(end)  # along the way: noise of positions is 0
            self._ratios.append((east * x + north * y) / way**2)
            self.rate = self._judge()

    def _judge(self) -> float | None:
        if len(self._ratios) < LEAST_WINDOWS or not self._intervals:
            return None
        ratio, usual = statistics.median(self._ratios), statistics.median_low(self._intervals)
        interval = statistics.fmean(
            one for one in self._intervals if abs(one - usual) <= JITTER * usual
        )
        if abs(ratio - 1.0) < LEAST_RATIO or abs(_nearest(interval) / interval - 1.0) < LEAST_OFF:
            return None
        rate = _nearest(ratio * interval) / interval
        return rate if abs(rate - ratio) < AGREE else None


def clock_words(rate: float) -> str:
    """A rate of the stamps' clock in words, as the part of a sentence."""
    way = "slow" if rate > 1.0 else "fast"
    return f"the clock of the stamps runs {100.0 * abs(1.0 / rate - 1.0):.1f} % {way}"


def _nearest(interval_s: float) -> float:
    """The 1/n s that is nearest to an interval, s."""
    return 1.0 / max(1, round(1.0 / interval_s)) if interval_s > 0.0 else math.inf
