# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Alerts an hour at risk, against numbers that are known from elsewhere."""

from __future__ import annotations

import pytest

from hijack_detect.evaluation.scores.watch import FlightWatch, GroupWatch, RateInterval, TimedCause


@pytest.mark.parametrize(
    ("events", "low", "high"),
    [(0, 0.0, 3.689), (1, 0.0253, 5.572), (16, 9.145, 25.983), (100, 81.364, 121.627)],
)
def test_exact_interval_of_a_rate(events: int, low: float, high: float) -> None:
    """The bounds are those of any table of the Poisson distribution (Garwood 1936)."""
    found = RateInterval.of(events, 2.0)
    assert found.per_hour == events / 2.0
    assert (found.low, found.high) == pytest.approx((low / 2.0, high / 2.0), abs=5e-4)
    assert RateInterval.of(events, 0.0).per_hour is None


def watched(at_risk_s: float, alarms: int, *, counted: bool = True) -> FlightWatch:
    causes = tuple(TimedCause(at_s=float(n), cause="coast") for n in range(alarms))
    return FlightWatch(
        counted=counted,
        in_air_s=1800.0,
        at_risk_s=at_risk_s,
        open_s=1800.0,
        told_s={"coast": at_risk_s / 2.0},
        carry_off_s=at_risk_s / 2.0,
        first=causes[0] if causes else None,
        alarms=causes,
        not_judged=None,
        visible=None,
    )


def test_flights_are_summed_up_and_faults_of_unknown_time_are_left_out() -> None:
    found = GroupWatch.of(
        [watched(1800.0, 0), watched(1800.0, 3), watched(900.0, 2, counted=False)]
    )
    assert found.flights == 3
    assert (found.first.events, found.first.hours) == (1, 1.0)
    assert (found.alarms.events, found.alarms.hours) == (3, 1.0)
    assert found.told == {"coast": 0.5}
    assert found.carry_off == 0.5
    assert GroupWatch.of([]).carry_off is None
