# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Choosing a detector's threshold from its alarms on clean flights (Feng et al. 2018, §5).

The paper's baseline test is to fly clean, run the method offline and adjust its thresholds.
Here an alarm is a state of the detector, persistence included, and not a peak of its score.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TypeAlias

import numpy as np

from hijack_detect.detectors.correlation import CorrelationDetector, CorrelationParameters
from hijack_detect.detectors.date import DateDetector, DateParameters
from hijack_detect.detectors.persistence import Persistence
from hijack_detect.detectors.verdict import JUDGED, Verdict
from hijack_detect.evaluation.scores.metrics import Rate
from hijack_detect.evaluation.trials.recorded import Recorded, judge
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.truth import detector_outcome

Counted: TypeAlias = Callable[[Recorded, MonitorParameters, Sequence[float]], "Alarms"]

SMALLEST_FACTOR = 1.25
"""Chosen, not swept; as the rule of docs/detection-limits.md."""
FEW_FLIGHTS_FACTOR = 1.7
"""Where there are too few flights to measure the factor: a threshold from one half of a set of
flights alarmed on the other half until it was raised by this much."""
MIN_FLIGHTS = 6
"""Two halves of three: fewer do not measure a factor. Chosen, not swept."""
SPLITS = 400
"""Chosen, not swept."""
SPLIT_SEED = 0
MIN_JUDGED_S = 60.0
"""A detector that could tell for less time than this over all flights keeps its threshold.
Chosen, not swept."""


@dataclass(frozen=True)
class Alarms:
    """Alarms of one detector on a clean flight.

    Attributes:
        judged_s: Seconds in which it could tell.
        counts: Times that it went into ALARM, for each threshold of a grid.
    """

    judged_s: float
    counts: tuple[int, ...]


@dataclass(frozen=True)
class Tunable:
    """A threshold to choose: the larger, the fewer alarms.

    Attributes:
        part: Name of the part.
        name: The parameter.
        unit: Its unit.
        values: What can be tried, ascending.
        useful: The largest value with which the method still is one.
        count: Runs the detector over a flight at each of some values.
        also: What else is set with it: a threshold of the vehicle's own replaces one that is
            learnt in flight.
    """

    part: str
    name: str
    unit: str
    values: tuple[float, ...]
    useful: float
    count: Counted
    also: Mapping[str, float] = field(default_factory=dict)

    def of(self, parameters: MonitorParameters) -> float:
        """Its value in a set of parameters."""
        return float(getattr(parameters[self.part], self.name))

    def put(self, parameters: MonitorParameters, value: float) -> MonitorParameters:
        """The parameters with another value of it."""
        return parameters.having(self.part, **{self.name: value, **self.also})


def correlation_alarms(
    recorded: Recorded, parameters: MonitorParameters, values: Sequence[float]
) -> Alarms:
    """Alarms of the correlation at several μ.

    The detector is run again for each: what it takes for the crab angle depends on its state.
    """
    counts, judged_s = [], 0.0
    for value in values:
        chosen = dataclasses.replace(parameters.of(CorrelationParameters), mu_deg=value)
        verdicts = judge(recorded, partial(CorrelationDetector, chosen))
        counts.append(detector_outcome(verdicts, None).false_alarms)
        judged_s = _judged_s(verdicts)
    return Alarms(judged_s, tuple(counts))


def date_alarms(
    recorded: Recorded, parameters: MonitorParameters, values: Sequence[float]
) -> Alarms:
    """Alarms of DATE at several thresholds; its score does not depend on its threshold."""
    given = parameters.of(DateParameters)
    plain = dataclasses.replace(given, noise_gain=0.0)
    verdicts = judge(recorded, partial(DateDetector, plain))
    counts = [
        detector_outcome(at_threshold(verdicts, value, given.persist_s), None) for value in values
    ]
    return Alarms(_judged_s(verdicts), tuple(outcome.false_alarms for outcome in counts))


def at_threshold(verdicts: Sequence[Verdict], threshold: float, persist_s: float) -> list[Verdict]:
    """Verdicts of a detector at another threshold, where its score does not depend on it."""
    persistence = Persistence(persist_s)
    judged = []
    for verdict in verdicts:
        state = verdict.state
        if state in JUDGED:
            state = persistence.state(verdict.stamp_ns, verdict.score > threshold)
        else:
            persistence.reset()
        judged.append(dataclasses.replace(verdict, state=state, threshold=threshold))
    return judged


def _judged_s(verdicts: Sequence[Verdict]) -> float:
    """Seconds in which the GPS was judged, by the usual time between verdicts."""
    if len(verdicts) < 2:
        return 0.0
    step = float(np.median(np.diff([verdict.stamp_ns for verdict in verdicts]))) / 1e9
    return step * sum(verdict.state in JUDGED for verdict in verdicts)


MU_DEG = (5.0, 7.5, 10.0, 12.5, 15.0, 17.5, 20.0, 25.0, 30.0, 35.0, 40.0, 50.0, 60.0, 75.0, 90.0)
DATE_STEP = 1.05
"""Ratio of neighbouring thresholds. Chosen: fine beside SMALLEST_FACTOR."""

TUNABLES: Mapping[str, Tunable] = {
    "correlation": Tunable(
        "correlation", "mu_deg", "°", (*MU_DEG, 120.0, 150.0, 180.0), 45.0, correlation_alarms
    ),
    "date": Tunable(
        "date",
        "threshold",
        "m/s²",
        tuple(round(0.2 * DATE_STEP**step, 3) for step in range(112)),
        50.0,
        date_alarms,
        {"noise_gain": 0.0},
    ),
}
"""Thresholds by detector."""


@dataclass(frozen=True)
class FlightAlarms:
    """A clean flight: its length, and the alarms of each detector."""

    name: str
    hours: float
    alarms: Mapping[str, Alarms]


@dataclass(frozen=True)
class Choice:
    """A threshold and how it came about.

    Attributes:
        value: The threshold.
        quiet: The smallest one that keeps to the rate on these flights.
        factor: Safety factor between the two, 1 where the flights are long enough to show that
            the rate is kept.
        judged_hours: Time in which the detector could tell.
    """

    value: float
    quiet: float
    factor: float
    judged_hours: float


@dataclass(frozen=True)
class Kept:
    """A threshold that is left as it was, and why."""

    reason: str


def choose(
    tunable: Tunable, detector: str, flights: Sequence[FlightAlarms], per_hour: float
) -> Choice | Kept:
    """Choose a threshold for a rate of false alarms.

    With T hours of flight the exact 95 % upper bound of the rate is at least 3/T. A requested
    rate above that is shown: the smallest threshold is taken whose bound is below it. A smaller
    rate cannot be shown: then the smallest threshold without any alarm is taken, times a safety
    factor, see `safety_factor`.

    The threshold is kept if the detector could hardly ever tell, or if it would have to be so
    large that the method is none any more: then the method does not suit this way of flying, and
    the fusion must not rely on it.
    """
    judged_s = sum(flight.alarms[detector].judged_s for flight in flights)
    if judged_s < MIN_JUDGED_S:
        return Kept(f"it could tell for {judged_s:.0f} s only")
    hours = sum(flight.hours for flight in flights)
    shown = (Rate.of(0, hours).upper or math.inf) <= per_hour

    def kept(index: int) -> bool:
        events = sum(flight.alarms[detector].counts[index] for flight in flights)
        return (Rate.of(events, hours).upper or math.inf) <= per_hour if shown else events == 0

    quiet = _first_kept(tunable, kept)
    factor = 1.0 if shown else safety_factor(tunable, detector, flights)
    value = math.inf if quiet is None else _rounded_up(quiet * factor)
    if quiet is None or value > tunable.useful:
        loudest = max(flights, key=lambda flight: _quiet(tunable, flight.alarms[detector].counts))
        least = tunable.values[-1] if quiet is None else quiet
        return Kept(
            f"the rate would take more than {tunable.useful:g} {tunable.unit}: quiet from "
            f"{least:.3g} on, loudest is {loudest.name}"
        )
    return Choice(value, quiet, factor, judged_s / 3600.0)


def _first_kept(tunable: Tunable, kept: Callable[[int], bool]) -> float | None:
    """The smallest value that keeps to the rate, as all larger ones do."""
    found = None
    for index in reversed(range(len(tunable.values))):
        if not kept(index):
            break
        found = tunable.values[index]
    return found


def safety_factor(tunable: Tunable, detector: str, flights: Sequence[FlightAlarms]) -> float:
    """Factor by which a threshold must grow to keep quiet on flights that it was not chosen on.

    The flights are split in halves at random, many times. The quantile of 95 % of the ratio of
    the halves' smallest quiet thresholds is the factor by which a threshold from one half
    would have had to be raised for the other half. It never is below SMALLEST_FACTOR.
    """
    quiet = [_quiet(tunable, flight.alarms[detector].counts) for flight in flights]
    if len(quiet) < MIN_FLIGHTS:
        return FEW_FLIGHTS_FACTOR
    rng, half = np.random.default_rng(SPLIT_SEED), len(quiet) // 2
    orders = [rng.permutation(quiet) for _ in range(SPLITS)]
    ratios = [max(order[half:]) / max(order[:half]) for order in orders]
    return max(SMALLEST_FACTOR, round(float(np.percentile(ratios, 95.0)), 2))


def _quiet(tunable: Tunable, counts: Sequence[int]) -> float:
    """The smallest value from which on one flight is without alarm."""
    found = _first_kept(tunable, lambda index: not counts[index])
    return tunable.values[-1] if found is None else found


def _rounded_up(value: float) -> float:
    """Two significant digits, never below the value."""
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return round(math.ceil(value / step - 1e-9) * step, 6)
