# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Runs methods on many flights and sums up how good they were."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from hijack_detect import __version__
from hijack_detect.evaluation.monitor.graph import MonitorParameters
from hijack_detect.evaluation.scores.forged import ForgedData
from hijack_detect.evaluation.scores.forging_time import ForgingTime, forging_times
from hijack_detect.evaluation.scores.methods import BASELINES, FAITHFUL_KLD, judge_case
from hijack_detect.evaluation.scores.metrics import FlightOutcome, MethodSummary, summarise
from hijack_detect.evaluation.scores.model import Model
from hijack_detect.evaluation.trials.cases import Case, class_of
from hijack_detect.evaluation.trials.parallel import HERE, Failure, Pool, map_cases
from hijack_detect.streams.samples import NANOSECONDS


class FailedFlight(Model):
    """A flight that could not be run."""

    name: str
    reason: str


class Evaluation(Model):
    """Every method on every flight.

    Attributes:
        version: Version of hijack_detect.
        source: Folder or protocol of the flights.
        policy: Policy or parameter file.
        methods: Summaries by method.
        flights: Outcomes of every flight, in order.
        failed: Flights that could not be run; they are in no other number.
        forging: The time that forging takes, where that was asked for.
    """

    version: str
    source: str
    policy: str
    methods: dict[str, MethodSummary]
    flights: list[FlightOutcome]
    failed: list[FailedFlight]
    forging: list[ForgingTime] | None = None


def run_case(parameters: MonitorParameters, case: Case, *, forging: bool = False) -> FlightOutcome:
    """Run one flight through the monitor and judge every method.

    Args:
        parameters: Parameters of every part.
        case: The flight.
        forging: Judge the quality of the forged data and the published KLD too.

    Raises:
        ValueError: The flight cannot be read or made; the text names it.
    """
    data = ForgedData()
    if forging:
        done = case.run(parameters, baselines={**BASELINES, **FAITHFUL_KLD}, on_sample=data.add)
    else:
        done = case.run(parameters, baselines=BASELINES)
    attack, start_ns = done.attack, done.run.start_ns
    kind = class_of(case, attack)

    def seconds(stamp_ns: int) -> float:
        return (stamp_ns - start_ns) / NANOSECONDS

    end_ns = None if attack is None else attack.end_ns
    return FlightOutcome(
        name=case.name,
        kind=kind,
        duration_s=seconds(done.end_ns),
        onset_s=None if attack is None else seconds(attack.onset_ns),
        attack_end_s=None if end_ns is None else seconds(end_ns),
        methods=judge_case(done, parameters.fusion),
        injected=case.injected,
        forged=data.quality(attack) if forging else None,
    )


def run_cases(
    cases: Sequence[Case],
    parameters: MonitorParameters,
    *,
    forging: bool = False,
    pool: Pool = HERE,
    on_done: Callable[[int], None] | None = None,
) -> list[FlightOutcome | Failure]:
    """Run flights, see `run_case` and `map_cases`."""
    run = partial(run_case, parameters, forging=forging)
    return map_cases(run, cases, pool=pool, kind=FlightOutcome, on_done=on_done)


def evaluate(
    cases: Sequence[Case],
    parameters: MonitorParameters,
    *,
    source: str,
    policy: str,
    forging: bool = False,
    pool: Pool = HERE,
    on_done: Callable[[int], None] | None = None,
) -> Evaluation:
    """Run flights and sum up.

    Args:
        cases: The flights.
        parameters: Parameters of every part.
        source: Where the flights come from, for the record.
        policy: Where the parameters come from, for the record.
        forging: See `run_case`.
        pool: Where the flights are run.
        on_done: Called after each flight with the number of flights that are done.
    """
    results = run_cases(cases, parameters, forging=forging, pool=pool, on_done=on_done)
    flights = [result for result in results if isinstance(result, FlightOutcome)]
    failed = [
        FailedFlight(name=result.name, reason=result.reason)
        for result in results
        if isinstance(result, Failure)
    ]
    names = flights[0].methods if flights else ()
    return Evaluation(
        version=__version__,
        source=source,
        policy=policy,
        methods={name: summarise(flights, name) for name in names},
        flights=flights,
        failed=failed,
        forging=forging_times() if forging else None,
    )
