# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Bounded histories that each reader reads at its own pace."""

from __future__ import annotations

from collections import deque
from itertools import islice
from typing import Generic, TypeVar

T = TypeVar("T")


class Series(Generic[T]):
    """The newest entries, each with a number that it keeps.

    Attributes:
        count: Number of entries that ever came; the number of the next one.
    """

    def __init__(self, most: int) -> None:
        """Keep at most so many."""
        self.count = 0
        self._entries: deque[T] = deque(maxlen=most)

    def append(self, entry: T) -> None:
        """Add an entry; the oldest one goes if there are too many."""
        self._entries.append(entry)
        self.count += 1

    @property
    def last(self) -> T | None:
        """The newest entry."""
        return self._entries[-1] if self._entries else None

    def since(self, number: int) -> list[T]:
        """The entries from this number on, as far as they are kept."""
        oldest = self.count - len(self._entries)
        return list(islice(self._entries, max(0, number - oldest), None))


class Curve:
    """One value over time, thinned to its largest in each period so that no peak is lost."""

    def __init__(self, most: int, period_s: float) -> None:
        """Keep at most so many points, one for each period."""
        self.points: Series[tuple[float, float | None]] = Series(most)
        self._period_s = period_s
        self._peak: tuple[float, float] | None = None

    def hear(self, time_s: float, value: float | None) -> None:
        """Take the next value; None is a gap."""
        peak = self._peak
        if peak is not None and (value is None or self._period(time_s) != self._period(peak[0])):
            self.points.append(peak)
            self._peak = peak = None
        if value is not None:
            if peak is None or value >= peak[1]:
                self._peak = time_s, value
        elif self.points.last is not None and self.points.last[1] is not None:
            self.points.append((time_s, None))

    def _period(self, time_s: float) -> int:
        return int(time_s // self._period_s)
