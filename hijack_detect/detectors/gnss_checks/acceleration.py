# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A change of velocity that no drone flies."""

from __future__ import annotations

from collections import deque

from hijack_detect.detectors.gnss_checks.mean_velocity import MeanVelocity
from hijack_detect.detectors.gnss_checks.step import Finding, Step, known, length, minus
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS, Vector3

WINDOW_NS = NANOSECONDS
SUSPICIOUS_PART = 0.8


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
        while step.stamp_ns - self._velocities[0][0] > WINDOW_NS and len(self._velocities) > 2:
            self._velocities.popleft()
        start_ns, first = self._velocities[0]
        dt = max((step.stamp_ns - start_ns) / NANOSECONDS, 1.0)
        size = length(known(minus(velocity, first))) / dt
        margin = size / self._limit
        state = State.SUSPICIOUS if margin >= SUSPICIOUS_PART else State.NORMAL
        text = f"acceleration {size:.1f} m/s² over 1 s (limit {self._limit:g})"
        return Finding(margin, State.ALARM if margin >= 1.0 else state, text)
