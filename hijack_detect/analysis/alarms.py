# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From verdicts, which are moments, to spans of time: states, alarms and alerts."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from typing import Protocol

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS

UNSAID = "no verdict yet"
"""Reason of the time before the first verdict."""


class Said(Protocol):
    """A verdict of a detector, or a result of the fusion."""

    @property
    def stamp_ns(self) -> int:
        """Header stamp, nanoseconds."""

    @property
    def state(self) -> State:
        """What is claimed."""

    @property
    def reason(self) -> str:
        """Why."""


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
        """How long it lasts."""
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
        self._last = Span(State.NOT_READY, start_ns, sys.maxsize, UNSAID)
        """What holds since the last verdict, until it would go stale."""

    def add(self, said: Said) -> None:
        """Take the next verdict, in order of stamp; one of before the last holds from that on."""
        stamp_ns = max(said.stamp_ns, self._last.start_ns)  # a clock may be set back a little
        self._close(stamp_ns)
        self._last = Span(said.state, stamp_ns, stamp_ns + self._stale_ns, said.reason)

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
