# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""GPS height and vertical velocity against the barometer."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from hijack_detect.detectors.altitude_parameters import AltitudeParameters
from hijack_detect.detectors.learned_level import LearnedLevel
from hijack_detect.estimation.barometer import pressure_height
from hijack_detect.estimation.ekf import GRAVITY
from hijack_detect.streams.samples import NANOSECONDS, FixSample, PressureSample, VelocitySample

HORIZONS_S = (1.0, 2.0, 5.0, 10.0, 20.0, 60.0)
RATE_HORIZONS = 4
"""The vertical velocity is summed over the first horizons; its own bias shows in the last."""
SPEED_ALLOWANCE_M = 3.0
FREEZE_MARGIN = 0.5
"""From this margin on the reference stays where it is."""
REFERENCE_S = 60.0
"""Time constant of the reference, within its largest rate."""
KEPT_NS = 3 * NANOSECONDS
"""Pressures older than this have no fix left to belong to."""
MAX_GAP_S = 2.0
AIRBORNE_M, MOVING_HEAD_M = 2.0, 0.2
"""Higher than this over where it began, or faster than 2 m/s, a vehicle flies."""


@dataclass(frozen=True, slots=True)
class Finding:
    """What one comparison says.

    `margin` is 1 at the limit. `text` names the test that decides, with figures.
    """

    margin: float
    text: str


@dataclass(frozen=True, slots=True)
class _Point:
    """Height difference, height by velocity less barometer, barometer, dynamic head (m)."""

    t_ns: int
    difference: float
    summed: float
    baro: float
    head: float


class _Past:
    """The point a horizon ago, in O(1) a point."""

    def __init__(self, horizon_s: float) -> None:
        self._points: deque[_Point] = deque()
        self._horizon_ns = round(horizon_s * NANOSECONDS)

    def add(self, point: _Point) -> _Point | None:
        """The newest point that is a horizon older, None if there is none or after a gap."""
        self._points.append(point)
        while len(self._points) > 1 and self._points[1].t_ns <= point.t_ns - self._horizon_ns:
            self._points.popleft()
        first = self._points[0]
        older_ns = point.t_ns - first.t_ns - self._horizon_ns
        return first if 0 <= older_ns <= MAX_GAP_S * NANOSECONDS else None


class BarometerCheck:
    """Compares changes of GPS height with those of the barometer over 1 to 60 s, and in total.

    Over a horizon of t seconds `baro_step_m + baro_wander_m √t` is normal for a poor receiver and
    a barometer in the propellers' wash. In the air a good pair earns a part of that, see
    `LearnedLevel`. More is normal where the vehicle climbed or changed its speed. The reference of
    the total follows slowly, at most `reference_rate`, and not at all while anything is suspicious.
    """

    def __init__(self, parameters: AltitudeParameters) -> None:
        """Start without a reference."""
        self._p = parameters
        self._pressures: deque[tuple[int, float]] = deque()
        self._lag_ns = round(parameters.gps_lag_s * NANOSECONDS)
        self._learned = LearnedLevel(parameters.baro_floor, parameters.baro_gain)
        self._past = [_Past(horizon) for horizon in HORIZONS_S]
        self._learnt: list[_Point] = []
        self._reference: tuple[float, float, float] | None = None
        self._last: _Point | None = None
        self._summed = 0.0
        self._interval_s = 0.0
        self.difference: float | None = None
        """GPS height less barometer less reference, metres."""

    @property
    def part(self) -> float:
        """The present limits over the horizons as a part of those of a poor pair."""
        return self._learned.part

    def pressure(self, sample: PressureSample) -> None:
        """Take a pressure."""
        self._pressures.append((sample.stamp_ns, pressure_height(sample.pressure_pa)))
        while self._pressures[0][0] < sample.stamp_ns - KEPT_NS:
            self._pressures.popleft()

    def fix(self, fix: FixSample, velocity: VelocitySample | None, frozen: bool) -> Finding | None:
        """Compare a fix; None while there is no reference or no pressure at its time.

        Args:
            fix: A fix with a position.
            velocity: The velocity of the same time, if there is one.
            frozen: Whether the reference must not follow, for a reason of the caller's.
        """
        self.difference = None
        baro = self._baro(fix.stamp_ns - self._lag_ns)
        if baro is None:
            return None
        point = self._point(fix, velocity, baro)
        pasts = [past.add(point) for past in self._past]
        if self._reference is None:
            self._learn(point)
            return None
        finding = self._judge(point, pasts, velocity is not None)
        if finding.margin < FREEZE_MARGIN and not frozen:
            self._follow(point)
        return finding

    def _baro(self, at_ns: int) -> float | None:
        """Barometric height at a time, interpolated."""
        after = None
        for stamp, height in reversed(self._pressures):
            if stamp <= at_ns:
                if at_ns - stamp > NANOSECONDS:
                    return None
                if after is None:
                    return height
                share = (at_ns - stamp) / (after[0] - stamp)
                return height + share * (after[1] - height)
            after = (stamp, height)
        return None

    def _point(self, fix: FixSample, velocity: VelocitySample | None, baro: float) -> _Point:
        last, head = self._last, 0.0
        if velocity is not None:
            head = math.hypot(*velocity.velocity[:2]) ** 2 / (2.0 * GRAVITY)
        if last is not None:
            self._interval_s = dt = (fix.stamp_ns - last.t_ns) / NANOSECONDS
            if velocity is not None and dt <= MAX_GAP_S:
                self._summed += velocity.velocity[2] * dt - (baro - last.baro)
        point = _Point(fix.stamp_ns, fix.altitude_m - baro, self._summed, baro, head)
        self._last = point
        return point

    def _learn(self, point: _Point) -> None:
        self._learnt.append(point)
        if point.t_ns - self._learnt[0].t_ns >= self._p.learn_s * NANOSECONDS:
            n = len(self._learnt)
            self._reference = (
                math.fsum(one.difference for one in self._learnt) / n,
                math.fsum(one.baro for one in self._learnt) / n,
                math.fsum(one.head for one in self._learnt) / n,
            )
            self._learnt = []

    def _follow(self, point: _Point) -> None:
        assert self._reference is not None
        at, baro, head = self._reference
        step = (point.difference - at) / REFERENCE_S
        limit = self._p.reference_rate
        # Over an outage it would go beyond what it follows.
        at += max(-limit, min(limit, step)) * min(self._interval_s, MAX_GAP_S)
        self._reference = (at, baro, head)

    def _allowance(self, climbed_m: float, head_m: float) -> float:
        speed = min(self._p.speed_error * abs(head_m), SPEED_ALLOWANCE_M)
        return self._p.height_scale * abs(climbed_m) + speed

    def _judge(self, point: _Point, pasts: list[_Point | None], with_velocity: bool) -> Finding:
        p = self._p
        assert self._reference is not None
        at, baro, head = self._reference
        self.difference = total = point.difference - at
        limit = p.baro_total_m + self._allowance(point.baro - baro, point.head - head)
        best = Finding(
            abs(total) / limit,
            f"GPS height {total:+.1f} m off the barometer (limit {limit:.1f})",
        )
        level = 0.0
        for index, (horizon, past) in enumerate(zip(HORIZONS_S, pasts, strict=True)):
            if past is None:
                continue
            full = p.baro_step_m + p.baro_wander_m * math.sqrt(horizon)
            allowed = self._allowance(point.baro - past.baro, point.head - past.head)
            limit = self.part * full + allowed
            change = point.difference - past.difference
            level = max(level, abs(change) / (full + allowed))
            if abs(change) / limit > best.margin:
                text = f"GPS height {change:+.1f} m against the barometer in {horizon:g} s"
                best = Finding(abs(change) / limit, f"{text} (limit {limit:.1f})")
            if not with_velocity or index >= RATE_HORIZONS:
                continue
            change = point.summed - past.summed
            level = max(level, abs(change) / (full + allowed))
            if abs(change) / limit > best.margin:
                text = f"GPS climb rate {change / horizon:+.2f} m/s against the barometer"
                best = Finding(
                    abs(change) / limit, f"{text} in {horizon:g} s (limit {limit / horizon:.2f})"
                )
        flies = point.baro - baro > AIRBORNE_M or point.head > MOVING_HEAD_M
        self._learned.add(point.t_ns, level, moving=flies and best.margin < 1.0)
        return best
