# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Conditions over time: an alarm needs a while to be one, and an excursion weighs on afterwards."""

from __future__ import annotations

from collections import deque

from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS

LONGEST_SAMPLE_NS = NANOSECONDS // 10
"""A sample after a gap stands for no longer than this. Chosen, not swept."""


class Persistence:
    """Turns a condition over time into NORMAL, SUSPICIOUS or ALARM, on header stamps."""

    def __init__(self, persist_s: float) -> None:
        """Alarm once the condition has held for `persist_s` seconds."""
        self._persist_ns = round(persist_s * NANOSECONDS)
        self._since_ns: int | None = None

    def reset(self) -> None:
        """The condition cannot be judged now: start over."""
        self._since_ns = None

    def state(self, stamp_ns: int, condition: bool) -> State:
        """State at a stamp."""
        if not condition:
            self._since_ns = None
            return State.NORMAL
        if self._since_ns is None:
            self._since_ns = stamp_ns
        held = stamp_ns - self._since_ns >= self._persist_ns
        return State.ALARM if held else State.SUSPICIOUS


class Excursion:
    """A sensor beyond what a detector can use, and the time until it can again.

    The wait after the last sample beyond is `least_s`, and `gain` times the time spent beyond
    within `longest_s`, and `longest_s` at most.
    """

    def __init__(self, longest_s: float, least_s: float, gain: float = 0.0) -> None:
        """Start without an excursion."""
        self._longest_ns, self._least_ns = longest_s * NANOSECONDS, least_s * NANOSECONDS
        self._gain = gain
        self._last_ns = 0
        self._beyond: deque[tuple[int, int]] = deque()
        """Stamp and length (ns) of the samples beyond."""

    def see(self, stamp_ns: int, beyond: bool) -> None:
        """Take note of a sample of the sensor."""
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if beyond:
            self._beyond.append((stamp_ns, min(stamp_ns - last_ns, LONGEST_SAMPLE_NS)))
        while self._beyond and stamp_ns - self._beyond[0][0] > self._longest_ns:
            self._beyond.popleft()

    def lasts(self, stamp_ns: int) -> bool:
        """Whether it is to be waited for at a stamp."""
        if not self._beyond:
            return False
        wait_ns = self._least_ns + self._gain * sum(length for _, length in self._beyond)
        return stamp_ns - self._beyond[-1][0] <= min(wait_ns, self._longest_ns)
