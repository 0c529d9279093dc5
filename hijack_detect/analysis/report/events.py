# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The table of events: when what happened, and why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from hijack_detect.analysis.account import MONITOR
from hijack_detect.analysis.alarms import Span
from hijack_detect.analysis.analyse import Analysed
from hijack_detect.detectors.verdict import State

ODD = frozenset({State.SUSPICIOUS, State.ALARM, State.STALE})
KNOWN_FROM = {
    "scenario": "injected by the scenario",
    "ground_truth": "as the ground truth in the bag says",
    "label": "as the label beside the bag says",
}


@dataclass(frozen=True)
class Event:
    """One row: second of the flight, kind (a CSS class), what happened, and why."""

    time_s: float
    kind: str
    what: str
    why: str


def events(done: Analysed) -> list[Event]:
    """Attack, alerts, and each time that a detector became suspicious, alarmed or silent."""
    return sorted(_all(done), key=lambda event: event.time_s)


def _all(done: Analysed) -> Iterator[Event]:
    spoof = done.analysis.spoof
    if spoof is not None:
        yield Event(spoof.onset_s, "attack", "attack begins", KNOWN_FROM[spoof.known_from])
        if spoof.end_s is not None and spoof.end_s < done.analysis.duration_s - 0.1:
            yield Event(spoof.end_s, "attack", "attack ends", KNOWN_FROM[spoof.known_from])
    for alert in done.analysis.alerts:
        yield Event(alert.start_s, "alert", "ALERT", alert.cause)
    for name, spans in done.spans.items():
        if name != MONITOR:
            yield from _changes(done, name, spans)


def _changes(done: Analysed, name: str, spans: list[Span]) -> Iterator[Event]:
    """Into each odd state, and back."""
    before = State.NOT_READY
    for span in spans:
        at_s = done.seconds(span.start_ns)
        if span.state in ODD:
            what = f"{name}: {span.state.value} for {span.seconds:.1f} s"
            yield Event(at_s, span.state.value, what, span.reason)
        elif before is State.ALARM:
            yield Event(at_s, "normal", f"{name}: alarm over", span.reason)
        before = span.state
