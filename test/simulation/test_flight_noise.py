# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The sensors of a simulated flight are as bad as real ones, and the same for the same seed."""

import numpy as np
import pytest

from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.noise import gauss_markov, random_walk
from hijack_detect.simulation.plan import FlightPlan

PLAN = FlightPlan(route="curved", duration_s=70.0)
SENSORS = ("imu", "fixes", "velocities", "satellites", "magnetics", "pressures")


@pytest.fixture(scope="module")
def flights() -> list[Flight]:
    return [generate_flight(PLAN, seed) for seed in range(20)]


def test_same_seed_same_flight() -> None:
    first, second, other = (generate_flight(PLAN, seed) for seed in (7, 7, 8))
    for name in SENSORS:
        assert getattr(first, name) == getattr(second, name)
        assert getattr(first, name) != getattr(other, name)
    assert first.truth_attitudes == second.truth_attitudes
    assert np.array_equal(first.motion.position, second.motion.position)


def test_rates() -> None:
    flight = generate_flight(PLAN, 1)
    assert len(flight.imu) == 7001
    assert len(flight.fixes) == len(flight.velocities) == len(flight.satellites) == 349
    assert len(flight.magnetics) == len(flight.pressures) == len(flight.truth_fixes) == 701
    assert all(4 <= sample.count <= 25 for sample in flight.satellites)


def test_an_honest_receiver_reports_what_it_measures() -> None:
    flight = generate_flight(PLAN, 1)
    assert flight.fixes == flight.measured_fixes


def test_imu_errors(flights: list[Flight]) -> None:
    errors = []
    for flight in flights:
        measured = np.array([sample.angular_velocity for sample in flight.imu])
        errors.append((measured - flight.motion.angular_velocity).mean(axis=0))
        felt = np.array([sample.specific_force for sample in flight.imu])
        noise = (felt - flight.motion.specific_force)[3000:].std(axis=0)
        assert np.all((noise > 0.05) & (noise < 0.3))
    assert np.degrees(np.std(errors)) == pytest.approx(0.3, rel=0.3)


def test_the_gyro_bias_wanders_in_flight_but_not_on_the_ground(flights: list[Flight]) -> None:
    moved, rested = [], []
    for flight in flights:
        measured = np.array([sample.angular_velocity for sample in flight.imu])
        error = np.degrees(measured - flight.motion.angular_velocity)
        moved.append(error[6000:].mean(axis=0) - error[1500:2500].mean(axis=0))
        rested.append(error[300:550].mean(axis=0) - error[1:250].mean(axis=0))
    assert 0.02 < np.std(moved) < 0.08
    assert np.std(rested) < 0.01


def test_position_noise_is_correlated(flights: list[Flight]) -> None:
    values, steps = [], []
    for flight in flights:
        north = np.array([fix.latitude_deg for fix in flight.fixes[:25]]) * 111_000.0
        values.append(north[0] + 35.363 * 111_000.0)
        steps.append(np.diff(north).std())
    assert 0.3 < np.std(values) < 0.8
    assert np.mean(steps) < 0.12


def test_seeds_are_a_population(flights: list[Flight]) -> None:
    conditions = [flight.conditions for flight in flights]
    for name, spread in (
        ("speed", 0.5), ("wind_m_s", 1.0), ("wind_direction", 1.0), ("gps_lag_s", 0.02),
        ("drag", 0.015), ("fix_noise_m", 0.05), ("velocity_noise_m_s", 0.01), ("vibration", 0.2),
        ("imu_noise", 0.15),
    ):  # fmt: skip
        assert np.std([getattr(one, name) for one in conditions]) > spread, name


def test_what_is_asked_for_changes_nothing_else() -> None:
    drawn = generate_flight(PLAN, 3).conditions
    asked = generate_flight(FlightPlan("curved", 70.0, speed=5.0, wind_m_s=0.0), 3).conditions
    assert (asked.speed, asked.wind_m_s, asked.gust_m_s) == (5.0, 0.0, 0.0)
    assert (asked.gps_lag_s, asked.drag, asked.wind_direction) == (
        drawn.gps_lag_s, drawn.drag, drawn.wind_direction
    )  # fmt: skip


def test_gauss_markov_noise_has_its_deviation_and_its_memory() -> None:
    noise = gauss_markov(np.random.default_rng(1).normal(size=(20_000, 3)), 2.0, 10.0)
    assert np.allclose(noise.std(axis=0), 1.0, atol=0.1)
    again = [np.corrcoef(column[:-20], column[20:])[0, 1] for column in noise.T]
    assert np.allclose(again, np.exp(-1.0), atol=0.08)


def test_a_random_walk_grows_with_the_root_of_time() -> None:
    white = np.random.default_rng(1).normal(size=(1001, 500))
    walk = random_walk(white, 0.2, 10.0)
    assert np.all(walk[0] == 0.0)
    assert walk[-1].std() == pytest.approx(0.2 * np.sqrt(100.0), rel=0.1)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"route": "loop"}, "route is 'loop'"),
        ({"duration_s": 59.0}, "duration is 59.0"),
        ({"duration_s": float("nan")}, "duration is nan"),
        ({"speed": 0.0}, "speed is 0.0"),
        ({"height_m": 121.0}, "height is 121.0"),
        ({"wind_m_s": -1.0}, "wind is -1.0"),
        ({"start_ns": -1}, "start is -1"),
        ({"duration_s": 60.0, "height_m": 100.0}, "less than 20 s for the route"),
    ],
)
def test_plans_that_cannot_be_flown(change: dict[str, object], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        FlightPlan(**change)  # type: ignore[arg-type]


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(ValueError, match="seed is -1"):
        generate_flight(PLAN, -1)
