# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Lag and noise, where they are known."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from ros import ROOT

from hijack_detect.evaluation.trials.cases import BagCase, SimulatedCase
from hijack_detect.evaluation.trials.recorded import Recorded, record
from hijack_detect.evaluation.tuning.noise import gps_lag, imu_noise, middle_half
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.simulation.flight import generate_flight
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.streams.samples import AttitudeSample, VelocitySample

STEP_NS = 20_000_000
LEVEL = (0.0, 0.0, 0.0, 1.0)


@lru_cache
def simulated(route: str, seed: int) -> Recorded:
    case = SimulatedCase("flight", route, FlightPlan(route, 80.0), seed)
    return record(case, policy_parameters("default"))


def shaken(accel: float, gyro: float, speed: float = 5.0, seconds: int = 30) -> Recorded:
    """A recording with white noise of known deviation."""
    rng = np.random.default_rng(3)
    samples: list[tuple[str, AttitudeSample | VelocitySample]] = []
    for index in range(seconds * 50):
        stamp = 1 + index * STEP_NS
        turn, felt = (gyro * rng.normal(size=3)).tolist(), (accel * rng.normal(size=3)).tolist()
        felt[2] += 9.8
        if index % 10 == 0:
            samples.append(("velocity", VelocitySample(stamp, (speed, 0.0, 0.0))))
        samples.append(("attitude", AttitudeSample(stamp, LEVEL, 0.0, tuple(turn), tuple(felt))))
    return Recorded(samples, None, 0, seconds * 50 * STEP_NS)


@pytest.mark.parametrize("seed", [1, 2])
def test_the_lag_of_a_simulated_receiver_is_found(seed: int) -> None:
    known = generate_flight(FlightPlan("curved", 80.0), seed).conditions.gps_lag_s
    lag = gps_lag(simulated("curved", seed))
    assert lag is not None
    assert lag.seconds == pytest.approx(known, abs=0.04)
    assert lag.contrast > 1.0


def test_a_flight_that_does_not_accelerate_says_nothing_of_its_lag() -> None:
    assert gps_lag(shaken(0.5, 0.01)) is None


def test_without_gps_velocity_the_lag_is_unknown() -> None:
    case = BagCase(ROOT / "bags/curved_no_velocity_5", "bag", "curved")
    flight = record(case, policy_parameters("default"))
    assert gps_lag(flight) is None
    assert imu_noise(flight) is None


def test_white_noise_is_told_as_a_density() -> None:
    noise = imu_noise(shaken(0.5, 0.01))
    assert noise is not None
    root_s = (STEP_NS / 1e9) ** 0.5
    assert noise.accel == pytest.approx(0.5 * root_s, rel=0.05)
    assert noise.gyro == pytest.approx(0.01 * root_s, rel=0.05)


def test_one_shock_changes_nothing() -> None:
    flight = shaken(0.5, 0.01)
    index = len(flight.samples) // 2 + 1
    name, hit = flight.samples[index]
    assert isinstance(hit, AttitudeSample)
    shock = AttitudeSample(hit.stamp_ns, LEVEL, 0.0, (9.0, 0.0, 0.0), (90.0, 0.0, 9.8))
    flight.samples[index] = (name, shock)
    noise, calm = imu_noise(flight), imu_noise(shaken(0.5, 0.01))
    assert noise is not None and calm is not None
    assert noise.accel == pytest.approx(calm.accel, rel=0.02)
    assert noise.gyro == pytest.approx(calm.gyro, rel=0.02)


def test_what_never_moves_has_no_noise_in_flight() -> None:
    assert imu_noise(shaken(0.5, 0.01, speed=0.0)) is None
    assert imu_noise(Recorded([], None, 0, 1)) is None
    assert gps_lag(Recorded([], None, 0, 1)) is None


def test_one_odd_flight_does_not_move_the_middle() -> None:
    assert middle_half([0.1, 0.15, 0.2, 9.0, 0.12]) == pytest.approx((0.15, 0.12, 0.2))
