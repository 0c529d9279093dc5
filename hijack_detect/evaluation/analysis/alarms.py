"""From verdicts, which are moments, to spans of time: states, alarms and alerts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS

JUDGED = frozenset({State.NORMAL, State.SUSPICIOUS, State.ALARM})
"""States that say something about the GPS."""


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


def state_spans(said: Sequence[Said], start_ns: int, end_ns: int, stale_ns: int) -> list[Span]:
    """Cover a flight with the states of one detector, without gaps.

    A verdict holds until the next one, but no longer than `stale_ns`: after that the detector is
    silent, which is STALE. Before the first verdict it is NOT_READY.

    Args:
        said: Verdicts in order of stamp.
        start_ns: Where the flight begins, nanoseconds.
        end_ns: Where it ends, nanoseconds.
        stale_ns: Longest time for which a verdict holds, nanoseconds.
    """
    stamps = [*(one.stamp_ns for one in said), end_ns]
    spans = [Span(State.NOT_READY, start_ns, stamps[0], "no verdict yet")]
    for one, next_ns in zip(said, stamps[1:], strict=True):
        until_ns = min(next_ns, one.stamp_ns + stale_ns)
        spans.append(Span(one.state, one.stamp_ns, until_ns, one.reason))
        spans.append(Span(State.STALE, until_ns, next_ns, "silent"))
    return _joined(span for span in spans if span.end_ns > span.start_ns)


def _joined(spans: Iterable[Span]) -> list[Span]:
    """Spans of one state that follow on each other as one."""
    joined: list[Span] = []
    for span in spans:
        if joined and joined[-1].state is span.state and joined[-1].end_ns == span.start_ns:
            joined[-1] = replace(joined[-1], end_ns=span.end_ns)
        else:
            joined.append(span)
    return joined


@dataclass(frozen=True)
class AlertSpan:
    """One alert of the fusion, from its stamp until it is taken back or the flight ends."""

    start_ns: int
    end_ns: int
    detectors: tuple[str, ...]
    confidence: float
    cause: str


def alert_spans(results: Iterable[FusionResult], end_ns: int) -> list[AlertSpan]:
    """All alerts of a flight that ends at `end_ns`, in order."""
    alerts: list[AlertSpan] = []
    before = False
    for result in results:
        if result.alert and not before:
            since_ns = result.stamp_ns if result.alert_since_ns is None else result.alert_since_ns
            alerts.append(
                AlertSpan(since_ns, end_ns, result.causes, result.confidence, result.reason)
            )
        elif before and not result.alert:
            alerts[-1] = replace(alerts[-1], end_ns=result.stamp_ns)
        before = result.alert
    return alerts
