# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Whether the nose follows the course in this phase of flight."""

from __future__ import annotations

import math
from collections import deque

from hijack_detect.detectors.window import FULL, WindowSums
from hijack_detect.streams.samples import NANOSECONDS


class FollowsCourse:
    """Course minus yaw in the time just before the detector's window.

    Comparing yaw with course presumes that the vehicle flies where its nose points. A pilot who
    flies sideways or backwards breaks that, and so does a multirotor that stops. The time before
    the window shows whether it holds, and how large the crab angle is.
    """

    def __init__(
        self, window_s: float, before_s: float, sigma_deg: float, offset_deg: float
    ) -> None:
        """Start without history.

        Args:
            window_s: Length of the detector's window, s.
            before_s: Length of the time before it, s.
            sigma_deg: The nose follows if the difference varies by no more than this (standard
                deviation), degrees.
            offset_deg: And if its mean is no larger than this, degrees.
        """
        self._reach_s, self._sigma_deg, self._offset_deg = (
            window_s + before_s,
            sigma_deg,
            offset_deg,
        )
        self._delay_ns = round(window_s * NANOSECONDS)
        self._needed_ns = round(FULL * before_s * NANOSECONDS)
        self._pending: deque[tuple[int, float]] = deque()
        self._before = WindowSums(round(before_s * NANOSECONDS), 1, [(0, 0)])
        self.frozen = False
        """While true the history is kept as it is: set during an alarm, which must not
        become the new normal."""

    def add(self, stamp_ns: int, difference: float) -> None:
        """Add course minus yaw (rad, continuous) at a stamp."""
        self._pending.append((stamp_ns, difference))
        while self._pending and self._pending[0][0] <= stamp_ns - self._delay_ns:
            old = self._pending.popleft()
            if not self.frozen:
                self._before.add(old[0], (old[1],))

    def interrupt(self) -> None:
        """Forget the history: the course was lost."""
        self._pending.clear()
        self._before.clear()
        self.frozen = False

    @property
    def offset(self) -> float:
        """Mean of course minus yaw before the window, rad, wrapped to [-π, π]."""
        return math.remainder(self._before.mean(0), math.tau) if len(self._before) else 0.0

    def problem(self) -> str:
        """Why the method is not observable now; empty if the nose follows the course."""
        if self._before.span_ns < self._needed_ns:
            return f"too slow for a course less than {self._reach_s:g} s ago"
        sigma = math.degrees(math.sqrt(self._before.covariance(0)))
        if sigma > self._sigma_deg:
            return f"nose does not follow the course: difference varies by {sigma:.0f}°"
        if abs(math.degrees(self.offset)) > self._offset_deg:
            return f"flying {math.degrees(self.offset):+.0f}° off the nose"
        return ""
