"""A simulated flight obeys the laws that the detectors rely on."""

import math

import numpy as np
import pymap3d
import pytest

from hijack_detect.estimation.rotation import exponential, heading, matrices, multiply
from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.kinematics import RATE_HZ, integrate
from hijack_detect.simulation.motion import DRAG, GRAVITY, IMU_HZ, attitudes
from hijack_detect.simulation.plan import FlightPlan, forward_end_s, forward_start_s
from hijack_detect.simulation.sensors import GPS_LAG_S

STEP = RATE_HZ // IMU_HZ


@pytest.fixture(scope="module", params=[("curved", 8), ("straight", 3), ("curved", 0)], ids=str)
def flight(request: pytest.FixtureRequest) -> Flight:
    route, seed = request.param
    return generate_flight(FlightPlan(route=route), seed)


def test_integrated_rates_give_the_attitude(flight: Flight) -> None:
    true = flight.motion.quaternion
    attitude = tuple(true[0].tolist())
    for rate in flight.motion.angular_velocity[1:]:
        attitude = multiply(attitude, exponential(tuple((rate / IMU_HZ).tolist())))
    assert np.abs(np.array(attitude) - true[-1]).max() < 1e-9


def test_at_rest_specific_force_is_gravity_upward(flight: Flight) -> None:
    at_rest = flight.motion.specific_force[: 5 * IMU_HZ]
    assert np.allclose(at_rest, [0.0, 0.0, GRAVITY], atol=1e-9)
    assert np.allclose(flight.motion.angular_velocity[: 5 * IMU_HZ], 0.0, atol=1e-12)


def test_specific_force_is_the_acceleration_of_the_position(flight: Flight) -> None:
    """Rᵀ(a - g), with a from the positions by second differences over 10 ms."""
    position, step = flight.motion.position, 1.0 / IMU_HZ
    acceleration = (position[2:] - 2.0 * position[1:-1] + position[:-2]) / step**2
    felt = acceleration + np.array([0.0, 0.0, GRAVITY])
    turn = matrices(flight.motion.quaternion[1:-1])
    expected = np.einsum("nji,nj->ni", turn, felt)
    assert np.abs(expected - flight.motion.specific_force[1:-1]).max() < 2e-3


def test_horizontal_specific_force_is_drag(flight: Flight) -> None:
    motion = flight.motion
    air = (flight.path.velocity - flight.path.wind)[::STEP] * motion.airborne[:, None]
    drag = -DRAG * np.einsum("nji,nj->ni", matrices(motion.quaternion), air)
    assert np.abs(motion.specific_force[:, :2] - drag[:, :2]).max() < 1e-9


def test_position_is_the_integral_of_the_velocity(flight: Flight) -> None:
    assert np.array_equal(integrate(flight.path.velocity), flight.path.position)
    velocity = flight.motion.velocity
    coarse = (velocity[1:] + velocity[:-1]).sum(axis=0) / (2.0 * IMU_HZ)
    assert np.abs(coarse - flight.path.position[-1]).max() < 1e-3


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
    """A stamp's velocity is the true one of 0.15 s before: no other lag fits better."""
    time = flight.path.time_s
    arrival = np.array([(v.stamp_ns - flight.plan.start_ns) / 1e9 for v in flight.velocities])
    measured = np.array([v.velocity for v in flight.velocities])[5:]

    def misfit(lag: float) -> float:
        true = [np.interp(arrival[5:] - lag, time, axis) for axis in flight.path.velocity.T]
        return float(np.square(measured - np.array(true).T).mean())

    lags = [0.0, 0.05, 0.1, GPS_LAG_S, 0.2, 0.25, 0.3]
    assert min(lags, key=misfit) == GPS_LAG_S
    assert misfit(GPS_LAG_S) == pytest.approx(0.08**2, rel=0.1)


def test_phases_of_the_flight(flight: Flight) -> None:
    plan, motion = flight.plan, flight.motion
    time = motion.offsets_ns / 1e9
    speed = np.hypot(motion.velocity[:, 0], motion.velocity[:, 1])
    hover = (time > forward_start_s(plan) - 8.0) & (time < forward_start_s(plan))
    forward = (time > forward_start_s(plan) + 6.0) & (time < forward_end_s(plan))
    assert np.all(motion.velocity[time < 5.0] == 0.0)
    assert speed[hover].max() < 0.3, "no course in hover"
    assert speed[forward].min() > 7.5
    assert motion.position[:, 2].max() == pytest.approx(plan.height_m, abs=0.5)
    assert speed[-1] < 0.3


def test_nose_follows_course(flight: Flight) -> None:
    velocity = flight.motion.velocity
    fast = np.hypot(velocity[:, 0], velocity[:, 1]) > 5.0
    course = np.arctan2(velocity[fast, 1], velocity[fast, 0])
    yaw = np.array([heading(tuple(q)) for q in flight.motion.quaternion[fast].tolist()])
    difference = [math.remainder(a, math.tau) for a in yaw - course]
    assert np.abs(difference).max() < math.radians(12.0)
    assert np.sqrt(np.square(difference).mean()) < math.radians(5.0)


def test_turns() -> None:
    for seed in range(5):
        course = generate_flight(FlightPlan(route="curved"), seed).path.course
        steps = np.diff(course[:: 2 * RATE_HZ])
        assert (np.abs(steps) > math.radians(25.0)).sum() >= 6
        assert np.ptp(generate_flight(FlightPlan(route="straight"), seed).path.course) == 0.0


def test_attitudes_point_up_and_forward() -> None:
    rng = np.random.default_rng(0)
    up = rng.normal(size=(200, 3)) + np.array([0.0, 0.0, 8.0])
    yaw = rng.uniform(-3.0, 3.0, 200)
    turn = matrices(attitudes(up, yaw))
    assert np.allclose(turn[:, :, 2], up / np.linalg.norm(up, axis=1, keepdims=True))
    assert np.allclose(np.arctan2(turn[:, 1, 0], turn[:, 0, 0]), yaw)


def test_magnetometer_points_to_magnetic_north(flight: Flight) -> None:
    east, north, up = flight.plan.place.field_enu_t
    assert math.degrees(math.atan2(east, north)) == pytest.approx(12.66, abs=0.05)
    measured = np.array([m.field for m in flight.magnetics])
    turned = np.einsum("nij,nj->ni", matrices(flight.motion.quaternion[::10]), measured)
    assert np.abs(turned.mean(axis=0) - [east, north, up]).max() < 2e-6


def test_pressure_falls_with_height(flight: Flight) -> None:
    pascal = [reading.value for reading in flight.pressures]
    fall = np.mean(pascal[:50]) - np.mean(pascal[300:350])
    assert fall / 11.3 == pytest.approx(flight.plan.height_m, abs=2.0)
