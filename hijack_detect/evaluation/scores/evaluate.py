# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Runs methods on many flights and sums up how good they were."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from hijack_detect import __version__
from hijack_detect.analysis.account import Account
from hijack_detect.analysis.log_clock import LogClock
from hijack_detect.evaluation.scores.forged import ForgedData, ForgingTime, forging_times
from hijack_detect.evaluation.scores.methods import judge_case, with_baselines
from hijack_detect.evaluation.scores.metrics import FlightOutcome, MethodSummary, summarise
from hijack_detect.evaluation.scores.model import Model
from hijack_detect.evaluation.scores.watch import FlightWatch, GroupWatch, watch
from hijack_detect.evaluation.trials.cases import BagCase, Case, class_of
from hijack_detect.evaluation.trials.corpus import corpus_cases
from hijack_detect.evaluation.trials.parallel import HERE, Failure, Pool, map_cases
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.streams.samples import NANOSECONDS, Sample

FAULT = "natural_fault"
"""Class of flights whose receiver fails by itself: an alert is right from some time on."""
ALL = "all"
"""All classes together."""


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
        by_class: How the flights were watched while they were clean, by class, and `all` of them:
            clean ones whole, hijacked ones until the attack. Flights with an injected attack are
            not in it: they are judged as clean ones too.
        by_vehicle: The same by vehicle, where those are known.
        forging: The time that forging takes, where that was asked for.
    """

    version: str
    source: str
    policy: str
    methods: dict[str, MethodSummary]
    flights: list[FlightOutcome]
    failed: list[FailedFlight]
    by_class: dict[str, GroupWatch]
    by_vehicle: dict[str, GroupWatch]
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
    parameters = with_baselines(parameters, published_kld=forging)
    clock = LogClock()
    account = Account(parameters.detectors, parameters.fusion, 0, clock)

    def take(sample: Sample) -> None:
        account.take(sample)
        if forging:
            data.add(sample)

    done = case.run(parameters, on_sample=take, on_output=account.take_output, clock=clock)
    attack, start_ns = done.attack, done.run.start_ns
    kind = class_of(case, attack)

    def seconds(stamp_ns: int) -> float:
        return (stamp_ns - start_ns) / NANOSECONDS

    end_ns = None if attack is None else attack.end_ns
    label = case.label if isinstance(case, BagCase) else None
    clean_until_ns = None if attack is None else attack.onset_ns
    if label is not None and label.alert_ok_from_s is not None:
        fails_ns = start_ns + round(label.alert_ok_from_s * NANOSECONDS)
        clean_until_ns = fails_ns if clean_until_ns is None else min(fails_ns, clean_until_ns)
    return FlightOutcome(
        name=case.name,
        kind=kind,
        duration_s=seconds(done.end_ns),
        onset_s=None if attack is None else seconds(attack.onset_ns),
        attack_end_s=None if end_ns is None else seconds(end_ns),
        methods=judge_case(done, parameters.fusion),
        injected=case.injected,
        forged=data.quality(attack) if forging else None,
        vehicle="" if label is None else label.vehicle,
        watch=None
        if case.injected
        else watch(
            account,
            start_ns,
            max(done.end_ns, account.newest_ns),
            clean_until_ns,
            counted=kind != FAULT or clean_until_ns is not None,
        ),
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
    watched = [(flight, flight.watch) for flight in flights if flight.watch is not None]
    kinds: dict[str, list[FlightWatch]] = defaultdict(list)
    vehicles: dict[str, list[FlightWatch]] = defaultdict(list)
    for flight, one in watched:
        kinds[flight.kind].append(one)
        if flight.vehicle:
            vehicles[flight.vehicle].append(one)
    if watched:
        kinds[ALL] = [one for _, one in watched]
    return Evaluation(
        version=__version__,
        source=source,
        policy=policy,
        methods={name: summarise(flights, name) for name in names},
        flights=flights,
        failed=failed,
        forging=forging_times() if forging else None,
        by_class={kind: GroupWatch.of(some) for kind, some in kinds.items()},
        by_vehicle={name: GroupWatch.of(vehicles[name]) for name in sorted(vehicles)},
    )


def evaluate_folder(
    folder: str | Path,
    parameters: MonitorParameters | None = None,
    attack: Scenario | None = None,
    *,
    onsets: int = 5,
    jobs: int = 1,
) -> Evaluation:
    """Run every flight below a folder and sum up, as `hijack-detect evaluate` does.

    Args:
        folder: Bags and logs, with `labels.json` or `label.json` where something is known of them.
        parameters: Parameters of every part, those of policy `default` if None.
        attack: An attack to put into each clean flight.
        onsets: At how many places, spread by chance (the same each time) over its forward flight.
        jobs: Processes.

    Raises:
        BagError: There is no flight, or a label cannot be used.
    """
    cases = corpus_cases(Path(folder), attack, 0 if attack is None else onsets)
    parameters = parameters or MonitorParameters()
    policy = parameters.fusion.policy
    return evaluate(cases, parameters, source=str(folder), policy=policy, pool=Pool(jobs))
