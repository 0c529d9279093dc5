# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Correctness of the methods against one parameter (Feng et al. 2018, Figures 16 and 17)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.evaluation.scores.metrics import Proportion
from hijack_detect.evaluation.trials.cases import HIJACKED, Case, class_of
from hijack_detect.evaluation.trials.parallel import HERE, Failure, Pool, map_cases
from hijack_detect.evaluation.trials.recorded import Recorded, judge
from hijack_detect.evaluation.trials.recorded import record as record_flight
from hijack_detect.monitor.graph import component_of
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.truth import Attack, alert_is_right

CLEAN = "non-hijacked"
"""All classes but `hijacked` together."""
CLAIMED = "hijacked, any alarm"
"""Hijacked flights with an alarm at any time, before the onset or after the attack too: what a
judgement of whole flights, which does not ask when, counts as correct."""


@dataclass(frozen=True)
class Sweep:
    """A parameter and the values to try.

    Attributes:
        parameter: Its name; every detector in `methods` has it.
        label: What to write on an axis.
        values: Ascending.
        published: The paper's value.
        methods: Detectors to run.
        log: Whether the axis is logarithmic.
    """

    parameter: str
    label: str
    values: tuple[float, ...]
    published: float
    methods: tuple[str, ...] = ("correlation",)
    log: bool = False


SWEEPS: Mapping[str, Sweep] = {
    "epsilon": Sweep(
        "epsilon",
        "correlation threshold ε (at the policy's μ)",
        (-0.9, -0.6, -0.3, 0.0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 0.98, 0.995),
        0.85,
    ),
    "mu": Sweep(
        "mu_deg",
        "direction threshold μ, degrees (at the policy's ε)",
        (1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 80, 100),
        10.0,
        log=True,
    ),
    "window": Sweep(
        "window_s",
        "window, seconds",
        (0.5, 0.8, 1.2, 1.6, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0, 12.0),
        2.0,
        methods=("correlation", "date"),
        log=True,
    ),
}
"""Sweeps by name."""


@dataclass(frozen=True)
class SweptFlight:
    """One flight at every value.

    Attributes:
        kind: Its class.
        attack: The attack on it, None if it is clean.
        alarms_ns: By method, the first alarm at each value, None for no alarm.
    """

    kind: str
    attack: Attack | None
    alarms_ns: Mapping[str, tuple[int | None, ...]]

    def right(self, method: str) -> list[bool]:
        """Whether each value judges it correctly.

        A clean flight is without any alarm, a hijacked one if its first alarm is in the attack.
        """
        return [alert_is_right(first, self.attack) for first in self.alarms_ns[method]]


@dataclass(frozen=True)
class Curve:
    """Correct flights of one class by one method, for each value of the sweep."""

    method: str
    kind: str
    correct: tuple[Proportion, ...]


def sweep(
    cases: Sequence[Case],
    parameters: MonitorParameters,
    what: Sweep,
    *,
    pool: Pool = HERE,
    on_done: Callable[[int], None] | None = None,
) -> tuple[list[Curve], list[Failure]]:
    """Run the estimators once over every flight, and the detectors at every value.

    Args:
        cases: The flights.
        parameters: Parameters of every part; only the swept one is changed.
        what: The parameter and its values.
        pool: Where the flights are run.
        on_done: Called after each flight with the number of flights that are done.

    Returns:
        The curves of each method: hijacked and all other flights, each class of the others, and
        CLAIMED; and the flights that could not be run.
    """
    results = map_cases(
        partial(swept, parameters, what), cases, pool=pool, kind=SweptFlight, on_done=on_done
    )
    flights = [result for result in results if isinstance(result, SweptFlight)]
    kinds = dict.fromkeys(flight.kind for flight in flights)
    hijacked = [flight for flight in flights if flight.kind == HIJACKED]
    groups: dict[str, list[SweptFlight]] = {
        HIJACKED: hijacked,
        CLEAN: [flight for flight in flights if flight.kind != HIJACKED],
    }
    clean_kinds = [kind for kind in kinds if kind != HIJACKED]
    if len(clean_kinds) > 1:
        groups |= {kind: [one for one in flights if one.kind == kind] for kind in clean_kinds}
    curves = []
    for method in what.methods:
        for kind, group in groups.items():
            if group:
                rows = [flight.right(method) for flight in group]
                curves.append(Curve(method, kind, _proportions(rows)))
        if hijacked:
            claims = [[one is not None for one in f.alarms_ns[method]] for f in hijacked]
            curves.append(Curve(method, CLAIMED, _proportions(claims)))
    return curves, [result for result in results if isinstance(result, Failure)]


def swept(parameters: MonitorParameters, what: Sweep, case: Case) -> SweptFlight:
    """Run one flight at every value.

    Raises:
        ValueError: The flight cannot be read or made; the text names it.
    """
    flight = record_flight(case, parameters)
    kind = class_of(case, flight.attack)
    alarms_ns = {
        method: tuple(
            _first_alarm_ns(verdicts)
            for verdicts in verdicts_at(flight, parameters, method, what.parameter, what.values)
        )
        for method in what.methods
    }
    return SweptFlight(kind, flight.attack, alarms_ns)


def verdicts_at(
    flight: Recorded,
    parameters: MonitorParameters,
    method: str,
    parameter: str,
    values: Sequence[float],
) -> list[list[Verdict]]:
    """Verdicts of a detector on a flight at each value of one of its parameters."""
    part = next(part for part in parameters.parts if part.name == method)
    changed = (parameters.having(method, **{parameter: value}) for value in values)
    return [judge(flight, partial(component_of, part, one[method])) for one in changed]


def csv_text(what: Sweep, curves: Sequence[Curve]) -> str:
    """The curves as a table, one line a value."""
    lines = [f"{what.parameter},method,class,correct,flights,ratio,low95,high95"]
    for curve in curves:
        for value, one in zip(what.values, curve.correct, strict=True):
            figures = f"{one.ratio:.4f},{one.low:.4f},{one.high:.4f}"
            lines.append(f"{value:g},{curve.method},{curve.kind},{one.count},{one.total},{figures}")
    return "\n".join(lines) + "\n"


def _first_alarm_ns(verdicts: Sequence[Verdict]) -> int | None:
    return next((one.stamp_ns for one in verdicts if one.state is State.ALARM), None)


def _proportions(rows: Sequence[Sequence[bool]]) -> tuple[Proportion, ...]:
    return tuple(Proportion.of(sum(column), len(rows)) for column in zip(*rows, strict=True))
