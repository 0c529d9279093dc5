# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The vertical specific force, summed to velocity."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from hijack_detect.estimation.ekf import GRAVITY
from hijack_detect.estimation.rotation import rotate, up_component
from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample

MAX_GAP_NS = NANOSECONDS // 4


@dataclass(frozen=True, slots=True)
class Sum:
    """Sums since the start of an unbroken piece of flight.

    `velocity`: of Up specific force less gravity, m/s. `manoeuvre`: of the amount by which the
    specific force differs from gravity, m/s. Sums of different pieces cannot be compared.
    """

    stamp_ns: int
    piece: int
    velocity: float
    manoeuvre: float


class VerticalForce:
    """Turns the specific force into ENU and sums its Up part, keeping the last seconds.

    A gap, an unknown attitude or too much tilt ends a piece.
    """

    def __init__(self, max_tilt_deg: float, kept_s: float) -> None:
        """Start without samples.

        Args:
            max_tilt_deg: Tilt that ends a piece, degrees.
            kept_s: How long sums are kept, seconds.
        """
        self._lowest_up = math.cos(math.radians(max_tilt_deg))
        self._kept_ns = round(kept_s * NANOSECONDS)
        self._sums: deque[Sum] = deque()
        self._piece = 0
        self._last_ns: int | None = None
        self.why = "no attitude"
        """Why there is no sum now, empty while there is."""

    def add(self, sample: AttitudeSample) -> None:
        """Take the next attitude."""
        last_ns, self._last_ns = self._last_ns, sample.stamp_ns
        self.why = self._refused(sample)
        if self.why:
            self._piece += 1
            return
        assert sample.orientation is not None
        before = self._sums[-1] if self._sums else None
        if before is None or last_ns is None or before.piece != self._piece:
            self._sums.append(Sum(sample.stamp_ns, self._piece, 0.0, 0.0))
            return
        dt_ns = sample.stamp_ns - last_ns
        if dt_ns > MAX_GAP_NS:
            self._piece += 1
            self._sums.append(Sum(sample.stamp_ns, self._piece, 0.0, 0.0))
            return
        dt = dt_ns / NANOSECONDS
        up = rotate(sample.orientation, sample.specific_force)[2] - GRAVITY
        manoeuvre = abs(math.hypot(*sample.specific_force) - GRAVITY)
        self._sums.append(
            Sum(
                sample.stamp_ns,
                self._piece,
                before.velocity + up * dt,
                before.manoeuvre + manoeuvre * dt,
            )
        )
        while self._sums[0].stamp_ns < sample.stamp_ns - self._kept_ns:
            self._sums.popleft()

    def _refused(self, sample: AttitudeSample) -> str:
        if sample.orientation is None:
            return "attitude unknown"
        if up_component(sample.orientation) < self._lowest_up:
            return "tilted too far"
        return ""

    def at(self, stamp_ns: int) -> Sum | None:
        """Sums at a stamp, interpolated, and older ones forgotten; None where unknown."""
        while len(self._sums) > 1 and self._sums[1].stamp_ns <= stamp_ns:
            self._sums.popleft()
        if len(self._sums) < 2 or self._sums[0].stamp_ns > stamp_ns:
            return None
        a, b = self._sums[0], self._sums[1]
        if a.piece != b.piece:
            return None
        share = (stamp_ns - a.stamp_ns) / (b.stamp_ns - a.stamp_ns)
        return Sum(
            stamp_ns,
            a.piece,
            a.velocity + share * (b.velocity - a.velocity),
            a.manoeuvre + share * (b.manoeuvre - a.manoeuvre),
        )
