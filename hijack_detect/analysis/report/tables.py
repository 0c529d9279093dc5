# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The parts of the page that are no figures: key facts, key of the shades, and tables, as HTML."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from hijack_detect.analysis.account import MONITOR
from hijack_detect.analysis.alarms import Span
from hijack_detect.analysis.analyse import Analysed, percent
from hijack_detect.analysis.analysis import Analysis
from hijack_detect.analysis.report.style import (
    ALARM_BAND,
    ALERT,
    ATTACK,
    ATTACK_BAND,
    STATE_COLOURS,
)
from hijack_detect.detectors.verdict import State

ODD = frozenset({State.SUSPICIOUS, State.ALARM, State.STALE})
KNOWN_FROM = {
    "scenario": "injected by the scenario",
    "ground_truth": "by the ground truth in the bag",
    "label": "by the label beside the bag",
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


SHOWN = frozenset({0.5, 1.0, 2.0})
"""Pulls (m/s²) among the key figures."""
KIND_COLOURS = {
    **{state.value: colour for state, colour in STATE_COLOURS.items()},
    "attack": ATTACK,
    "alert": ALERT,
}
"""Colour of each kind of event."""


def facts(analysis: Analysis) -> Iterator[str]:
    """The key figures."""
    for term, value in _facts(analysis):
        yield f"<div><dt>{escape(term)}</dt><dd>{escape(value)}</dd></div>"


def causes(analysis: Analysis) -> Iterator[str]:
    """Reasons of the alert, a paragraph each."""
    for alert in analysis.alerts:
        yield f'<p class="cause">Cause: {escape(alert.cause)}</p>'


def notes(analysis: Analysis) -> Iterator[str]:
    """Notes on the sensors, as items of a list."""
    for note in analysis.notes:
        yield f"<li>{escape(note)}</li>"


def _facts(analysis: Analysis) -> Iterator[tuple[str, str]]:
    spoof = analysis.spoof
    if spoof is not None:
        lasts = spoof.end_s is None or spoof.end_s > analysis.duration_s - 0.1
        end = "the end" if lasts else f"{spoof.end_s:.1f} s"
        yield "attack", f"{spoof.onset_s:.1f} s to {end}"
    if analysis.scenario is not None:
        yield "scenario", Path(analysis.scenario).stem
    yield "first alert", f"{analysis.alerts[0].start_s:.1f} s" if analysis.alerts else "none"
    if analysis.time_to_detect_s is not None:
        yield "time to detect", f"{analysis.time_to_detect_s:.1f} s"
    if analysis.deviation_at_alarm_m is not None:
        yield "deviation at the alert", f"{analysis.deviation_at_alarm_m:.1f} m"
    peaks = {name: one.largest_margin for name, one in analysis.detectors.items()}
    margins = [(peak.margin, name) for name, peak in peaks.items() if peak is not None]
    if margins:
        yield "largest margin", "{:.2f} ({})".format(*max(margins))
    if len(analysis.alarms) > 1:
        yield "alarms, each taken back", str(len(analysis.alarms))
    yield "in the air", f"{analysis.in_air_s:.0f} of {analysis.duration_s:.0f} s"
    if analysis.in_air_s > 0.0:
        share = percent(analysis.judged_s, analysis.in_air_s)
        yield "could see a carry-off", f"{share:.0f} % of the air time"
        for one in analysis.visible_steps:
            if one.acceleration in SHOWN:
                part = percent(one.time_s, analysis.in_air_s)
                yield f"a pull of {one.acceleration:g} m/s² seen", f"{part:.0f} % of the air time"
    yield "policy", analysis.policy


def key(done: Analysed) -> Iterator[str]:
    """Legend of the shades in the figures."""
    if done.attack is not None:
        shade = f"background: {ATTACK_BAND}; outline: 1px solid {ATTACK}"
        yield f'<span><i style="{shade}"></i>attack</span>'
    yield f'<span><i style="background: {ALARM_BAND}"></i>alarm of a detector</span>'
    yield f'<span><i style="border-left: 3px solid {ALERT}; width: 4px"></i>alert</span>'


def event_rows(rows: Sequence[Event]) -> Iterator[str]:
    """Rows of the table of events."""
    for event in rows:
        dot = f'<span class="dot" style="--dot: {KIND_COLOURS[event.kind]}"></span>'
        yield (
            f'<tr class="{event.kind}"><td class="n">{event.time_s:.1f}</td>'
            f"<td>{dot}{escape(event.what)}</td><td>{escape(event.why)}</td></tr>"
        )
    if not rows:
        yield "<tr><td></td><td>none</td><td></td></tr>"


def detector_rows(analysis: Analysis) -> Iterator[str]:
    """Share of the air time in which it could tell, of each state, and the largest margin."""
    for name, one in analysis.detectors.items():
        whole, peak = sum(one.state_s.values()) or 1.0, one.largest_margin
        aloft = analysis.in_air_s
        numbers = [f"{percent(one.told_s, aloft):.0f} %" if aloft > 0.0 else "–"]
        numbers += [f"{100.0 * one.state_s[state] / whole:.0f} %" for state in State]
        numbers.append("–" if peak is None else f"{peak.margin:.2f}")
        cells = "".join(f'<td class="n">{number}</td>' for number in numbers)
        reason = "" if peak is None else f"{peak.at_s:.1f} s: {peak.reason}"
        yield f"<tr><td>{escape(name)}</td>{cells}<td>{escape(reason)}</td></tr>"


def skipped_rows(analysis: Analysis) -> Iterator[str]:
    """Number and reason of the messages that were left out."""
    for reason, number in analysis.skipped.items():
        yield f'<tr><td class="n">{number}</td><td>{escape(reason)}</td></tr>'
