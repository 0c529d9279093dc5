# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The tables of an evaluation as text, for the terminal and the page alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hijack_detect.evaluation.scores.evaluate import Evaluation
from hijack_detect.evaluation.scores.methods import BASELINE, PUBLISHED_KLD, MethodOutcome
from hijack_detect.evaluation.scores.metrics import MethodSummary, Proportion, Rate, Spread
from hijack_detect.monitor.parts import PARTS, PUBLISHED

NONE = "–"
MAX_COLUMNS = 6
"""Classes that fit side by side."""

DEFINITIONS = {
    "Correct": "A clean flight is correct for a method that never alarms on it. A hijacked flight "
    "is correct if the method's first alarm of the whole flight lies inside the attack: after an "
    "earlier one the drone would have landed.",
    "Type I": "Clean flights with an alarm, of all clean flights.",
    "Type II": "Hijacked flights without a first alarm inside the attack, of all hijacked "
    "flights. Those where it came before the onset are counted as “early” too, those where it "
    "came after the attack as “late”.",
    "False alarms per hour": "Episodes of alarms that began in clean time, per hour of it: clean "
    "flights whole, hijacked ones until the onset. `kld`, `both` and `fusion` keep their alarm, so "
    "they have at most one a flight.",
    "Time to detect": "From the onset to the first alarm, over the detected flights.",
    "Deviation": "Distance between the true and the reported position at that alarm, where the "
    "true one is known.",
    "ROC area": "Probability that a hijacked flight has a higher score than a clean one. The "
    "score is the largest margin (score over threshold) in a clean flight, and within the attack "
    "in a hijacked one; for `both` the smaller one of its two methods, for `fusion` the largest "
    "confidence up to the alert.",
    "Claimed": "Protocol basan2022: share of the attack in which a method's figures alone were "
    "above its threshold, kept alarms apart.",
    "Likelihood": "Protocol basan2022: derivative of ln L at the mean λ of the values before the "
    "attack, Σ x / λ − n. It is 0 for normal data and has the sign of the change.",
    "Intervals": "Proportions: 95 %, Clopper and Pearson, exact. Rates: one-sided 95 % upper "
    "bound, Poisson, exact.",
}
"""Meaning of the figures."""

EXPLAINED = {
    **{part.name: part.asks for part in (BASELINE, *PARTS) if part.asks},
    PUBLISHED_KLD.name: "KLD as published",
    "both": f"{' and '.join(PUBLISHED)} have both alarmed (Feng 2018, §5)",
    "fusion": "the monitor's alert",
}
"""Description of the methods."""


@dataclass(frozen=True)
class TextTable:
    """A table; the first column is on the left, all others are figures."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def correct_table(evaluation: Evaluation) -> TextTable:
    """Correct flights by method and class; many classes have a row each."""
    kinds = tuple(dict.fromkeys(flight.kind for flight in evaluation.flights))
    title = "Correct flights [95 % interval]"
    if len(kinds) > MAX_COLUMNS:
        methods = evaluation.methods
        by_kind = [
            (kind, *(proportion(one.correct[kind]) for one in methods.values())) for kind in kinds
        ]
        return TextTable(title, ("class", *methods), tuple(by_kind))
    rows = [
        (name, *(proportion(summary.correct[kind]) for kind in kinds))
        for name, summary in evaluation.methods.items()
    ]
    return TextTable(title, ("method", *kinds), tuple(rows))


def error_table(evaluation: Evaluation) -> TextTable:
    """Errors of each method, and how separable clean and hijacked flights are."""
    columns = ("method", "Type I", "Type II", "early, late", "false alarms/h", "ROC area")
    rows = [(name, *_errors(summary)) for name, summary in evaluation.methods.items()]
    return TextTable("Errors [95 % interval; upper bound of the rate]", columns, tuple(rows))


def detection_table(evaluation: Evaluation) -> TextTable:
    """Time to detect of each method."""
    columns = ("method", "detected", "time to detect, s", "deviation at alarm, m")
    rows = [
        (
            name,
            str(summary.detected.count),
            spread(summary.time_to_detect_s),
            spread(summary.deviation_m),
        )
        for name, summary in evaluation.methods.items()
    ]
    return TextTable("Detection: median / 95th percentile / maximum", columns, tuple(rows))


def class_table(evaluation: Evaluation) -> TextTable | None:
    """Time to detect of each method in each class, None unless there are several."""
    attacked = [flight for flight in evaluation.flights if flight.onset_s is not None]
    kinds = tuple(dict.fromkeys(flight.kind for flight in attacked))
    if len(kinds) < 2:
        return None
    rows = [
        (
            kind,
            *(
                _first_alarms([one.methods[name] for one in attacked if one.kind == kind])
                for name in evaluation.methods
            ),
        )
        for kind in kinds
    ]
    return TextTable(
        "Time to detect and deviation at alarm by class: median (95th percentile)",
        ("class", *evaluation.methods),
        tuple(rows),
    )


def flight_table(evaluation: Evaluation) -> TextTable:
    """Result of every method on every flight."""
    columns = ("flight", "class", "onset, s", *evaluation.methods)
    rows = [
        (
            flight.name,
            flight.kind,
            NONE if flight.onset_s is None else f"{flight.onset_s:.1f}",
            *(outcome_text(flight.methods[name]) for name in evaluation.methods),
        )
        for flight in evaluation.flights
    ]
    return TextTable("Every flight", columns, tuple(rows))


def proportion(value: Proportion) -> str:
    """Count and percentage, below them the interval."""
    if value.ratio is None or value.low is None or value.high is None:
        return NONE
    interval = f"[{100 * value.low:.1f}, {100 * value.high:.1f}]"
    return f"{value.count}/{value.total} {100 * value.ratio:.1f} %\n{interval}"


def rate(value: Rate) -> str:
    """Events per hour, below them the upper bound."""
    if value.per_hour is None or value.upper is None:
        return NONE
    return f"{value.per_hour:.2f}\n≤ {value.upper:.2f}"


def spread(value: Spread | None) -> str:
    """Median, 95th percentile and maximum."""
    if value is None:
        return NONE
    return f"{value.median:.1f} / {value.p95:.1f} / {value.max:.1f}"


def outcome_text(outcome: MethodOutcome) -> str:
    """Result of a method on a flight, and when it alarmed."""
    word = outcome.judgement.value
    if outcome.time_to_detect_s is not None:
        return f"{word} +{outcome.time_to_detect_s:.1f} s"
    return word if outcome.first_alarm_s is None else f"{word} at {outcome.first_alarm_s:.1f} s"


def _first_alarms(outcomes: Sequence[MethodOutcome]) -> str:
    """Seconds and below them metres of the detections: median, and 95th percentile in brackets."""
    times = Spread.of([o.time_to_detect_s for o in outcomes if o.time_to_detect_s is not None])
    metres = Spread.of([o.deviation_m for o in outcomes if o.deviation_m is not None])
    if times is None:
        return NONE
    text = f"{times.median:.1f} ({times.p95:.1f}) s"
    return text if metres is None else f"{text}\n{metres.median:.1f} ({metres.p95:.1f}) m"


def _errors(summary: MethodSummary) -> tuple[str, ...]:
    area = summary.roc_area
    return (
        proportion(summary.type_1),
        proportion(summary.type_2),
        f"{summary.early}, {summary.late}",
        rate(summary.false_alarms),
        NONE if area is None else f"{area:.4f}",
    )
