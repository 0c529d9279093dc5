# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A simulated flight obeys the laws that the detectors rely on."""

import math

import numpy as np
import pymap3d
import pytest

from hijack_detect.estimation.rotation import exponential, matrices, multiply
from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.motion import IMU_HZ
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.simulation.vehicle import GRAVITY

FLIGHTS = [("curved", 8), ("straight", 3), ("survey", 0), ("hover", 1)]


@pytest.fixture(scope="module", params=FLIGHTS, ids=str)
def flight(request: pytest.FixtureRequest) -> Flight:
    route, seed = request.param
    return generate_flight(FlightPlan(route=route), seed)


def test_integrated_rates_give_the_attitude(flight: Flight) -> None:
    true = flight.motion.quaternion
    attitude = tuple(true[0].tolist())
    for rate in flight.motion.angular_velocity[1:]:
        attitude = multiply(attitude, exponential(tuple((rate / IMU_HZ).tolist())))
    assert abs(abs(np.dot(attitude, true[-1])) - 1.0) < 1e-9


def test_at_rest_specific_force_is_gravity_upward(flight: Flight) -> None:
    at_rest = flight.motion.specific_force[: 5 * IMU_HZ]
    assert np.allclose(at_rest, [0.0, 0.0, GRAVITY], atol=1e-9)
    assert np.allclose(flight.motion.angular_velocity[: 5 * IMU_HZ], 0.0, atol=1e-12)


def test_specific_force_is_the_acceleration_of_the_position(flight: Flight) -> None:
    """Rᵀ(a - g), with a from the positions by second differences over 10 ms."""
    flying = flight.motion.airborne.argmax() + 100
    position, step = flight.motion.position[flying:], 1.0 / IMU_HZ
    acceleration = (position[2:] - 2.0 * position[1:-1] + position[:-2]) / step**2
    felt = acceleration + np.array([0.0, 0.0, GRAVITY])
    turn = matrices(flight.motion.quaternion[flying:][1:-1])
    off = np.einsum("nji,nj->ni", turn, felt) - flight.motion.specific_force[flying:][1:-1]
    assert np.abs(off).max() < 0.1
    assert np.abs(off.mean(axis=0)).max() < 1e-3


def test_integrated_specific_force_gives_velocity_and_position(flight: Flight) -> None:
    """An ideal inertial navigation loses 0.2 m/s in 100 s to the rate of 100 Hz."""
    motion = flight.motion
    world = np.einsum("nij,nj->ni", matrices(motion.quaternion), motion.specific_force)
    world -= [0.0, 0.0, GRAVITY]
    velocity = np.cumsum(0.5 * (world[1:] + world[:-1]), axis=0) / IMU_HZ
    assert np.abs(velocity - motion.velocity[1:]).max() < 0.2
    moved = np.cumsum(0.5 * (motion.velocity[1:] + motion.velocity[:-1]), axis=0) / IMU_HZ
    assert np.abs(moved - motion.position[1:]).max() < 1e-2


def test_horizontal_specific_force_is_drag(flight: Flight) -> None:
    motion, conditions = flight.motion, flight.conditions
    flying = motion.airborne == 1.0
    flying[: flying.argmax() + 2] = False
    air = (motion.velocity - np.roll(motion.wind, 1, axis=0))[flying]
    drag = conditions.drag + conditions.drag_quadratic * np.linalg.norm(air, axis=1)
    body = np.einsum("nji,nj->ni", matrices(motion.quaternion[flying]), air)
    expected = -drag[:, None] * body[:, :2]
    assert np.abs(motion.specific_force[flying, :2] - expected).max() < 1e-3


def test_gps_velocity_fits_the_positions(flight: Flight) -> None:
    start, end = flight.fixes[150], flight.fixes[450]
    assert [fix.stamp_ns for fix in flight.fixes] == [v.stamp_ns for v in flight.velocities]
    moved = pymap3d.geodetic2enu(
        end.latitude_deg,
        end.longitude_deg,
        end.altitude_m,
        start.latitude_deg,
        start.longitude_deg,
        start.altitude_m,
    )
    between = np.array([v.velocity for v in flight.velocities[150:451]])
    seconds = (end.stamp_ns - start.stamp_ns) / 1e9
    mean = (between[:-1] + between[1:]).mean(axis=0) / 2.0
    assert np.abs(np.array(moved) / seconds - mean).max() < 4.0 / seconds


def test_gps_lags(flight: Flight) -> None:
    """A stamp's velocity is the true one of `gps_lag_s` before: no other lag fits better."""
    time = flight.motion.offsets_ns / 1e9
    arrival = np.array([(v.stamp_ns - flight.plan.start_ns) / 1e9 for v in flight.velocities])
    measured = np.array([v.velocity for v in flight.velocities])
    right = flight.conditions.gps_lag_s
    assert 0.1 <= right <= 0.2

    def misfit(lag: float) -> float:
        true = [np.interp(arrival - lag, time, axis) for axis in flight.motion.velocity.T]
        return float(np.square(measured - np.array(true).T).mean())

    assert misfit(right) == pytest.approx(flight.conditions.velocity_noise_m_s**2, rel=0.15)
    if flight.plan.route != "hover":
        assert min((right - 0.1, right - 0.05, right, right + 0.05), key=misfit) == right


def test_magnetometer_points_to_magnetic_north(flight: Flight) -> None:
    east, north, up = flight.plan.place.field_enu_t
    assert math.degrees(math.atan2(east, north)) == pytest.approx(12.66, abs=0.05)
    measured = np.array([m.field for m in flight.magnetics])
    turned = np.einsum("nij,nj->ni", matrices(flight.motion.quaternion[::10]), measured)
    assert np.abs(turned.mean(axis=0) - [east, north, up]).max() < 2e-6


def test_pressure_falls_with_height(flight: Flight) -> None:
    pascal = [reading.value for reading in flight.pressures]
    fall = np.mean(pascal[:50]) - np.mean(pascal[300:350])
    assert fall / 11.3 == pytest.approx(flight.plan.height_m, abs=3.0)


def test_the_truth_is_where_the_vehicle_was(flight: Flight) -> None:
    place, last = flight.plan.place, flight.truth_fixes[-1]
    moved = pymap3d.geodetic2enu(
        last.latitude_deg,
        last.longitude_deg,
        last.altitude_m,
        place.latitude_deg,
        place.longitude_deg,
        place.altitude_m,
    )
    assert np.allclose(moved, flight.motion.position[-1], atol=1e-3)
    assert np.allclose(flight.truth_attitudes[-1], flight.motion.quaternion[-1], atol=1e-8)
