# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Alerts an hour at risk, against numbers that are known from elsewhere."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_bags import START_NS, raw, write

from hijack_detect.evaluation.scores.evaluate import run_case
from hijack_detect.evaluation.scores.watch import FlightWatch, GroupWatch, RateInterval, TimedCause
from hijack_detect.evaluation.trials.cases import BagCase
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.streams.samples import NANOSECONDS, FixSample, ImuSample, Sample


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


@pytest.mark.parametrize("set_back_s", [0, 3600])
def test_alerts_are_within_the_log_where_its_clock_was_set_back(
    tmp_path: Path, set_back_s: int
) -> None:
    """At 4 s; without an IMU from 8 s on nothing says that it stands, and it jumps at 20 s."""
    messages = []
    for step in range(30 * 20):
        log_ns = START_NS + step * NANOSECONDS // 20
        stamp_ns = log_ns - (set_back_s * NANOSECONDS if step > 80 else 0)
        if step < 160:
            imu: Sample = ImuSample(stamp_ns, (0.0, 0.0, 0.0), (0.0, 0.0, 9.8))
            messages.append(raw("/imu/data_raw", imu, log_ns))
        if step % 4 == 0:
            fix = FixSample(stamp_ns, 48.0 + 1e-8 * step + 0.01 * (step >= 400), 11.0, 500.0)
            messages.append(raw("/gps/fix", fix, log_ns))
    case = BagCase(write(tmp_path / "bag", messages), "bag", "clean")
    found = run_case(policy_parameters("default"), case).watch
    assert found is not None
    assert found.first is not None
    assert found.first.at_s == pytest.approx(20.3, abs=0.3)
    assert all(20.0 <= one.at_s <= 30.0 for one in found.alarms)
