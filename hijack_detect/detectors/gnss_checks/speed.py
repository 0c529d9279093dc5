# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A speed that no drone flies."""

from __future__ import annotations

from hijack_detect.detectors.gnss_checks.mean_velocity import MeanVelocity
from hijack_detect.detectors.gnss_checks.step import Finding, Step, known, length
from hijack_detect.detectors.verdict import State

SUSPICIOUS_PART = 0.8


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
