# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Mean velocity over the last second, or over a longer gap, from fixes."""

from __future__ import annotations

from collections import deque

from hijack_detect.detectors.gnss_checks.step import ZERO, Step, known, minus, plus
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
