# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Scores of a method on many flights, with intervals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.stats import binomtest, chi2, rankdata

from hijack_detect.evaluation.scores.forged import ForgedValues
from hijack_detect.evaluation.scores.methods import Judgement, MethodOutcome
from hijack_detect.evaluation.scores.model import Model
from hijack_detect.evaluation.scores.watch import FlightWatch

Curve = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]


def roc_area(clean: Sequence[float], hijacked: Sequence[float]) -> float | None:
    """Probability that a hijacked flight has the higher score, ties count half.

    It is the statistic of Mann and Whitney over the number of pairs; None without flights of
    both sorts.
    """
    pairs = len(clean) * len(hijacked)
    if not pairs:
        return None
    ranks = rankdata(np.concatenate([hijacked, clean]))[: len(hijacked)]
    return float(ranks.sum() - len(hijacked) * (len(hijacked) + 1) / 2) / pairs


def roc_curve(clean: Sequence[float], hijacked: Sequence[float]) -> Curve:
    """Parts of the clean and of the hijacked flights at or above each threshold, from 0 to 1.

    Both lists must have an element.
    """
    thresholds = np.unique(np.concatenate([clean, hijacked]))[::-1]
    parts = [
        np.mean(np.asarray(scores)[:, np.newaxis] >= thresholds, axis=0)
        for scores in (clean, hijacked)
    ]
    false, true = (np.concatenate([[0.0], part]) for part in parts)
    return false, true


LEVEL = 0.95
"""Confidence of intervals: the convention of the field."""


class FlightOutcome(Model):
    """One flight and what every method did on it; times in seconds from its first message.

    Attributes:
        name: The flight's name.
        kind: Its class, `hijacked` if it was attacked.
        duration_s: Its length.
        onset_s: First spoofed fix, None for a clean flight.
        attack_end_s: End of the attack, None if it lasts to the end or the flight is clean.
        methods: Outcomes by method.
        injected: Whether it is a recorded flight with an attack put in. The flight itself is
            judged too, and its clean time counts there.
        forged: The quality of the forged data by parameter, where that was asked for.
        vehicle: Name of its vehicle, empty if that is not known.
        watch: How it was watched while it was clean.
    """

    name: str
    kind: str
    duration_s: float
    onset_s: float | None
    attack_end_s: float | None
    methods: dict[str, MethodOutcome]
    injected: bool = False
    forged: dict[str, ForgedValues] | None = None
    vehicle: str = ""
    watch: FlightWatch | None = None

    @property
    def clean_s(self) -> float:
        """Seconds without attack: all of a clean flight, a hijacked one until the onset."""
        if self.injected:
            return 0.0
        return self.duration_s if self.onset_s is None else self.onset_s


class Proportion(Model):
    """A part of a number of flights with its exact (Clopper-Pearson) 95 % interval."""

    count: int
    total: int
    ratio: float | None
    low: float | None
    high: float | None

    @classmethod
    def of(cls, count: int, total: int) -> Proportion:
        """Make one; without any flight there is neither ratio nor interval."""
        if total == 0:
            return cls(count=count, total=0, ratio=None, low=None, high=None)
        interval = binomtest(count, total).proportion_ci(LEVEL, method="exact")
        low, high = float(interval.low), float(interval.high)
        return cls(count=count, total=total, ratio=count / total, low=low, high=high)


class Rate(Model):
    """Events per hour with the exact (Poisson) one-sided 95 % upper bound.

    Without an event the bound is -ln(0.05) = 3.0 per observed time, the "rule of three".
    """

    events: int
    hours: float
    per_hour: float | None
    upper: float | None

    @classmethod
    def of(cls, events: int, hours: float) -> Rate:
        """Make one; without any time there is no rate."""
        if hours <= 0.0:
            return cls(events=events, hours=0.0, per_hour=None, upper=None)
        upper = float(chi2.ppf(LEVEL, 2 * (events + 1))) / 2.0 / hours
        return cls(events=events, hours=hours, per_hour=events / hours, upper=upper)


class Spread(Model):
    """Median, 95th percentile (linear between observations) and maximum."""

    count: int
    median: float
    p95: float
    max: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread | None:
        """Make one, None without values."""
        if not values:
            return None
        median, p95 = np.percentile(values, [50.0, 95.0]).tolist()
        return cls(count=len(values), median=median, p95=p95, max=max(values))


class MethodSummary(Model):
    """One method over all flights.

    Attributes:
        correct: Correct flights by class, see `Judgement.correct`.
        type_1: Clean flights with an alarm.
        type_2: Hijacked flights without a first alarm in the attack.
        early: Those of `type_2` where it came before the onset, which are false alarms too.
        late: Those of `type_2` where it came after the attack.
        false_alarms: Episodes of alarms per hour of clean time.
        time_to_detect_s: Seconds from onset to first alarm, over detected flights.
        deviation_m: Metres between true and reported position then, over the detected flights
            whose true position is known.
        roc_area: Area under the ROC curve, None unless there are clean and hijacked flights.
    """

    correct: dict[str, Proportion]
    type_1: Proportion
    type_2: Proportion
    early: int
    late: int
    false_alarms: Rate
    time_to_detect_s: Spread | None
    deviation_m: Spread | None
    roc_area: float | None

    @property
    def detected(self) -> Proportion:
        """Hijacked flights with a first alarm in the attack: those that are not of `type_2`."""
        return Proportion.of(self.type_2.total - self.type_2.count, self.type_2.total)


def summarise(flights: Sequence[FlightOutcome], method: str) -> MethodSummary:
    """Sum up one method over flights; classes are in the order in which they come up."""
    outcomes = [(flight, flight.methods[method]) for flight in flights]
    clean = [outcome for flight, outcome in outcomes if flight.onset_s is None]
    hijacked = [outcome for flight, outcome in outcomes if flight.onset_s is not None]
    counts = {judgement: _count(hijacked, judgement) for judgement in Judgement}
    return MethodSummary(
        correct={
            kind: _correct([outcome for flight, outcome in outcomes if flight.kind == kind])
            for kind in dict.fromkeys(flight.kind for flight in flights)
        },
        type_1=Proportion.of(_count(clean, Judgement.FALSE_ALARM), len(clean)),
        type_2=Proportion.of(len(hijacked) - counts[Judgement.DETECTED], len(hijacked)),
        early=counts[Judgement.EARLY],
        late=counts[Judgement.LATE],
        false_alarms=Rate.of(
            sum(outcome.false_alarms for flight, outcome in outcomes if not flight.injected),
            sum(flight.clean_s for flight in flights) / 3600.0,
        ),
        time_to_detect_s=Spread.of(
            [o.time_to_detect_s for o in hijacked if o.time_to_detect_s is not None]
        ),
        deviation_m=Spread.of([o.deviation_m for o in hijacked if o.deviation_m is not None]),
        roc_area=roc_area([o.score for o in clean], [o.score for o in hijacked]),
    )


def _correct(outcomes: Sequence[MethodOutcome]) -> Proportion:
    right = sum(outcome.judgement.correct for outcome in outcomes)
    return Proportion.of(right, len(outcomes))


def _count(outcomes: Sequence[MethodOutcome], judgement: Judgement) -> int:
    return sum(outcome.judgement is judgement for outcome in outcomes)
