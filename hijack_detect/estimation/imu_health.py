# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What an IMU is worth: its rate, bursts, clipping, vibration and scale."""

from __future__ import annotations

import itertools
import math
import statistics
from collections import deque
from collections.abc import Sequence

import numpy as np

from hijack_detect.estimation.ekf import GRAVITY
from hijack_detect.streams.samples import NANOSECONDS, ImuSample, Phase, Vector3

SHORT_NS = 2 * NANOSECONDS
"""Vibration and clipping are judged over this time. Chosen, not swept."""
LONG_S = 10.0
"""The mean specific force is judged over this time constant: no vehicle accelerates for longer."""
RATE_NS = 4 * NANOSECONDS
"""The rate is counted over this time. Chosen, not swept."""
HELD_NS = 10 * NANOSECONDS
"""A fault is kept for this long after its last evidence: a filter that used such samples needs as
long to recover. Chosen, not swept."""
SLOWEST_HZ = 15.0
"""Of slower samples the differences are those of manoeuvres. Chosen, not swept."""
BURSTY = 3.0
"""Samples come in bursts when the mean interval is this many times the median, but for one gap.
Chosen, not swept."""
PILE_UP, LEAST_REPEATS = 3, 3
"""Readings pile up at a limit: this many times as many as of the next value, and at least this
many. Chosen, not swept."""
BESIDE = 20
"""Steps of the sensor beside a limit whose readings show how often one value comes by chance. The
tail of a healthy sensor thins out, so that its last value comes less often than those."""
BY_CHANCE = 4.0
"""Standard deviations of a Poisson count, and `LEAST_REPEATS` above it: about 1e-5 by chance. With
less, an accelerometer that resolves 0.08 m/s² is taken to clip for half of a flight."""
SETTLE_NS = 5 * NANOSECONDS
"""The scale is not judged before this much was averaged. Chosen, not swept."""
SPREAD = 1.5
"""Standard deviations (at least of 0.5 m/s²) from the mean to a limit: the mode of a coarse but
healthy sensor is nearer. Chosen, not swept."""
LIGHT, HEAVY = 0.75, 2.2
"""Mean specific force in flight over gravity. No flight is lighter for 10 s, one with 60° of bank
has 2; an accelerometer that clips or aliases has 0.1 to 0.7 (measured)."""


class ImuHealth:
    """Follows the samples of one IMU.

    Attributes:
        rate_hz: Samples a second over the last seconds, Hz.
    """

    def __init__(self, clip_share: float, max_vibration: float, max_force_error: float) -> None:
        """Start without samples.

        Args:
            clip_share: Share of samples at the largest reading from which an axis clips.
            max_vibration: Largest usable vibration, m/s²/√Hz.
            max_force_error: Largest usable error of the specific force at rest, m/s².
        """
        self._clip_share, self._max_vibration = clip_share, max_vibration
        self._max_error = max_force_error
        self._stamps: deque[int] = deque()
        self._recent: deque[tuple[int, Vector3, float]] = deque()
        """Stamp, specific force, and square of its step from the one before."""
        self._steps = 0.0
        self._last: ImuSample | None = None
        self._mean: Vector3 = (0.0, 0.0, 0.0)
        self._since_ns: int | None = None
        self._faults: dict[str, tuple[int, str]] = {}
        """When each kind of fault was last found, and what it was."""
        self._judged_ns = 0
        self._scale = ""
        """Fault of the scale by the last rest."""

    @property
    def rate_hz(self) -> float:
        """Samples a second over the last seconds, Hz; 0 before two came."""
        if len(self._stamps) < 2:
            return 0.0
        return (len(self._stamps) - 1) * NANOSECONDS / (self._stamps[-1] - self._stamps[0])

    def add(self, sample: ImuSample) -> None:
        """Take the next sample."""
        stamp, force = sample.stamp_ns, sample.specific_force
        last, self._last = self._last, sample
        if last is None or stamp - last.stamp_ns > RATE_NS:
            self._stamps.clear()
            self._recent.clear()
            self._steps = 0.0
            self._mean, self._since_ns = force, stamp
            last = None
        self._stamps.append(stamp)
        while self._stamps[0] < stamp - RATE_NS:
            self._stamps.popleft()
        square = 0.0
        if last is not None:
            x, y, z = force
            before_x, before_y, before_z = last.specific_force
            dx, dy, dz = x - before_x, y - before_y, z - before_z
            square = math.fsum((dx * dx, dy * dy, dz * dz))
            share = min(1.0, (stamp - last.stamp_ns) / NANOSECONDS / LONG_S)
            mean_x, mean_y, mean_z = self._mean
            self._mean = (
                mean_x + share * (x - mean_x),
                mean_y + share * (y - mean_y),
                mean_z + share * (z - mean_z),
            )
        self._recent.append((stamp, force, square))
        while self._recent[0][0] < stamp - SHORT_NS:
            self._recent.popleft()
        if stamp - self._judged_ns >= NANOSECONDS // 4:
            self._judged_ns = stamp
            self._judge(stamp)

    @property
    def vibration(self) -> float:
        """Deviation of the difference of successive specific forces over √2, m/s²."""
        n = len(self._recent)
        return math.sqrt(math.fsum([one[2] for one in self._recent]) / n / 2.0) if n else 0.0

    def _judge(self, stamp_ns: int) -> None:
        vibration = self.vibration
        rate_hz = self.rate_hz
        if rate_hz >= SLOWEST_HZ and vibration > self._max_vibration * math.sqrt(rate_hz):
            self._faults["vibration"] = (stamp_ns, f"the IMU vibrates by {vibration:.0f} m/s²")
        clipped = self._clipped()
        if clipped:
            self._faults["clipping"] = (
                stamp_ns,
                f"the accelerometer clips at {clipped:.0f} m/s²",
            )
        if self._bursty():
            self._faults["bursts"] = (stamp_ns, "IMU samples come in bursts")

    def _bursty(self) -> bool:
        intervals: list[int] = np.sort(np.diff(np.array(self._stamps))).tolist()
        if len(intervals) < 2 * LEAST_REPEATS:
            return False
        return statistics.fmean(intervals[:-1]) > BURSTY * statistics.median(intervals)

    def _clipped(self) -> float:
        """Reading at which an axis clips, m/s²; 0 if none does."""
        n = len(self._recent)
        least = max(LEAST_REPEATS, self._clip_share * n)
        for axis in zip(*(force for _, force, _ in self._recent), strict=True):
            mean, variance = moments(axis)
            deviation = math.sqrt(variance)
            values: list[float] = sorted(axis)
            for ordered in (values, values[::-1]):
                limit = ordered[0]
                if abs(limit - mean) < SPREAD * max(deviation, 0.5):
                    continue
                repeats = sum(1 for _ in itertools.takewhile(lambda one: one == limit, ordered))  # noqa: B023
                if repeats < least or repeats == n:
                    continue
                rate = _usual_repeats(ordered, abs(limit - mean))
                if repeats < rate + BY_CHANCE * math.sqrt(rate) + LEAST_REPEATS:
                    continue
                if repeats >= PILE_UP * ordered.count(ordered[repeats]):
                    return abs(limit)
        return 0.0

    def fault(self, phase: Phase) -> str:
        """Why the IMU cannot be used now, with figures; empty if it can.

        Args:
            phase: The phase of the flight: a mean force is a measure of scale at rest, and within
                wide bounds in flight, and none in a hand.
        """
        last, since_ns = self._last, self._since_ns
        if last is None or since_ns is None:
            return ""
        stamp = last.stamp_ns
        for found_ns, text in self._faults.values():
            if stamp - found_ns <= HELD_NS:
                return text
        if stamp - since_ns < SETTLE_NS:
            return self._scale
        weight = math.hypot(*self._mean)
        if phase is Phase.STANDING:
            forces = [force for _, force, _ in self._recent]
            weight = math.hypot(*(statistics.fmean(axis) for axis in zip(*forces, strict=True)))
            off = abs(weight - GRAVITY) > self._max_error
            self._scale = f"at rest the specific force is {weight:.1f} m/s²" if off else ""
        elif phase.airborne and not LIGHT < weight / GRAVITY < HEAVY:
            return f"the mean specific force in flight is {weight:.1f} m/s²"
        return self._scale


def moments(values: Sequence[float]) -> tuple[float, float]:
    """Mean and variance of some values, from sums without rounding."""
    mean = math.fsum(values) / len(values)
    off = np.array(values) - mean
    return mean, math.fsum((off * off).tolist()) / len(values)


def _usual_repeats(ordered: list[float], reach: float) -> float:
    """Mean repeats of a value beside the first: a coarse sensor repeats every one.

    Args:
        ordered: Readings of one axis from the limit inwards; at least two differ.
        reach: The values within this distance of the limit count, m/s².
    """
    limit = ordered[0]
    step = min(abs(b - a) for a, b in itertools.pairwise(ordered) if a != b)
    steps = max(1.0, min(BESIDE, reach / step))
    beside = sum(1 for one in ordered if 0.0 < abs(one - limit) <= steps * step)
    return beside / steps
