# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Figures over many flights, against numbers worked out by hand or printed elsewhere."""

from __future__ import annotations

import math

import pytest

from hijack_detect.evaluation.scores.methods import Judgement, MethodOutcome
from hijack_detect.evaluation.scores.metrics import (
    FlightOutcome,
    Proportion,
    Rate,
    Spread,
    roc_area,
    roc_curve,
    summarise,
)

J = Judgement


@pytest.mark.parametrize(
    ("count", "total", "low", "high"),
    [
        (50, 50, 0.929, 1.0),  # 0.025 ** (1 / 50)
        (25, 25, 0.863, 1.0),
        (0, 25, 0.0, 0.137),
        (21, 25, 0.639, 0.955),
        (46, 50, 0.808, 0.978),
    ],
)
def test_exact_interval_of_a_proportion(count: int, total: int, low: float, high: float) -> None:
    found = Proportion.of(count, total)
    assert found.ratio == count / total
    assert (found.low, found.high) == pytest.approx((low, high), abs=5e-4)


def test_a_proportion_of_nothing_has_no_interval() -> None:
    assert Proportion.of(0, 0) == Proportion(count=0, total=0, ratio=None, low=None, high=None)


@pytest.mark.parametrize(
    ("events", "upper_events"),
    [(0, -math.log(0.05)), (1, 4.744), (2, 6.296), (10, 16.962)],
)
def test_one_sided_upper_bound_of_a_rate(events: int, upper_events: float) -> None:
    """The bounds are those of any table of the Poisson distribution."""
    found = Rate.of(events, 2.0)
    assert found.per_hour == events / 2.0
    assert found.upper == pytest.approx(upper_events / 2.0, abs=5e-4)


def test_a_rate_over_no_time_is_unknown() -> None:
    assert Rate.of(0, 0.0) == Rate(events=0, hours=0.0, per_hour=None, upper=None)


def test_spread() -> None:
    found = Spread.of([4.0, 1.0, 2.0, 3.0, 5.0])
    assert found == Spread(count=5, median=3.0, p95=4.8, max=5.0)
    assert Spread.of([]) is None


def outcome(
    judgement: Judgement, score: float, late_s: float | None = None, false_alarms: int = 0
) -> MethodOutcome:
    return MethodOutcome(
        judgement=judgement,
        first_alarm_s=None,
        alarms=(),
        false_alarms=false_alarms,
        time_to_detect_s=late_s,
        deviation_m=None if late_s is None else 10.0 * late_s,
        score=score,
    )


def flight(kind: str, found: MethodOutcome, onset_s: float | None = None) -> FlightOutcome:
    return FlightOutcome(
        name="one",
        kind=kind,
        duration_s=1800.0,
        onset_s=onset_s,
        attack_end_s=None,
        methods={"date": found},
    )


def test_summary_of_a_method() -> None:
    flights = [
        flight("straight", outcome(J.QUIET, 0.1)),
        flight("straight", outcome(J.FALSE_ALARM, 3.0, false_alarms=2)),
        flight("curved", outcome(J.QUIET, 0.4)),
        flight("hijacked", outcome(J.DETECTED, 2.0, 1.5), 900.0),
        flight("hijacked", outcome(J.DETECTED, 4.0, 2.5), 900.0),
        flight("hijacked", outcome(J.MISSED, 0.4), 900.0),
        flight("hijacked", outcome(J.EARLY, 5.0, false_alarms=1), 900.0),
        flight("hijacked", outcome(J.LATE, 0.2), 900.0),
    ]
    found = summarise(flights, "date")
    assert {kind: (p.count, p.total) for kind, p in found.correct.items()} == {
        "straight": (1, 2),
        "curved": (1, 1),
        "hijacked": (2, 5),
    }
    assert (found.type_1.count, found.type_1.total) == (1, 3)
    assert (found.type_2.count, found.type_2.total) == (3, 5)
    assert (found.early, found.late) == (1, 1)
    # Three clean flights of half an hour and five quarters of an hour before an onset.
    assert found.false_alarms == Rate.of(3, 2.75)
    assert found.time_to_detect_s == Spread.of([1.5, 2.5])
    assert found.deviation_m == Spread.of([15.0, 25.0])
    # Against 0.1, 0.4 and 3.0: 2.0 wins two pairs, 4.0 and 5.0 three, 0.4 one and a half, 0.2 one.
    assert found.roc_area == pytest.approx((2 + 3 + 1.5 + 3 + 1) / 15)


def test_clean_flights_alone_have_no_detection() -> None:
    found = summarise([flight("curved", outcome(J.QUIET, 0.1))], "date")
    assert found.type_2.ratio is None
    assert found.time_to_detect_s is None
    assert found.roc_area is None


def test_roc_curve_goes_through_every_threshold() -> None:
    false, true = roc_curve([1.0, 2.0], [2.0, 3.0])
    assert list(zip(false.tolist(), true.tolist(), strict=True)) == [
        (0.0, 0.0),
        (0.0, 0.5),
        (0.5, 1.0),
        (1.0, 1.0),
    ]
    assert roc_area([1.0, 2.0], [2.0, 3.0]) == 0.875
    assert roc_area([1.0], [1.0]) == 0.5


def test_the_clean_time_of_an_injected_flight_counts_once() -> None:
    clean = flight("unlabelled", outcome(J.FALSE_ALARM, 3.0, false_alarms=2))
    early = flight("hijacked", outcome(J.EARLY, 5.0, false_alarms=2), 900.0)
    found = summarise([clean, early.model_copy(update={"injected": True})], "date")
    assert found.false_alarms == Rate.of(2, 0.5)
    assert found.early == 1
