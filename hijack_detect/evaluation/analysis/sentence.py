# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The outcome of an analysis in one sentence, for the terminal, the report and the JSON."""

from __future__ import annotations

from hijack_detect.evaluation.analysis.analysis import Analysis, Outcome


def sentence(analysis: Analysis) -> str:
    """Say what was found, when, and how that compares with what is known of the attack."""
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
            return f"Missed: the GPS was spoofed from {onset} on, without an alert{_far(analysis)}."
        case Outcome.LATE:
            end = "" if spoof is None or spoof.end_s is None else f" at {spoof.end_s:.1f} s"
            return f"Detected too late: the alert came at {alert}, the attack had ended{end}."
        case Outcome.FALSE_ALERT if spoof is not None:
            return f"False alert at {alert}: the attack only began at {onset}."
        case Outcome.FALSE_ALERT:
            return f"False alert at {alert}: this flight is known to be clean."
        case Outcome.NO_ATTACK_NO_ALERT:
            return f"No alert, and this flight is known to be clean. {_judged(analysis)}"
        case Outcome.ALERT_UNLABELLED:
            return f"The GPS looks spoofed: alert at {alert}. Nothing else is known of an attack."
        case Outcome.NO_ALERT_UNLABELLED:
            return f"No sign of spoofing. {_judged(analysis)}"


def _deviation(analysis: Analysis) -> str:
    if analysis.deviation_at_alarm_m is None:
        return ""
    return f", with the reported position {analysis.deviation_at_alarm_m:.0f} m from the true one"


def _far(analysis: Analysis) -> str:
    metres = None if analysis.spoof is None else analysis.spoof.largest_deviation_m
    return "" if metres is None else f"; the reported position was up to {metres:.0f} m off"


def _judged(analysis: Analysis) -> str:
    part = 100.0 * analysis.judged_s / analysis.duration_s if analysis.duration_s > 0.0 else 0.0
    return f"At least one detector could tell during {part:.0f} % of the flight."
