# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Analyses a bag: runs it through the monitor and compares with what is known of an attack."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from hijack_detect.analysis.account import Account, Watched
from hijack_detect.analysis.alarms import AlertSpan, Span, Times
from hijack_detect.analysis.analysis import (
    Alert,
    Analysis,
    DetectorAnalysis,
    Interval,
    Outcome,
    Peak,
    Spoof,
)
from hijack_detect.analysis.log_clock import LogClock
from hijack_detect.analysis.worth import (
    clock_notes,
    not_judged,
    sensor_notes,
    visible,
    visible_steps,
)
from hijack_detect.bags.reader import BagReader
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.logs.logged import Notes
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import FlightNotes, outputs_of, spoofed_samples
from hijack_detect.replay.truth import Attack, Source, known_attack, truth_track
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.streams.samples import NANOSECONDS, Sample

SPOOFED, CLEAN, OPEN = "spoofed", "clean", "not judged"
FOUND = {
    Outcome.DETECTED: SPOOFED,
    Outcome.MISSED: SPOOFED,
    Outcome.LATE: SPOOFED,
    Outcome.ALERT_UNLABELLED: SPOOFED,
    Outcome.NO_ATTACK_NO_ALERT: CLEAN,
    Outcome.NO_ALERT_UNLABELLED: CLEAN,
    Outcome.NOT_JUDGED: OPEN,
}
"""Judgement of the GPS, by what is known of it, or else by what was found."""


def found(analysis: Analysis) -> str:
    """SPOOFED, CLEAN or OPEN: whether the GPS was spoofed, and not how well that was seen."""
    if analysis.outcome is Outcome.FALSE_ALERT:
        return CLEAN if analysis.spoof is None else SPOOFED
    return FOUND[analysis.outcome]


def sentence(analysis: Analysis) -> str:
    """Say what was found, when, and what it is worth where nothing was found."""
    alert = f"{analysis.alerts[0].start_s:.1f} s" if analysis.alerts else ""
    spoof = analysis.spoof
    onset = "" if spoof is None else f"{spoof.onset_s:.1f} s"
    match analysis.outcome:
        case Outcome.DETECTED:
            return (
                f"Spoofed from {onset} on and detected {analysis.time_to_detect_s:.1f} s later, "
                f"at {alert}{_deviation(analysis)}."
            )
        case Outcome.MISSED:
            missed = f"Missed: the GPS was spoofed from {onset} on, without an alert"
            return f"{missed}{_far(analysis)}. {worth(analysis)}"
        case Outcome.LATE:
            end = "" if spoof is None or spoof.end_s is None else f" at {spoof.end_s:.1f} s"
            return f"Detected too late: the alert came at {alert}, the attack had ended{end}."
        case Outcome.FALSE_ALERT if spoof is not None:
            return f"False alert at {alert}: the attack only began at {onset}."
        case Outcome.FALSE_ALERT:
            return f"False alert at {alert}: this flight is known to be clean."
        case Outcome.NO_ATTACK_NO_ALERT:
            return f"No alert, and this flight is known to be clean. {worth(analysis)}"
        case Outcome.ALERT_UNLABELLED:
            return f"The GPS looks spoofed: alert at {alert}. Nothing else is known of an attack."
        case Outcome.NO_ALERT_UNLABELLED:
            return f"No sign of spoofing. {worth(analysis)}"
        case Outcome.NOT_JUDGED:
            return f"{worth(analysis)} This is no sign that the GPS was honest."


def worth(analysis: Analysis) -> str:
    """Worth of a result without alert: what would have been seen, and for how long."""
    if analysis.not_judged is not None:
        return f"The flight could not be judged: {analysis.not_judged}."
    whole, visible = analysis.in_air_s, analysis.visible
    if visible is not None and round(percent(visible.time_s, whole)) > 0:
        part, pull = percent(visible.time_s, whole), f"{visible.acceleration:.1f} m/s²"
        return (
            f"During {part:.0f} % of {duration(whole)} in the air a pull of {pull} or more would "
            "have been seen."
        )
    return (
        f"During {percent(analysis.judged_s, whole):.0f} % of {duration(whole)} in the air a "
        "detector could tell that sees carry-offs, from which size on is not known."
    )


def percent(part_s: float, whole_s: float) -> float:
    """A part of a time, never above 100 %; 0 of nothing."""
    return min(100.0 * part_s / whole_s, 100.0) if whole_s > 0.0 else 0.0


def duration(seconds: float) -> str:
    """A time in words: seconds up to two minutes, then minutes."""
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.1f} min"


def _deviation(analysis: Analysis) -> str:
    if analysis.deviation_at_alarm_m is None:
        return ""
    return f", with the reported position {analysis.deviation_at_alarm_m:.0f} m from the true one"


def _far(analysis: Analysis) -> str:
    metres = None if analysis.spoof is None else analysis.spoof.largest_deviation_m
    return "" if metres is None else f"; the reported position was up to {metres:.0f} m off"


@dataclass(frozen=True)
class Analysed:
    """An analysis, and what it was made from.

    Attributes:
        analysis: The result, as data.
        flight: What was noted of the samples.
        parameters: Parameters of the monitor.
        attack: The attack, if one is known.
        alerts: All alerts.
        spans: The states of each detector, and of the fusion under `MONITOR`.
        end_ns: Where the flight ends, nanoseconds.
    """

    analysis: Analysis
    flight: FlightNotes
    parameters: MonitorParameters
    attack: Attack | None
    alerts: list[AlertSpan]
    spans: dict[str, list[Span]]
    end_ns: int

    def seconds(self, stamp_ns: int) -> float:
        """Seconds from the bag's first message to a stamp, to the microsecond."""
        return _seconds(stamp_ns, self.flight.start_ns)


def analyse(
    reader: BagReader,
    parameters: MonitorParameters,
    scenario: Scenario | None = None,
    *,
    imported: Notes | None = None,
    on_sample: Callable[[Sample], None] | None = None,
    on_output: Callable[[str, Any], None] | None = None,
) -> Analysed:
    """Analyse a bag.

    Args:
        reader: The bag.
        parameters: Parameters of the monitor.
        scenario: An attack to inject, if any.
        imported: What was noted when the bag was made of a log.
        on_sample: Called with every sample, placed by `LogClock`.
        on_output: Called with part and output of everything that any part puts out, placed by
            `LogClock`: verdicts are not kept, for no flight is too long to be analysed.

    Raises:
        BagError: The bag cannot be read, or its label is none.
        ScenarioError: A segment lies outside the flight.
    """
    attack, source = known_attack(reader, scenario)
    truth = truth_track(reader) if scenario is None else None
    flight, monitor = FlightNotes(reader.start_ns), Monitor(parameters)
    clock = LogClock()
    clock.adopt_first = attack is None
    account = Account(monitor.detectors, parameters.fusion, reader.start_ns, clock)

    def take(sample: Sample) -> None:
        clock.take(sample, reader.at_ns)
        account.take(sample)
        if on_sample is not None:
            on_sample(clock.placed(sample))

    samples = spoofed_samples(reader, scenario, flight, truth=truth)
    for part, output in outputs_of(samples, monitor, on_sample=take):
        account.take_output(part, output)
        if on_output is not None:
            on_output(part, clock.placed(output))

    end_ns = max(reader.end_ns, account.newest_ns)
    spans, watched = account.finish(end_ns)
    watched = watched.within(reader.start_ns, reader.end_ns)
    alerts = account.alerts(end_ns)
    hit = first_hit(alerts, attack)
    unjudged = not_judged(account, watched, spans)
    outcome = outcome_of(alerts, attack, labelled=source is not None)
    if unjudged is not None and outcome in QUIET:
        outcome = Outcome.NOT_JUDGED
    notes = Notes() if imported is None else imported

    def seconds(stamp_ns: int) -> float:
        return _seconds(stamp_ns, reader.start_ns)

    draft = Analysis(
        bag=str(reader.path),
        start_ns=reader.start_ns,
        duration_s=reader.duration_s,
        scenario=None if scenario is None else scenario.source,
        policy=parameters.fusion.policy,
        outcome=outcome,
        verdict="",
        not_judged=unjudged,
        alerts=_alerts(alerts, seconds),
        alarms=_alerts(account.alarms(end_ns), seconds),
        detectors={
            name: _detector(
                account.peaks.get(name),
                spans[name],
                (watched.in_air & watched.judged[name]).seconds,
                reader.end_ns,
                seconds,
            )
            for name in monitor.detectors
        },
        in_air_s=watched.in_air.seconds,
        judged_s=(watched.in_air & watched.carry_off).seconds,
        at_risk_s=at_risk(watched, alerts).seconds,
        receiver_poor_s=account.poor.lasted_ns / NANOSECONDS,
        gps_late_s=account.late.lasted_ns / NANOSECONDS,
        visible=visible(watched),
        visible_steps=tuple(visible_steps(watched)),
        spoof=_spoof(attack, source, flight, seconds),
        time_to_detect_s=(
            None if hit is None or attack is None else _seconds(hit.start_ns, attack.onset_ns)
        ),
        deviation_at_alarm_m=(
            None if hit is None or not flight.separations else flight.separation_at(hit.start_ns)
        ),
        skipped=skipped(flight, monitor, notes),
        notes=(
            *notes.remarks,
            *clock_notes(monitor.clock.findings),
            *sensor_notes(account, reader.duration_s),
        ),
    )
    analysis = draft.model_copy(update={"verdict": sentence(draft)})
    return Analysed(analysis, flight, parameters, attack, alerts, spans, end_ns)


QUIET = frozenset({Outcome.NO_ATTACK_NO_ALERT, Outcome.NO_ALERT_UNLABELLED})
"""Outcomes that would comfort: where nothing could be judged, it is NOT_JUDGED instead."""


def at_risk(watched: Watched, alerts: Sequence[AlertSpan]) -> Times:
    """The time in the air in which an alert was possible, until the first one."""
    possible = watched.in_air & watched.alertable
    return possible.before(alerts[0].start_ns) if alerts else possible


def first_hit(alerts: list[AlertSpan], attack: Attack | None) -> AlertSpan | None:
    """The first alert that began at or after the onset of the attack."""
    if attack is None:
        return None
    return next((one for one in alerts if one.start_ns >= attack.onset_ns), None)


def outcome_of(alerts: list[AlertSpan], attack: Attack | None, *, labelled: bool) -> Outcome:
    """Judge the first alert; `labelled`: a flight without attack is known to be clean."""
    if attack is None:
        if alerts:
            return Outcome.FALSE_ALERT if labelled else Outcome.ALERT_UNLABELLED
        return Outcome.NO_ATTACK_NO_ALERT if labelled else Outcome.NO_ALERT_UNLABELLED
    if not alerts:
        return Outcome.MISSED
    if alerts[0].start_ns < attack.onset_ns:
        return Outcome.FALSE_ALERT
    ended = attack.end_ns is not None and alerts[0].start_ns >= attack.end_ns
    return Outcome.LATE if ended else Outcome.DETECTED


def skipped(flight: FlightNotes, monitor: Monitor, imported: Notes) -> dict[str, int]:
    """Messages that were left out, by reason: at import, for a value, or for their stamp.

    Several parts may refuse the same sample for its stamp; it counts once.
    """
    counts = Counter(
        {f"{topic}: {name} out of range": n for (topic, name), n in flight.rejected.counts.items()}
    )
    counts.update(imported.skipped)
    for part, stage in monitor.stages.items():
        if part != "fusion":
            for reason, number in stage.refused.items():
                counts[reason] = max(counts[reason], number)
    return dict(sorted(counts.items()))


def _alerts(alerts: Sequence[AlertSpan], seconds: Callable[[int], float]) -> tuple[Alert, ...]:
    return tuple(
        Alert(
            start_s=seconds(one.start_ns),
            end_s=seconds(one.end_ns),
            detectors=one.detectors,
            confidence=one.confidence,
            cause=one.cause,
        )
        for one in alerts
    )


def _detector(
    peak: Verdict | None,
    spans: list[Span],
    told_s: float,
    until_ns: int,
    seconds: Callable[[int], float],
) -> DetectorAnalysis:
    """Alarms, seconds in each state until the last message, and the largest margin."""
    state_s = dict.fromkeys(State, 0.0)
    for span in spans:
        state_s[span.state] += max(0, min(span.end_ns, until_ns) - span.start_ns) / NANOSECONDS
    return DetectorAnalysis(
        alarms=tuple(
            Interval(start_s=seconds(span.start_ns), end_s=seconds(span.end_ns))
            for span in spans
            if span.state is State.ALARM
        ),
        state_s={state: round(seconds_in, 6) for state, seconds_in in state_s.items()},
        told_s=told_s,
        largest_margin=(
            None
            if peak is None
            else Peak(margin=peak.margin, at_s=seconds(peak.stamp_ns), reason=peak.reason)
        ),
    )


def _spoof(
    attack: Attack | None,
    source: Source | None,
    flight: FlightNotes,
    seconds: Callable[[int], float],
) -> Spoof | None:
    if attack is None or source is None:
        return None
    far = [metres for stamp_ns, metres in flight.separations if stamp_ns >= attack.onset_ns]
    return Spoof(
        onset_s=seconds(attack.onset_ns),
        end_s=None if attack.end_ns is None else seconds(attack.end_ns),
        known_from=source,
        largest_deviation_m=max(far, default=None),
    )


def _seconds(stamp_ns: int, since_ns: int) -> float:
    return round((stamp_ns - since_ns) / NANOSECONDS, 6)
