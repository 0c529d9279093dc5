# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Output of the command `tune`, and the head of the file that it writes."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from rich.console import Console

from hijack_detect.cli.evaluate_view import drawn
from hijack_detect.cli.parameter_files import WIDTH, manual
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.evaluation.scores.evaluation_tables import (
    NONE,
    TextTable,
    proportion,
    rate,
    spread,
)
from hijack_detect.evaluation.scores.metrics import (
    FlightOutcome,
    MethodSummary,
    Rate,
    summarise,
)
from hijack_detect.evaluation.tuning.noise import middle_half
from hijack_detect.evaluation.tuning.thresholds import TUNABLES, Choice, Kept
from hijack_detect.evaluation.tuning.tuning import Tuning

METHODS = (*TUNABLES, "fusion")


def written(tuning: Tuning, policy: str, per_hour: float) -> str:
    """The parameter file: what differs from the defaults, below where it comes from."""
    days = sorted({one.day for one in tuning.surveys})
    names = ", ".join(one.name for one in tuning.surveys)
    lines = [
        f"Parameters of hijack_detect, policy `{policy}`, tuned by `hijack-detect tune`. What is "
        "not here keeps its default.",
        f"Flights: {names} ({tuning.hours:.2f} h, recorded {days[0]} to {days[-1]}).",
        f"Requested: {per_hour:g} false alarms an hour of each detector. "
        f"{proof(tuning.hours, per_hour)}",
        _lag(tuning),
        *_kept(tuning),
    ]
    for method in METHODS:
        lines.append(f"{method}: {_reached(tuning, method)}")
    comment = "\n".join(
        textwrap.fill(line, WIDTH, initial_indent="# ", subsequent_indent="#   ") for line in lines
    )
    return manual(tuning.parameters, f"{comment}\n", changed_only=True)


def print_tuning(tuning: Tuning, per_hour: float) -> None:
    """Print what was chosen, why, and what it costs."""
    console = Console(highlight=False, markup=False)
    console.print(f"{len(tuning.surveys)} clean flights. {proof(tuning.hours, per_hour)}")
    console.print(_lag(tuning))
    for line in (*_noise(tuning), *_kept(tuning)):
        console.print(line)
    console.print(drawn(_choices(tuning)))
    console.print(drawn(_alarms(tuning)))
    if tuning.attacked_after:
        console.print(drawn(_cost(tuning)))


def proof(hours: float, per_hour: float) -> str:
    """Rate that the length of the flights can show."""
    bound = Rate.of(0, hours).upper or 0.0
    text = f"{hours:.2f} h without an alarm show a rate below {bound:.2g}/h (95 %)"
    if bound <= per_hour:
        return f"{text}, enough for {per_hour:g}/h."
    return (
        f"{text}; {per_hour:g}/h would take {bound * hours / per_hour:.1f} h. So no alarm at all "
        "is allowed on them, and a safety factor comes on top."
    )


def _lag(tuning: Tuning) -> str:
    if tuning.lag_s is None:
        return "GPS lag: no flight accelerates enough to show it, kept as it was."
    count = sum(one.lag is not None for one in tuning.surveys)
    middle, low, high = tuning.lag_s
    return (
        f"GPS lag: {middle:.3f} s (middle half {low:.3f} to {high:.3f} s, {count} of "
        f"{len(tuning.surveys)} flights show it)."
    )


def _noise(tuning: Tuning) -> list[str]:
    """Measurements that are only printed.

    In the filter these values made the tilt of simulated autopilot flights worse by 0 to 0.1°:
    its own stand for the errors of its model as well.
    """
    found = [one.noise for one in tuning.surveys if one.noise is not None]
    if not found:
        return ["IMU noise: no flight is long enough to show it."]
    kept = tuning.parameters.of(AttitudeParameters)
    return [
        f"{what} noise: {middle_half(values)[0]:.2g} {unit} between samples, vibration included. "
        f"The filter keeps {own:g}, which stands for the errors of its model as well."
        for what, values, unit, own in (
            ("Accelerometer", [n.accel for n in found], "m/s²/√Hz", kept.accel_noise),
            ("Gyroscope", [n.gyro for n in found], "rad/s/√Hz", kept.gyro_noise),
        )
    ]


def _choices(tuning: Tuning) -> TextTable:
    rows = []
    for name, choice in tuning.choices.items():
        tunable = TUNABLES[name]
        chosen = (NONE, NONE, NONE, "kept")
        if isinstance(choice, Choice):
            chosen = (
                f"{choice.judged_hours:.2f}",
                f"{choice.quiet:.3g}",
                f"{choice.factor:.2f}",
                f"{choice.value:g} {tunable.unit}",
            )
        rows.append((f"{name} {tunable.name}", f"{tunable.of(tuning.given):g}", *chosen))
    columns = ("threshold", "before", "hours judged", "quiet from", "factor", "chosen")
    return TextTable("Thresholds", columns, tuple(rows))


def _kept(tuning: Tuning) -> list[str]:
    return [
        f"{name}: {TUNABLES[name].name} is kept at {TUNABLES[name].of(tuning.given):g} "
        f"{TUNABLES[name].unit}: {choice.reason}."
        for name, choice in tuning.choices.items()
        if isinstance(choice, Kept)
    ]


def _alarms(tuning: Tuning) -> TextTable:
    rows = [
        (method, _false_alarms(tuning.before, method), _false_alarms(tuning.held_out, method))
        for method in METHODS
    ]
    columns = ("method", "before", "chosen on the other flights")
    return TextTable("Alarms on clean flights, per hour [95 % upper bound]", columns, tuple(rows))


def _false_alarms(flights: Sequence[FlightOutcome], method: str) -> str:
    if not flights:
        return NONE
    alarms = summarise(flights, method).false_alarms
    return _one_line(f"{alarms.events} in {alarms.hours:.2f} h: {rate(alarms)}")


def _cost(tuning: Tuning) -> TextTable:
    rows = []
    for method in METHODS:
        before = summarise(tuning.attacked_before, method)
        after = summarise(tuning.attacked_after, method)
        rows.append((method, *_detected(before), *_detected(after)))
    columns = ("method", "before", "s", "after", "s")
    title = "Attacks detected [95 % interval], seconds: median / 95th percentile / maximum"
    return TextTable(title, columns, tuple(rows))


def _detected(summary: MethodSummary) -> tuple[str, str]:
    return proportion(summary.detected), spread(summary.time_to_detect_s)


def _reached(tuning: Tuning, method: str) -> str:
    """One method in one line."""
    text = "one flight, so nothing to check it on"
    if tuning.held_out:
        text = f"on flights that it was not chosen on, {_false_alarms(tuning.held_out, method)}"
    if tuning.attacked_after:
        found = summarise(tuning.attacked_after, method).detected
        text += f"; detects {_one_line(proportion(found))} of the attacks"
    return text


def _one_line(text: str) -> str:
    return text.replace("\n", " ")
