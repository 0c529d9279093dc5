# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Sets of times: when a vehicle was in the air, when a detector could tell."""

from __future__ import annotations

from collections.abc import Iterable

from hijack_detect.streams.samples import NANOSECONDS


class Times:
    """A set of stamps: disjoint intervals in order, start inclusive, end exclusive, nanoseconds.

    Clocks are set back in flight, so the same stamps may come twice; here they are once.
    """

    def __init__(self, intervals: Iterable[tuple[int, int]] = ()) -> None:
        """Unite intervals in any order; those that end before they start are empty."""
        self.intervals: list[tuple[int, int]] = []
        for start, end in sorted(intervals):
            if end <= start:
                continue
            if self.intervals and start <= self.intervals[-1][1]:
                before = self.intervals[-1]
                self.intervals[-1] = before[0], max(before[1], end)
            else:
                self.intervals.append((start, end))

    def __or__(self, other: Times) -> Times:
        """The times that are in either."""
        return Times([*self.intervals, *other.intervals])

    def __and__(self, other: Times) -> Times:
        """The times that are in both."""
        found, at = [], 0
        for start, end in self.intervals:
            while at < len(other.intervals) and other.intervals[at][1] <= start:
                at += 1
            for one in other.intervals[at:]:
                if one[0] >= end:
                    break
                found.append((max(start, one[0]), min(end, one[1])))
        return Times(found)

    def __sub__(self, other: Times) -> Times:
        """The times that are in this and not in the other."""
        if not self.intervals:
            return Times()
        edges = [self.intervals[0][0], *(edge for one in other.intervals for edge in one)]
        edges.append(self.intervals[-1][1])
        return self & Times(zip(edges[::2], edges[1::2], strict=True))

    def before(self, stamp_ns: int) -> Times:
        """The times before a stamp."""
        return Times((start, min(end, stamp_ns)) for start, end in self.intervals)

    @property
    def seconds(self) -> float:
        """How long they are together, to the microsecond."""
        return round(sum(end - start for start, end in self.intervals) / NANOSECONDS, 6)
