# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Receiver figures that change more often than a sky does: satellites, claimed accuracy."""

from __future__ import annotations

import math
from collections import deque

from hijack_detect.detectors.gnss_checks.step import Finding, Step
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS

WINDOW_NS = 5 * NANOSECONDS
MOST = 0.9
"""Margin of a figure that may only be SUSPICIOUS."""


class _Variation:
    """Sum of the changes of a figure over the last 5 s."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._changes: deque[tuple[int, float]] = deque()
        self.total = 0.0
        self.change = 0.0

    def add(self, stamp_ns: int, value: float | None, most: float = math.inf) -> None:
        """Add a value; a change counts for `most` at most."""
        last, self._last = self._last, value
        self.change = 0.0 if last is None or value is None else abs(value - last)
        if self.change:
            self._changes.append((stamp_ns, min(self.change, most)))
        while self._changes and stamp_ns - self._changes[0][0] > WINDOW_NS:
            self._changes.popleft()
        self.total = math.fsum(change for _, change in self._changes)


def _only_suspicious(part: float, text: str) -> Finding:
    """Finding of evidence that is `part` of what is suspicious."""
    state = State.SUSPICIOUS if part >= 1.0 else State.NORMAL
    return Finding(min(0.5 * part, MOST), state, text)


class SatellitesCheck:
    """The number of satellites: one change, and the sum of all changes over 5 s."""

    name = "satellites"

    def __init__(self, at_once: float, in_5_s: float) -> None:
        """SUSPICIOUS from these numbers on."""
        self._at_once, self._in_5_s = at_once, in_5_s
        self._variation = _Variation()

    def judge(self, step: Step) -> Finding:
        """See Check."""
        seen = self._variation
        seen.add(step.stamp_ns, step.count)
        part = max(seen.change / self._at_once, seen.total / self._in_5_s)
        text = f"satellites change by {seen.change:.0f} at once, {seen.total:.0f} in 5 s"
        return _only_suspicious(part, text)


class CovarianceCheck:
    """The accuracy the receiver claims: sum of the changes of its logarithm over 5 s.

    One change counts for a factor e at most: a receiver that finds or loses its corrections
    changes it a hundredfold, once.
    """

    name = "covariance"

    def __init__(self, in_5_s: float) -> None:
        """SUSPICIOUS from this sum of changes of ln(accuracy) on."""
        self._in_5_s = in_5_s
        self._variation = _Variation()

    def judge(self, step: Step) -> Finding:
        """See Check."""
        accuracy = step.fix.accuracy_m
        self._variation.add(step.stamp_ns, None if accuracy is None else math.log(accuracy), 1.0)
        total = self._variation.total
        text = f"claimed accuracy changes by {total:.1f} in ln over 5 s (limit {self._in_5_s:g})"
        return _only_suspicious(total / self._in_5_s, text)
