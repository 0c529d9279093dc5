# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Stamps for numbers of satellites, which come as `std_msgs/UInt32` without a header."""

from __future__ import annotations

from collections import deque
from typing import Any

from hijack_detect.streams.samples import SatelliteSample

FIX, SATELLITES = "fix", "satellites"

KEPT = 1000
"""Fixes and counts that wait for each other, at most: three minutes at 5 Hz."""


class SatelliteStamps:
    """Gives each count the stamp of its fix: the last one that was published before it.

    Order is that of publication, which every message carries (the source time of DDS; in a bag,
    its place), and not that of arrival: two topics overtake each other on their way. So a count
    is certain once a fix is known that was published after it.
    """

    def __init__(self) -> None:
        """Start without fixes."""
        self._fixes: deque[tuple[int, int]] = deque(maxlen=KEPT)
        self._counts: deque[tuple[int, int]] = deque(maxlen=KEPT)

    def samples(self, name: str, published: int, converted: Any) -> list[tuple[str, Any]]:
        """What a message brings: input names and samples, counts that became certain first.

        Args:
            name: The input.
            published: As for `fix`.
            converted: The sample of the message; of `satellites` the bare number.
        """
        if name == SATELLITES:
            return [(SATELLITES, one) for one in self.count(published, converted)]
        counts = self.fix(published, converted.stamp_ns) if name == FIX else []
        return [*((SATELLITES, one) for one in counts), (name, converted)]

    def fix(self, published: int, stamp_ns: int) -> list[SatelliteSample]:
        """Take a fix; return the counts that became certain.

        Args:
            published: When or where in order it was published.
            stamp_ns: Its header stamp, nanoseconds.
        """
        self._fixes.append((published, stamp_ns))
        return self._certain()

    def count(self, published: int, count: int) -> list[SatelliteSample]:
        """Take a count; return the counts that became certain.

        Args:
            published: As for `fix`.
            count: The number of satellites.
        """
        self._counts.append((published, count))
        return self._certain()

    def _certain(self) -> list[SatelliteSample]:
        samples = []
        while self._fixes and self._counts and self._counts[0][0] < self._fixes[-1][0]:
            published, count = self._counts.popleft()
            while len(self._fixes) > 1 and self._fixes[1][0] <= published:
                self._fixes.popleft()
            if self._fixes[0][0] <= published:
                samples.append(SatelliteSample(self._fixes[0][1], count))
        return samples
