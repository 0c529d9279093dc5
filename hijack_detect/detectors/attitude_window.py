# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attitudes that wait for the interval between two GPS velocities to which they belong."""

from __future__ import annotations

from collections import deque
from itertools import pairwise

from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample

HOLE_NS = 3 * NANOSECONDS // 10
"""Longest time between two attitudes of an interval whose mean force means something: six samples
of the slowest usable IMU."""


class AttitudeWindow:
    """The attitudes of the last seconds, given out interval by interval."""

    def __init__(self, kept_s: float) -> None:
        """Start empty.

        Args:
            kept_s: Attitudes older than this have no GPS velocity left to belong to, seconds.
        """
        self._kept_ns = round(kept_s * NANOSECONDS)
        self._attitudes: deque[AttitudeSample] = deque()

    def add(self, sample: AttitudeSample) -> None:
        """Take an attitude, in order of stamp."""
        self._attitudes.append(sample)
        while self._attitudes[0].stamp_ns < sample.stamp_ns - self._kept_ns:
            self._attitudes.popleft()

    def take(self, start_ns: int, end_ns: int) -> list[AttitudeSample]:
        """Attitudes over (start, end], forgetting them and older ones; empty if there is a hole."""
        taken = []
        while self._attitudes and self._attitudes[0].stamp_ns <= end_ns:
            sample = self._attitudes.popleft()
            if sample.stamp_ns > start_ns:
                taken.append(sample)
        stamps = [start_ns, *(sample.stamp_ns for sample in taken), end_ns]
        holes = any(after - before > HOLE_NS for before, after in pairwise(stamps))
        return [] if holes else taken
