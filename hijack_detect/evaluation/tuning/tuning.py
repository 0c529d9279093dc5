# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The baseline procedure of Feng et al. 2018, §5, for one vehicle: fly clean, then adjust.

From clean flights come the GPS's lag, the IMU's noise, and thresholds for a requested rate of
false alarms. What the thresholds are worth is measured on flights that they were not chosen on,
each by the thresholds of all the others, and by attacks: those in the flights, and scenarios
injected into the clean ones.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np

from hijack_detect.evaluation.scores.evaluate import run_case
from hijack_detect.evaluation.scores.metrics import FlightOutcome
from hijack_detect.evaluation.trials.cases import HIJACKED, SETTLED_S, BagCase, Case
from hijack_detect.evaluation.trials.parallel import HERE, Failure, Pool, map_cases
from hijack_detect.evaluation.trials.recorded import Recorded, record
from hijack_detect.evaluation.tuning.noise import ImuNoise, Lag, gps_lag, imu_noise, middle_half
from hijack_detect.evaluation.tuning.thresholds import TUNABLES, Choice, FlightAlarms, Kept, choose
from hijack_detect.monitor.policies import POLICIES, MonitorParameters
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.streams.samples import NANOSECONDS, FixSample

BROKEN_S = 2.0
"""A shorter time without a course does not end forward flight. Chosen, not swept."""


@dataclass(frozen=True)
class Survey:
    """Measurements of a vehicle from a clean flight.

    Attributes:
        name: The flight.
        hours: Its length.
        day: Date (UTC, ISO) of its first stamp.
        lag: The GPS's lag, None if the flight does not show it.
        noise: The IMU's noise, None if it never moved.
        fix_interval_s: Usual time between fixes, seconds.
        onsets_s: For each scenario when to begin it, empty where it does not fit in.
    """

    name: str
    hours: float
    day: str
    lag: Lag | None
    noise: ImuNoise | None
    fix_interval_s: float
    onsets_s: tuple[tuple[float, ...], ...]


def survey(
    parameters: MonitorParameters, scenarios: Sequence[Scenario], attacks: int, case: Case
) -> Survey:
    """Estimate lag and noise on a clean flight, and choose when to attack it.

    Args:
        parameters: Parameters of every part.
        scenarios: What to attack it with.
        attacks: How often, with each scenario.
        case: The flight.

    Raises:
        ValueError: The flight cannot be read, or is not clean; the text names it.
    """
    flight = record(case, parameters)
    if flight.attack is not None:
        raise ValueError(f"{case.name}: has an attack but is not labelled so; label or remove it")
    fixes = [sample.stamp_ns for _, sample in flight.samples if isinstance(sample, FixSample)]
    interval_ns = float(np.median(np.diff(fixes))) if len(fixes) > 1 else 0.0
    return Survey(
        case.name,
        flight.hours,
        str(np.datetime64(flight.start_ns, "ns").astype("datetime64[D]")),
        gps_lag(flight),
        imu_noise(flight),
        interval_ns / NANOSECONDS,
        tuple(attack_onsets_s(flight, case.name, scenario, attacks) for scenario in scenarios),
    )


def attack_onsets_s(
    flight: Recorded, name: str, scenario: Scenario, count: int
) -> tuple[float, ...]:
    """Times in the longest forward flight at which a scenario fits in, seconds.

    They are drawn from a seed made of the flight's name, so that the same flight always gets the
    same attacks. Empty if the vehicle does not fly forward for long enough.
    """
    begin_ns, end_ns = longest_forward(flight)
    first, last = scenario.segments[0], scenario.segments[-1]
    length_s = 0.0 if last.end_s is None else last.end_s - first.start_s
    earliest = (begin_ns - flight.start_ns) / NANOSECONDS + SETTLED_S
    latest = (end_ns - flight.start_ns) / NANOSECONDS - length_s
    if begin_ns == end_ns or latest < earliest:
        return ()
    rng = np.random.default_rng(zlib.crc32(f"{name} {scenario.segments[0].name}".encode()))
    return tuple(round(onset, 1) for onset in rng.uniform(earliest, latest, count).tolist())


def longest_forward(flight: Recorded) -> tuple[int, int]:
    """First and last stamp of the longest time with a course, nanoseconds; equal without any."""
    longest, since_ns, last_ns = (0, 0), 0, 0
    for course in flight.courses:
        if not course.observable:
            continue
        if course.stamp_ns - last_ns > BROKEN_S * NANOSECONDS:
            since_ns = course.stamp_ns
        last_ns = course.stamp_ns
        longest = max(longest, (since_ns, last_ns), key=lambda span: span[1] - span[0])
    return longest


Progress = Callable[[str, int], Callable[[int], None]]
"""Given what is done and to how many flights, returns what takes the number that are done."""

ATTACKS = 20
"""About this many times each scenario is injected, over all flights,"""
MAX_ATTACKS = 5
"""but no more often into one flight. Both chosen, not swept: 0 of 20
missed is at most 17 % (exact, 95 %)."""

ROLES = ("before", "held_out", "attacked_before", "attacked_after")


@dataclass(frozen=True)
class Tuning:
    """The result.

    Attributes:
        given: The policy's parameters.
        parameters: All parameters, the tuned ones in their place.
        surveys: Of each clean flight.
        lag_s: Median lag and the range of the middle half, seconds; None if no flight shows it.
        choices: Threshold by detector, or why it was kept.
        before: The clean flights under the policy's own parameters.
        held_out: Each clean flight under the parameters chosen on all others; empty for one
            flight, which has no others.
        attacked_before: The attacked flights under the policy's own parameters.
        attacked_after: The same under the chosen ones.
        failures: Flights left out.
    """

    given: MonitorParameters
    parameters: MonitorParameters
    surveys: list[Survey]
    lag_s: tuple[float, float, float] | None
    choices: Mapping[str, Choice | Kept]
    before: list[FlightOutcome]
    held_out: list[FlightOutcome]
    attacked_before: list[FlightOutcome]
    attacked_after: list[FlightOutcome]
    failures: list[Failure]

    @property
    def hours(self) -> float:
        """Length of all clean flights."""
        return sum(survey.hours for survey in self.surveys)


@dataclass(frozen=True)
class Trial:
    """A flight, the parameters to run it with, and in which list of the result it belongs."""

    role: str
    case: BagCase
    parameters: MonitorParameters

    @property
    def name(self) -> str:
        """The flight's name."""
        return self.case.name


Item = TypeVar("Item", BagCase, Trial)
Result = TypeVar("Result")


def tune(
    cases: Sequence[BagCase],
    policy: str,
    parameters: MonitorParameters,
    *,
    per_hour: float,
    scenarios: Sequence[Scenario] = (),
    pool: Pool = HERE,
    progress: Progress = lambda text, total: lambda done: None,
) -> Tuning:
    """Tune the parameters of a policy to one vehicle.

    Args:
        cases: Its flights; those of class `hijacked` are attacks, all others must be clean.
        policy: The policy: what it sets on purpose is not overwritten by the estimated lag.
        parameters: Its parameters.
        per_hour: Requested false alarms per hour of each detector.
        scenarios: Attacks to inject into the clean flights.
        pool: Where the flights are run.
        progress: Called at every step.

    Raises:
        ValueError: No clean flight can be read.
    """
    failures: list[Failure] = []

    def each(
        text: str, function: Callable[[Item], Result], items: Sequence[Item], kind: type[Result]
    ) -> list[tuple[Item, Result]]:
        done = progress(text, len(items))
        results = map_cases(function, items, pool=pool, kind=kind, on_done=done)
        failures.extend(result for result in results if isinstance(result, Failure))
        return [
            (item, result)
            for item, result in zip(items, results, strict=True)
            if not isinstance(result, Failure)
        ]

    clean = [case for case in cases if case.kind != HIJACKED]
    attacks = min(MAX_ATTACKS, math.ceil(ATTACKS / max(len(clean), 1)))
    look = partial(survey, parameters, tuple(scenarios), attacks)
    surveyed = each("lag and noise", look, clean, Survey)
    surveys = [one for _, one in surveyed]
    if not surveys:
        reasons = "".join(f"\n{failure.name}: {failure.reason}" for failure in failures)
        raise ValueError(f"no clean flight to tune on{reasons}")
    lags = [one.lag.seconds for one in surveys if one.lag is not None]
    lag_s = middle_half(lags) if lags else None
    interval_s = float(np.median([one.fix_interval_s for one in surveys]))
    lagged = with_lag(parameters, policy, lag_s[0], interval_s) if lag_s else parameters

    counted = each(
        "alarms", partial(count_alarms, lagged), [case for case, _ in surveyed], FlightAlarms
    )
    alarms = [one for _, one in counted]
    choices = {name: choose(TUNABLES[name], name, alarms, per_hour) for name in TUNABLES}
    chosen = with_choices(lagged, choices)

    trials = [Trial("before", case, parameters) for case, _ in surveyed]
    for index, (case, _) in enumerate(counted):
        others = alarms[:index] + alarms[index + 1 :]
        if others:
            own = {name: choose(TUNABLES[name], name, others, per_hour) for name in TUNABLES}
            trials.append(Trial("held_out", case, with_choices(lagged, own)))
    attacked = [case for case in cases if case.kind == HIJACKED]
    attacked += [attack for case, one in surveyed for attack in injected(case, scenarios, one)]
    trials += [Trial("attacked_before", case, parameters) for case in attacked]
    trials += [Trial("attacked_after", case, chosen) for case in attacked]
    outcomes: dict[str, list[FlightOutcome]] = {role: [] for role in ROLES}
    for trial, outcome in each("judging", run_trial, trials, FlightOutcome):
        outcomes[trial.role].append(outcome)
    unread = list({failure.name: failure for failure in failures}.values())
    return Tuning(parameters, chosen, surveys, lag_s, choices, failures=unread, **outcomes)


def run_trial(trial: Trial) -> FlightOutcome:
    """Run and judge one flight, see `run_case`."""
    return run_case(trial.parameters, trial.case)


def injected(case: BagCase, scenarios: Sequence[Scenario], found: Survey) -> Iterator[BagCase]:
    """A clean flight with each scenario put into it at each of its times."""
    for scenario, onsets_s in zip(scenarios, found.onsets_s, strict=True):
        for onset_s in onsets_s:
            name = f"{case.name} + {scenario.segments[0].name} at {onset_s:g} s"
            yield replace(case, name=name, kind=HIJACKED, scenario=scenario.moved_to(onset_s))


def count_alarms(parameters: MonitorParameters, case: BagCase) -> FlightAlarms:
    """Run every detector over a clean flight at every threshold that can be chosen.

    Raises:
        ValueError: The flight cannot be read; the text names it.
    """
    flight = record(case, parameters)
    alarms = {
        name: tunable.count(flight, parameters, tunable.values)
        for name, tunable in TUNABLES.items()
    }
    return FlightAlarms(case.name, flight.hours, alarms)


def with_lag(
    parameters: MonitorParameters, policy: str, lag_s: float, fix_interval_s: float
) -> MonitorParameters:
    """The parameters with a GPS lag, but for those that the policy sets on purpose.

    A course lags by an interval between fixes more: half of it lies between the two fixes that
    it comes from, and for half of it, on average, it is held.
    """
    lags = {
        "attitude": {"gps_lag_s": round(lag_s, 3)},
        "date": {"gps_lag_s": round(lag_s, 3)},
        "correlation": {"course_lag_s": round(lag_s + fix_interval_s, 3)},
    }
    for part in parameters.parts:
        on_purpose = POLICIES[policy].get(part.node, {})
        free = {k: v for k, v in lags.get(part.name, {}).items() if k not in on_purpose}
        parameters = parameters.having(part.name, **free)
    return parameters


def with_choices(
    parameters: MonitorParameters, choices: Mapping[str, Choice | Kept]
) -> MonitorParameters:
    """The parameters with the chosen thresholds."""
    for name, choice in choices.items():
        if isinstance(choice, Choice):
            parameters = TUNABLES[name].put(parameters, choice.value)
    return parameters
