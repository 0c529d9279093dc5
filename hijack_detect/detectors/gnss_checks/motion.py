# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Mean velocity over the last second, or over a longer gap, from fixes."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from hijack_detect.detectors.gnss_checks.lasting_step import LastingStep
from hijack_detect.detectors.gnss_checks.latency import LatencyMark, LatencySeen, without_latency
from hijack_detect.detectors.gnss_checks.step import (
    WINDOW_NS,
    ZERO,
    Finding,
    Step,
    known,
    length,
    minus,
    plus,
)
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS, Vector3


class MeanVelocity:
    """Displacement over at least 1 s divided by its time; the noise of fixes is then harmless.

    It is level where heights were not measured.
    """

    def __init__(self) -> None:
        """Start without fixes."""
        self._places: deque[tuple[int, Vector3]] = deque()
        self._place: Vector3 = ZERO

    def add(self, step: Step) -> Vector3 | None:
        """Mean velocity (ENU, m/s) up to the fix; None in the first second."""
        if not self._places:
            self._places.append((step.previous.stamp_ns, ZERO))
        self._place = plus(self._place, known(step.moved))
        self._places.append((step.stamp_ns, self._place))
        while step.stamp_ns - self._places[1][0] >= NANOSECONDS:
            self._places.popleft()
        start_ns, place = self._places[0]
        dt = (step.stamp_ns - start_ns) / NANOSECONDS
        return None if dt < 1.0 else plus(ZERO, minus(self._place, place), 1.0 / dt)


REPEATS, REPEAT_NS = 3, 5 * NANOSECONDS
"""This many jumps within this time are an alarm: a reflection comes and goes, it does not hop.
Chosen, not swept."""
APART_NS = NANOSECONDS // 10
"""Steps within this time are one jump. Chosen, not swept."""
GAP_S, GAP_TIMES = 0.5, 2.5
"""A gap is longer than this, and than this many times the step before. Chosen, not swept."""
STRIDE = 4.0 / 3.0
"""Limit over 1 s against the limit of one step: the noise of several fixes.
Chosen, not swept."""


@dataclass(frozen=True)
class JumpLimits:
    """Metres; see `GnssSanityParameters`."""

    suspicious_m: float
    alarm_m: float
    manoeuvre_m_s2: float
    accuracy_gain: float
    accuracy_cap_m: float


class JumpCheck:
    """Step of position against the step to expect, horizontally or in height.

    What one step may differ by grows with the time in which the vehicle was not seen: with
    velocities at both ends an acceleration a hides a dt²/4, from fixes alone a dt². After a gap the
    clock may have been set forward in it; a vehicle that falls short on its way has not jumped.
    Nor has one whose fixes become later, or less late again (`without_latency`). A smaller step is
    an alarm if it is not taken back (`LastingStep`).
    """

    def __init__(
        self,
        name: str,
        limits: JumpLimits,
        latency: LatencySeen,
        lasting: LastingStep | None = None,
        *,
        vertical: bool,
    ) -> None:
        """Start without steps; `latency` is given every step before this check is."""
        self.name = name
        self._latency = latency
        self._lasting = lasting
        self._limits = limits
        self._vertical = vertical
        self._steps: deque[tuple[Step, Vector3, LatencyMark]] = deque()
        """With its residual, and the latency before it."""
        self._sum: Vector3 = ZERO
        self._jumps: deque[int] = deque(maxlen=REPEATS)
        self._blind_s = math.inf

    def judge(self, step: Step) -> Finding:
        """See Check."""
        found = self._at_once(step)
        if self._lasting is None:
            return found
        lasting = self._lasting.judge(step)
        if found.state is State.ALARM:
            self._lasting.begin()
        return max(found, lasting, key=lambda one: one.claims)

    def _at_once(self, step: Step) -> Finding:
        """The findings of the newest step and of the last second."""
        before_s, self._blind_s = self._blind_s, step.blind_s
        gap = step.blind_s > max(GAP_S, GAP_TIMES * before_s)
        residual = step.off_path if gap else step.residual
        if residual is None or (self._vertical and math.isnan(residual[2])):
            self._forget()
            return Finding()
        residual = known(residual)
        p = self._limits
        by_velocity = step.from_velocity and not (self._vertical and step.level)
        size = self._size(residual)
        slack = step.hidden_m(p.manoeuvre_m_s2, by_velocity=by_velocity)
        base = max(p.suspicious_m, p.accuracy_gain * min(step.claimed_m, p.accuracy_cap_m))
        allowed = base + slack
        if by_velocity and step.blind_s * NANOSECONDS < WINDOW_NS:
            size = self._size(self._timed(residual, step, step, self._latency.before))
            whole = self._add(step, residual)
            if whole / (base * STRIDE + slack) > size / allowed:
                size, allowed = whole, base * STRIDE + slack
        else:
            self._forget()
        return self._finding(step.stamp_ns, size, allowed, p.alarm_m + slack)

    def _finding(self, stamp_ns: int, size: float, allowed: float, alarm: float) -> Finding:
        what = "height" if self._vertical else "position"
        if size <= allowed:
            return Finding(size / alarm, State.NORMAL, f"{what} steps by {size:.1f} m")
        if self._steps:
            self._forget()
        if not self._jumps or stamp_ns - self._jumps[-1] > APART_NS:
            self._jumps.append(stamp_ns)
        recent = sum(stamp_ns - jump <= REPEAT_NS for jump in self._jumps)
        margin = max(size / alarm, recent / REPEATS)
        text = f"{what} jumped by {size:.1f} m (allowed {allowed:.1f}, alarm {alarm:.1f})"
        if recent == REPEATS:
            text += f", {recent} times in {REPEAT_NS // NANOSECONDS} s"
        return Finding(margin, State.ALARM if margin >= 1.0 else State.SUSPICIOUS, text)

    def _size(self, residual: Vector3) -> float:
        return abs(residual[2]) if self._vertical else math.hypot(residual[0], residual[1])

    def _timed(self, moved: Vector3, first: Step, last: Step, start: LatencyMark) -> Vector3:
        """What latency does not explain, see `without_latency`; all of it in height."""
        if self._vertical or first.before is None or last.velocity is None:
            return moved
        seconds = (last.stamp_ns - first.previous.stamp_ns) / NANOSECONDS
        change_s = self._latency.change_s(start, seconds)
        return without_latency(moved, first.before, last.velocity, *change_s)

    def _add(self, step: Step, residual: Vector3) -> float:
        """Size of the sum of the residuals of the last second."""
        self._steps.append((step, residual, self._latency.before))
        self._sum = plus(self._sum, residual)
        while step.stamp_ns - self._steps[0][0].stamp_ns >= WINDOW_NS:
            self._sum = minus(self._sum, self._steps.popleft()[1])
        first, _, start = self._steps[0]
        return self._size(self._timed(self._sum, first, step, start))

    def _forget(self) -> None:
        self._steps.clear()
        self._sum = ZERO


SUSPICIOUS_PART = 0.8
"""Of the limit, SUSPICIOUS from there on. Chosen, not swept."""


class SpeedCheck:
    """Reported speed, and speed of the fixes over 1 s or over a gap, in three dimensions."""

    name = "speed"

    def __init__(self, limit: float) -> None:
        """Alarm above `limit` m/s."""
        self._limit = limit
        self._mean = MeanVelocity()

    def judge(self, step: Step) -> Finding:
        """See Check."""
        reported = 0.0 if step.velocity is None else length(known(step.velocity))
        mean = self._mean.add(step)
        flown = 0.0 if mean is None else length(mean)
        speed = max(reported, flown)
        margin = speed / self._limit
        state = State.SUSPICIOUS if margin >= SUSPICIOUS_PART else State.NORMAL
        source = "reported" if reported >= flown else "from fixes"
        text = f"speed {speed:.1f} m/s {source} (limit {self._limit:g})"
        return Finding(margin, State.ALARM if margin >= 1.0 else state, text)


MEAN_NS = NANOSECONDS
"""The 1 s of `max_acceleration_m_s2`, whose limit belongs to it."""


class AccelerationCheck:
    """Change of the reported velocity, or else of the fixes' mean velocity, over about 1 s.

    A change within less counts as one over a second: single outliers are for other checks.
    """

    name = "acceleration"

    def __init__(self, limit: float) -> None:
        """Alarm above `limit` m/s²."""
        self._limit = limit
        self._mean = MeanVelocity()
        self._velocities: deque[tuple[int, Vector3]] = deque()
        self._reported = False

    def judge(self, step: Step) -> Finding:
        """See Check."""
        mean = self._mean.add(step)
        velocity = mean if step.velocity is None else step.velocity
        if (step.velocity is not None) is not self._reported or velocity is None:
            self._velocities.clear()
            self._reported = step.velocity is not None
        if velocity is None:
            return Finding()
        self._velocities.append((step.stamp_ns, velocity))
        while step.stamp_ns - self._velocities[0][0] > MEAN_NS and len(self._velocities) > 2:
            self._velocities.popleft()
        start_ns, first = self._velocities[0]
        dt = max((step.stamp_ns - start_ns) / NANOSECONDS, 1.0)
        size = length(known(minus(velocity, first))) / dt
        margin = size / self._limit
        state = State.SUSPICIOUS if margin >= SUSPICIOUS_PART else State.NORMAL
        text = f"acceleration {size:.1f} m/s² over 1 s (limit {self._limit:g})"
        return Finding(margin, State.ALARM if margin >= 1.0 else state, text)
