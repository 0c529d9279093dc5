# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The outcome of an analysis in one sentence, for the terminal, the report and the JSON."""

from __future__ import annotations

from hijack_detect.analysis.analysis import Analysis, Outcome

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
"""What is to be thought of the GPS, by what is known of it, or else by what was found."""


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
    """What it is worth that there was no alert: what would have been seen, and for how long."""
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
