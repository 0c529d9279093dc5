# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A step of position beside the reported velocity that is not taken back."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

from hijack_detect.detectors.gnss_checks.latency import (
    LatencyMark,
    LatencySeen,
    without_lag,
    without_latency,
)
from hijack_detect.detectors.gnss_checks.step import WINDOW_NS, ZERO, Finding, Step, minus, plus
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS, Vector3

LONG_S = 6.0
"""A step just beyond the limit must last for this long: reflections end within some seconds.
Chosen, not swept."""
SHORT_S, LARGE = 1.0, 1.4
"""Only for the first where it is the second times the limit or more. Chosen, not swept."""
CLAIMED = 1.5
"""The limit is at least this many times what the receiver claims for a standard deviation. Clean
flights of receivers that claim 3.3 m or more, where it counts: 0.7."""
MOST_CLAIMED_M = 5.0
"""A claim beyond this does not count: what claims it may be the attacker.
Chosen, not swept."""
SHOWN = 2.5
"""The limit is at least this many times the largest step of this receiver's past.
Chosen, not swept."""
MOST = 2.0
"""Nor is it ever above this many times its lowest, whatever is claimed or was shown.
Chosen, not swept."""
FORGET_PER_S = 1.0 / 300.0
"""What was shown is forgotten at this relative rate, s⁻¹. Chosen, not swept."""
SETTLED_NS = 10 * NANOSECONDS
"""Only this long after a gap: a receiver that has lost its fix comes back with another error.
Chosen, not swept."""
PENDING = 0.9
"""Largest margin of a step that has not lasted. Chosen, not swept."""


@dataclass(frozen=True, slots=True)
class _Place:
    stamp_ns: int
    off: Vector3
    """Position off the integral of the velocity, m."""
    velocity: Vector3
    latency: LatencyMark


@dataclass(frozen=True, slots=True)
class _Jumped:
    """A step that has not been taken back yet."""

    stamp_ns: int
    before: _Place
    """Where it began."""
    latency: Vector3
    """Change of position that intervals explain within WINDOW_NS, m: a backlog may drain beside the
    step. What might be lag or slack is not taken off: it would make steps of a limit smaller."""
    direction: Vector3
    limit_m: float


class LastingStep:
    """Judges horizontal steps of a receiver that reports velocities.

    A step beyond a limit that follows what this receiver claims and has shown is an ALARM once it
    has lasted: SHORT_S if it is large, LONG_S otherwise. What a change of latency, or a lag of the
    position to a changing velocity, explains of it is taken off. Nothing that a receiver does
    before it has settled, or before a take-off, raises its limit.
    """

    def __init__(self, lowest_m: float, manoeuvre_m_s2: float, latency: LatencySeen) -> None:
        """Start without steps.

        Args:
            lowest_m: The limit of a good receiver, m.
            manoeuvre_m_s2: Acceleration the vehicle may have between two samples, m/s².
            latency: Is given every step before this is.
        """
        self._lowest_m = lowest_m
        self._manoeuvre = manoeuvre_m_s2
        self._latency = latency
        self._shown_m = 0.0
        self._sizes: deque[tuple[int, float]] = deque()
        """Not counted as shown yet."""
        self._since_ns: int | None = None
        self.begin()

    def begin(self) -> None:
        """Wait for no step, and count none of the past as one."""
        self._off: Vector3 = ZERO
        self._places: deque[_Place] = deque()
        self._jumped: _Jumped | None = None
        self._sizes.clear()

    def take_off(self) -> None:
        """Forget what the receiver has shown on the ground."""
        self._shown_m = 0.0
        self.begin()

    def judge(self, step: Step) -> Finding:
        """See Check."""
        residual, velocity = step.residual, step.velocity
        blind_ns = step.blind_s * NANOSECONDS
        if residual is None or velocity is None or not step.from_velocity or blind_ns >= WINDOW_NS:
            self.begin()
            self._since_ns = None
            return Finding()
        if self._since_ns is None:
            self._since_ns = step.previous.stamp_ns
        self._shown_m *= 1.0 - FORGET_PER_S * min(1.0, step.dt_s)
        if not self._places:
            before = velocity if step.before is None else step.before
            start = _Place(step.previous.stamp_ns, ZERO, before, self._latency.before)
            self._places.append(start)
        self._off = plus(self._off, (residual[0], residual[1], 0.0))
        here = _Place(step.stamp_ns, self._off, velocity, self._latency.now)
        self._places.append(here)
        while here.stamp_ns - self._places[0].stamp_ns >= WINDOW_NS:
            self._places.popleft()
        first = self._places[0]
        off, change = minus(here.off, first.off), minus(velocity, first.velocity)
        aside = without_lag(off, (change[0], change[1], 0.0))
        seconds = (here.stamp_ns - first.stamp_ns) / NANOSECONDS
        change_s = self._latency.change_s(first.latency, seconds)
        moved = without_latency(aside, first.velocity, velocity, *change_s)
        size, limit = math.hypot(moved[0], moved[1]), self._limit(step)
        settled = step.stamp_ns - self._since_ns > SETTLED_NS
        if not settled:
            return Finding()
        if self._jumped is None and size > limit:
            direction = (moved[0] / size, moved[1] / size, 0.0)
            self._jumped = _Jumped(step.stamp_ns, first, ZERO, direction, limit)
        if self._jumped is None:
            self._learn(here.stamp_ns, size)
            return Finding(PENDING * min(1.0, size / limit))
        if here.stamp_ns - self._jumped.stamp_ns <= WINDOW_NS:
            start = self._jumped.before
            away = minus(here.off, start.off)
            measured_s = self._latency.measured_s(start.latency)
            left = without_latency(away, start.velocity, velocity, *measured_s)
            self._jumped = replace(self._jumped, latency=minus(away, left))
        return self._wait(self._jumped, here)

    def _learn(self, stamp_ns: int, size: float) -> None:
        """Count a size as shown once it is no beginning of a larger step."""
        self._sizes.append((stamp_ns, size))
        while stamp_ns - self._sizes[0][0] > 2 * WINDOW_NS:
            self._show(self._sizes.popleft()[1])

    def _show(self, size: float) -> None:
        """Count a size as shown, up to the one that raises the limit to its maximum."""
        self._shown_m = max(self._shown_m, min(size, MOST * self._lowest_m / SHOWN))

    def _limit(self, step: Step) -> float:
        wanted = max(CLAIMED * min(step.claimed_m, MOST_CLAIMED_M), SHOWN * self._shown_m)
        limit = max(self._lowest_m, min(wanted, MOST * self._lowest_m))
        return limit + step.hidden_m(self._manoeuvre, by_velocity=True)

    def _wait(self, jumped: _Jumped, here: _Place) -> Finding:
        """The finding while a step is being waited for."""
        away = minus(minus(here.off, jumped.before.off), jumped.latency)
        metres = away[0] * jumped.direction[0] + away[1] * jumped.direction[1]
        if metres <= jumped.limit_m:
            self._show(jumped.limit_m)
            self.begin()
            return Finding()
        lasted_s = (here.stamp_ns - jumped.stamp_ns) / NANOSECONDS
        needed_s = SHORT_S if metres >= LARGE * jumped.limit_m else LONG_S
        text = (
            f"position jumped by {metres:.1f} m and stays there for {lasted_s:.1f} s "
            f"(allowed {jumped.limit_m:.1f})"
        )
        if lasted_s < needed_s:
            return Finding(PENDING, State.SUSPICIOUS, text)
        self.begin()
        return Finding(metres / jumped.limit_m, State.ALARM, text)
