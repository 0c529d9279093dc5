# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From verdicts, which are moments, to spans of time: states, alarms and alerts."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Protocol

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State
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
        """Total length, to the microsecond."""
        return round(sum(end - start for start, end in self.intervals) / NANOSECONDS, 6)


NO_VERDICT = "no verdict yet"
"""Reason of the time before the first verdict."""


class VerdictLike(Protocol):
    """A verdict of a detector, or a result of the fusion."""

    @property
    def stamp_ns(self) -> int:
        """Header stamp, nanoseconds."""

    @property
    def state(self) -> State:
        """State that is claimed."""

    @property
    def reason(self) -> str:
        """Reason, in words."""


@dataclass(frozen=True)
class Span:
    """A time in one state, from a stamp (inclusive) to a stamp (exclusive), nanoseconds.

    `reason` is that of its first verdict.
    """

    state: State
    start_ns: int
    end_ns: int
    reason: str

    @property
    def seconds(self) -> float:
        """Length."""
        return (self.end_ns - self.start_ns) / NANOSECONDS


class StateSpans:
    """Covers a flight with the states of one detector, without gaps.

    A verdict holds until the next one, but no longer than `stale_ns`: after that the detector is
    silent, which is STALE. Before the first verdict it is NOT_READY. Spans of one state that
    follow on each other are one, so what is kept grows with the changes and not with the flight.
    """

    def __init__(self, start_ns: int, stale_ns: int) -> None:
        """Begin a flight.

        Args:
            start_ns: Where it begins, nanoseconds.
            stale_ns: Longest time for which a verdict holds, nanoseconds.
        """
        self._stale_ns = stale_ns
        self._closed: list[Span] = []
        self._last = Span(State.NOT_READY, start_ns, sys.maxsize, NO_VERDICT)
        """Span of the last verdict, until it would go stale."""

    def add(self, verdict: VerdictLike) -> None:
        """Take the next verdict, in order of stamp; one of before the last holds from that on."""
        stamp_ns = max(verdict.stamp_ns, self._last.start_ns)  # a clock may be set back a little
        self._close(stamp_ns)
        self._last = Span(verdict.state, stamp_ns, stamp_ns + self._stale_ns, verdict.reason)

    def finish(self, end_ns: int) -> list[Span]:
        """All spans of the flight, which ends here, nanoseconds."""
        self._close(end_ns)
        return self._closed

    def _close(self, end_ns: int) -> None:
        until_ns = min(end_ns, self._last.end_ns)
        silent = Span(State.STALE, until_ns, end_ns, "silent")
        for span in (replace(self._last, end_ns=until_ns), silent):
            before = self._closed[-1] if self._closed else None
            if span.end_ns <= span.start_ns:
                continue
            if before and before.state is span.state and before.end_ns == span.start_ns:
                self._closed[-1] = replace(before, end_ns=span.end_ns)
            else:
                self._closed.append(span)


@dataclass(frozen=True)
class AlertSpan:
    """One alert of the fusion, from its stamp until it is taken back or the flight ends."""

    start_ns: int
    end_ns: int
    detectors: tuple[str, ...]
    confidence: float
    cause: str


class AlertSpans:
    """All alerts of a flight."""

    def __init__(self) -> None:
        """Begin a flight without one."""
        self._alerts: list[AlertSpan] = []
        self._before = False

    def add(self, result: FusionResult) -> None:
        """Take the next result of the fusion, in order of stamp."""
        if result.alert and not self._before:
            since_ns = result.stamp_ns if result.alert_since_ns is None else result.alert_since_ns
            self._alerts.append(
                AlertSpan(since_ns, sys.maxsize, result.causes, result.confidence, result.reason)
            )
        elif self._before and not result.alert:
            ends_ns = max(result.stamp_ns, self._alerts[-1].start_ns)  # a clock may be set back
            self._alerts[-1] = replace(self._alerts[-1], end_ns=ends_ns)
        self._before = result.alert

    def finish(self, end_ns: int) -> list[AlertSpan]:
        """All alerts of the flight, which ends here, nanoseconds, in order."""
        if self._before:
            self._alerts[-1] = replace(self._alerts[-1], end_ns=end_ns)
        return self._alerts
