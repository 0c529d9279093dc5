# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""GPS height and vertical velocity against the barometer."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from hijack_detect.detectors.altitude_parameters import AltitudeParameters
from hijack_detect.detectors.height_error import HeightError
from hijack_detect.estimation.barometer import pressure_height
from hijack_detect.estimation.ekf import GRAVITY
from hijack_detect.streams.samples import NANOSECONDS, FixSample, PressureSample, VelocitySample

HORIZONS_S = (1.0, 2.0, 5.0, 10.0, 20.0, 60.0)
"""Times over which changes are compared. Chosen, not swept."""
RATE_HORIZONS = 4
"""The vertical velocity is summed over the first horizons; its own bias shows in the last."""
SPEED_ALLOWANCE_M = 3.0
"""Most that `speed_error` allows: a spoofed speed must not excuse more. Chosen, not swept."""
FREEZE_MARGIN = 0.5
"""From this margin on, of either check, the reference stays where it is. Chosen, not swept."""
REFERENCE_S = 60.0
"""Time constant of the reference, within its largest rate. Chosen, not swept."""
KEPT_NS = 3 * NANOSECONDS
"""Pressures older than this have no fix left to belong to."""
MAX_GAP_S = 2.0
"""After a longer gap in fixes or pressures everything is compared from then on: a receiver that
comes back settles again."""
LONGEST_OUTAGE_NS = 120 * NANOSECONDS
"""The reference from before an outage of the receiver alone is worth something for as long: on real
flights outages take up to 70 s, and a barometer moves by a metre or two meanwhile."""
LAG_NS = 2 * NANOSECONDS
"""A sluggish receiver's height is behind by as long: filters of old single-frequency receivers."""
LEVEL_M = 1.0
"""A barometer's noise moves by less within LAG_NS in level flight. Chosen, not swept."""
SETTLE_S = 60.0
"""A receiver that moved on the ground is judged this long after: the longest horizon."""


@dataclass(frozen=True, slots=True)
class Finding:
    """The finding of one comparison.

    `margin` is 1 at the limit. `text` names the test that decides, with figures.
    """

    margin: float
    text: str


@dataclass(frozen=True, slots=True)
class _Point:
    """Height difference, height by velocity less barometer, barometer, dynamic head (m).

    `climbed` is by how much the barometer moved within LAG_S before: a receiver whose filter lags
    may be off by it.
    """

    t_ns: int
    difference: float
    summed: float
    baro: float
    head: float
    climbed: float


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

    `HeightError` gives what is normal over a horizon, from what receiver and barometer of this
    flight are worth. More is normal where the vehicle climbed or changed its speed.
    The reference of the total is the mean of the last seconds before the flight. It follows slowly,
    at most `reference_rate`, and not at all while anything is suspicious.

    A receiver that comes back in flight while the barometer went on is held to the reference from
    before its outage until there is a new one, within what the worst receiver may be off: on real
    flights it is off by up to 5 m then (60 outages).

    On the ground nothing is judged. A receiver that has moved by more than a poor one does in
    flight has not settled, and is judged SETTLE_S later.
    """

    def __init__(self, parameters: AltitudeParameters) -> None:
        """Start without a reference."""
        self._p = p = parameters
        self._pressures: deque[tuple[int, float]] = deque()
        self._lag_ns = round(p.gps_lag_s * NANOSECONDS)
        self._error = HeightError(p)
        self._settled_ns: int | None = None
        self._broken_ns = 0
        """Stamp of the last pressure after a gap."""
        self._summed = 0.0
        self._interval_s = 0.0
        self.difference: float | None = None
        """GPS height less barometer less reference, metres."""
        self.why = ""
        """Why the last fix could not be judged."""
        self.restart()

    def restart(self) -> None:
        """Forget reference and past, as after a gap; what the receiver is worth is kept."""
        self._past = [_Past(horizon) for horizon in HORIZONS_S]
        self._recent: deque[_Point] = deque()
        self._reference: tuple[float, float, float] | None = None
        self._held: tuple[float, float, float] | None = None
        """The reference from before an outage of the receiver alone."""
        self._last: _Point | None = None

    @property
    def settles(self) -> bool:
        """Whether nothing is judged since the receiver moved on the ground."""
        return self._settled_ns is not None

    @property
    def part(self) -> float:
        """The present limits over the horizons as a part of those of a poor pair."""
        return self._error.part

    @property
    def sigma(self) -> float:
        """Deviation of the wander of the height that is allowed now, metres."""
        return self._error.sigma

    def smallest(self, horizon_s: float) -> float:
        """Smallest change of the height, in level flight, that is seen over a horizon, metres."""
        return self.part * self._error.poor(horizon_s)

    def pressure(self, sample: PressureSample) -> None:
        """Take a pressure."""
        last_ns = self._pressures[-1][0] if self._pressures else None
        if last_ns is None or sample.stamp_ns - last_ns > MAX_GAP_S * NANOSECONDS:
            self._broken_ns = sample.stamp_ns
        self._pressures.append((sample.stamp_ns, pressure_height(sample.pressure_pa)))
        while self._pressures[0][0] < sample.stamp_ns - KEPT_NS:
            self._pressures.popleft()

    def fix(
        self, fix: FixSample, velocity: VelocitySample | None, *, airborne: bool, frozen: bool
    ) -> Finding | None:
        """Compare a fix; None while there is no reference or no pressure at its time.

        Args:
            fix: A fix with a height.
            velocity: The velocity of the same time, if there is one.
            airborne: Whether the vehicle flies; otherwise the reference is learnt.
            frozen: Whether the reference must not follow, for a reason of the caller's.
        """
        self.difference = None
        at_ns = fix.stamp_ns - self._lag_ns
        baro = self._baro(at_ns)
        if baro is None:
            self.why = f"less than {self._p.learn_s:g} s of GPS height and pressure"
            return None
        last = self._last
        if last is not None and fix.stamp_ns - last.t_ns > MAX_GAP_S * NANOSECONDS:
            held = self._held if self._reference is None else self._reference
            self.restart()
            if self._broken_ns <= last.t_ns and fix.stamp_ns - last.t_ns <= LONGEST_OUTAGE_NS:
                self._held = held
        self._error.claim(fix)
        point = self._point(fix, velocity, baro, at_ns)
        pasts = [past.add(point) for past in self._past]
        if self._waits(point, pasts, airborne):
            self._learn(point)
            return None
        if self._last is None:
            self._last = point
            pasts = [past.add(point) for past in self._past]
        if self._reference is None:
            self._learn(point)
            if self._reference is None:
                self.why = f"less than {self._p.learn_s:g} s of GPS height and pressure"
                return self._came_back(point)
            self._held = None
        with_velocity = velocity is not None and velocity.has_vertical
        finding = self._judge(point, pasts, with_velocity)
        if finding.margin < FREEZE_MARGIN and not frozen:
            self._follow(point)
        return finding

    def _came_back(self, point: _Point) -> Finding | None:
        """What contradicts the reference from before an outage, if anything does."""
        if self._held is None:
            return None
        at, baro, head = self._held
        off = point.difference - at
        limit = self._p.baro_total_m * self._p.baro_ceiling
        limit += self._allowance(point.baro - baro, point.head - head)
        if abs(off) <= limit:
            return None
        text = f"The GPS height came back {off:+.1f} m off the barometer (limit {limit:.1f})"
        return Finding(abs(off) / limit, text)

    def _waits(self, point: _Point, pasts: list[_Point | None], airborne: bool) -> bool:
        """Whether the vehicle stands, or the receiver has not settled since."""
        stamp_ns = point.t_ns
        if not airborne:
            self.why = "not in flight"
            self._reference = self._held = None
            if self._level(point, pasts) > 1.0:
                self._settled_ns = stamp_ns + round(SETTLE_S * NANOSECONDS)
            return True
        if self._settled_ns is None:
            return False
        left_s = (self._settled_ns - stamp_ns) / NANOSECONDS
        if left_s > 0.0:
            self.why = f"the receiver had not settled before the flight, {left_s:.0f} s more"
            return True
        self._settled_ns = None
        recent = self._recent
        self.restart()
        self._recent = recent
        return False

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

    def _point(
        self, fix: FixSample, velocity: VelocitySample | None, baro: float, at_ns: int
    ) -> _Point:
        last, head = self._last, 0.0
        if velocity is not None:
            head = math.hypot(*velocity.velocity[:2]) ** 2 / (2.0 * GRAVITY)
        if last is not None:
            self._interval_s = dt = (fix.stamp_ns - last.t_ns) / NANOSECONDS
            if velocity is not None and velocity.has_vertical:
                self._summed += velocity.velocity[2] * dt - (baro - last.baro)
        near = [h for t, h in self._pressures if at_ns - LAG_NS <= t <= at_ns]
        climbed = max(near, default=baro) - min(near, default=baro)
        difference = fix.altitude_m - baro
        point = _Point(fix.stamp_ns, difference, self._summed, baro, head, climbed)
        self._last = point
        return point

    def _learn(self, point: _Point) -> None:
        """Keep the last seconds; their mean is the reference once they are enough."""
        kept = self._recent
        if not kept or kept[-1].t_ns != point.t_ns:
            kept.append(point)
        learn_ns = self._p.learn_s * NANOSECONDS
        while point.t_ns - kept[0].t_ns > learn_ns + NANOSECONDS:
            kept.popleft()
        if point.t_ns - kept[0].t_ns >= learn_ns:
            n = len(kept)
            self._reference = (
                math.fsum(one.difference for one in kept) / n,
                math.fsum(one.baro for one in kept) / n,
                math.fsum(one.head for one in kept) / n,
            )

    def _follow(self, point: _Point) -> None:
        assert self._reference is not None
        at, baro, head = self._reference
        step = (point.difference - at) / REFERENCE_S
        limit = self._p.reference_rate
        at += max(-limit, min(limit, step)) * self._interval_s
        self._reference = (at, baro, head)

    def _allowance(self, climbed_m: float, head_m: float) -> float:
        speed = min(self._p.speed_error * abs(head_m), SPEED_ALLOWANCE_M)
        return self._p.height_scale * abs(climbed_m) + speed

    def _allowed(self, point: _Point, past: _Point) -> float:
        """What climb, speed and lag of the receiver explain of a change, metres."""
        climbed_m = max(point.climbed, past.climbed) - LEVEL_M
        lag = self._p.lag_share * max(0.0, climbed_m)
        return lag + self._allowance(point.baro - past.baro, point.head - past.head)

    def _level(self, point: _Point, pasts: list[_Point | None]) -> float:
        """Largest change over any horizon, in limits of a poor pair."""
        level = 0.0
        for horizon, past in zip(HORIZONS_S, pasts, strict=True):
            if past is not None:
                full = self._error.poor(horizon) + self._allowed(point, past)
                level = max(level, abs(point.difference - past.difference) / full)
        return level

    def _judge(self, point: _Point, pasts: list[_Point | None], with_velocity: bool) -> Finding:
        assert self._reference is not None
        at, baro, head = self._reference
        self.difference = total = point.difference - at
        limit = self._error.total()
        limit += self._allowance(point.baro - baro, point.head - head)
        best = Finding(
            abs(total) / limit,
            f"The GPS height is {total:+.1f} m off the barometer (limit {limit:.1f})",
        )
        levels = [0.0]
        for index, (horizon, past) in enumerate(zip(HORIZONS_S, pasts, strict=True)):
            if past is None:
                continue
            full, allowed = self._error.poor(horizon), self._allowed(point, past)
            limit = self.part * full + allowed
            change = point.difference - past.difference
            levels.append(change / (full + allowed))
            if abs(change) / limit > best.margin:
                text = f"The GPS height moved by {change:+.1f} m against the barometer"
                best = Finding(abs(change) / limit, f"{text} in {horizon:g} s (limit {limit:.1f})")
            if not with_velocity or index >= RATE_HORIZONS:
                continue
            change = point.summed - past.summed
            levels.append(change / (full + allowed))
            if abs(change) / limit > best.margin:
                text = f"The GPS climb rate is {change / horizon:+.2f} m/s off the barometer"
                best = Finding(
                    abs(change) / limit, f"{text} in {horizon:g} s (limit {limit / horizon:.2f})"
                )
        self._error.learn(point.t_ns, max(levels), -min(levels), moving=best.margin < 1.0)
        return best
