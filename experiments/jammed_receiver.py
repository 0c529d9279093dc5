# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Model of a receiver that is jammed, or carried off afterwards."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from experiments.carried_off import drift
from hijack_detect.estimation.geodesy import TangentPlane, moved
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    GpsSample,
    Sample,
    SatelliteSample,
    Vector3,
    VelocitySample,
)

SPEED = 4.0
"""m/s that a carry-off builds up to. Chosen, not swept."""
REACH_M = 60.0
"""Separation at which a carry-off ends. Chosen, not swept."""
FEW_WITHOUT_FIX, FEW = 3, 5
"""Satellites at most: a fix needs four."""
POORER = 4.0
"""Factor of the claimed accuracy. Chosen, not swept."""
VELOCITY_NOISE, VELOCITY_TIME_S = 0.5, 1.0
"""Errors of a jammed receiver's velocity on each axis, m/s, and their time: Gauss-Markov."""
POSITION_TIME_S = 17.0
"""The position is off by the sum of these, and returns within this time, as that of a receiver that
smoothes its positions by its velocities: by 2 m (VELOCITY_NOISE · T · √(Tv / (T + Tv)))."""

Change = Callable[[Sample], Sample | None]
"""Change of a sample; None drops it."""


def untouched(sample: Sample) -> Sample:
    """A receiver without jamming."""
    return sample


def lost(sample: Sample) -> Sample | None:
    """A receiver without a fix: no position, no velocity, too few satellites."""
    if isinstance(sample, VelocitySample):
        return None
    if isinstance(sample, SatelliteSample):
        return replace(sample, count=min(sample.count, FEW_WITHOUT_FIX))
    return replace(sample, has_fix=False) if isinstance(sample, FixSample) else sample


def poor(sample: Sample) -> Sample:
    """A receiver that reports that it is poor; it claims an accuracy only where it did before."""
    if isinstance(sample, SatelliteSample):
        return replace(sample, count=min(sample.count, FEW))
    if not isinstance(sample, FixSample):
        return sample
    return replace(
        sample,
        accuracy_m=_times(sample.accuracy_m),
        vertical_accuracy_m=_times(sample.vertical_accuracy_m),
    )


def _times(accuracy_m: float | None) -> float | None:
    return None if accuracy_m is None else POORER * accuracy_m


class Degraded:
    """A receiver that is poor and reports it. Its errors build up and fade, within their times."""

    def __init__(self, seed: int, until_ns: int) -> None:
        """Begin without errors.

        Args:
            seed: Of their drawing.
            until_ns: From this stamp on they fade; the receiver goes on reporting that it is poor.
        """
        self._rng, self._until_ns = np.random.default_rng(seed), until_ns
        self._velocity, self._position = np.zeros(3), np.zeros(3)
        self._stamp_ns: int | None = None

    def __call__(self, sample: Sample) -> Sample:
        """What it reports."""
        if isinstance(sample, VelocitySample):
            self._wander(sample.stamp_ns)
            east, north, up = np.add(sample.velocity, self._velocity).tolist()
            return replace(sample, velocity=(east, north, up))
        if isinstance(sample, FixSample) and sample.has_fix:
            self._wander(sample.stamp_ns)
            east, north, up = self._position.tolist()
            sample = displaced(sample, (east, north, up))
        return poor(sample)

    def _wander(self, stamp_ns: int) -> None:
        """Move the errors on to a stamp."""
        before_ns, self._stamp_ns = self._stamp_ns, stamp_ns
        if before_ns is None or stamp_ns <= before_ns:
            return
        dt = (stamp_ns - before_ns) / NANOSECONDS
        kept = math.exp(-dt / VELOCITY_TIME_S)
        before = self._velocity
        self._velocity = kept * before
        if stamp_ns < self._until_ns:
            driven = VELOCITY_NOISE * math.sqrt(1.0 - kept**2)
            self._velocity = self._velocity + driven * self._rng.standard_normal(3)
        self._position = math.exp(-dt / POSITION_TIME_S) * self._position
        self._position = self._position + 0.5 * dt * (before + self._velocity)


def displaced(fix: FixSample, by: Vector3) -> FixSample:
    """A fix that is off by a vector, ENU, m."""
    return moved(fix, TangentPlane(fix).geodetic((by[0], by[1], 0.0)), fix.altitude_m + by[2])


@dataclass(frozen=True)
class CarryOff:
    """A drift that builds up to SPEED, from a fix on.

    Attributes:
        stamp_ns: Stamp of that fix.
        acceleration: m/s²; 0 without a carry-off.
        bearing_deg: Direction, clockwise from North.
        displaced_m: What the first fix is off by at once, in the same direction.
    """

    stamp_ns: int
    acceleration: float
    bearing_deg: float
    displaced_m: float = 0.0

    @property
    def reach_s(self) -> float:
        """Time until the separation is REACH_M; the time at SPEED without a carry-off."""
        if not self.acceleration:
            return REACH_M / SPEED
        rising_s = SPEED / self.acceleration
        left_m = REACH_M - self.displaced_m - 0.5 * SPEED * rising_s
        return rising_s + left_m / SPEED


class Carried:
    """What the receiver reports during a carry-off, and how far off that is."""

    def __init__(
        self, one: CarryOff, start_ns: int, before: Iterable[GpsSample], claims: Change = untouched
    ) -> None:
        """Begin.

        Args:
            one: The carry-off.
            start_ns: Start of the flight.
            before: True samples of the receiver before it.
            claims: What the receiver makes of what it then reports.
        """
        self._claims, self.separation_m = claims, 0.0
        onset_s = (one.stamp_ns - start_ns) / NANOSECONDS
        self._spoofer = None
        if one.acceleration:
            scenario = drift(one.acceleration, SPEED, one.bearing_deg, onset_s)
            self._spoofer = Spoofer(scenario, start_ns)
        bearing = math.radians(one.bearing_deg)
        east, north = math.sin(bearing), math.cos(bearing)
        self._by = (one.displaced_m * east, one.displaced_m * north, 0.0)
        for sample in before:
            self._drifted(sample)

    def __call__(self, sample: Sample) -> Sample | None:
        """What becomes of a sample."""
        changed = self._drifted(sample)
        if isinstance(changed, FixSample) and changed.has_fix:
            offset = 0.0 if self._spoofer is None else self._spoofer.offset_m
            self.separation_m = offset + math.hypot(*self._by)
            if any(self._by):
                changed = displaced(changed, self._by)
        return self._claims(changed)

    def _drifted(self, sample: Sample) -> Sample:
        return sample if self._spoofer is None else self._spoofer.report(sample)
