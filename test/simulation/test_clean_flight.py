# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A flight with an honest GPS goes where its plan says, as a multirotor goes there."""

import math

import numpy as np
import pytest

from hijack_detect.estimation.rotation import heading
from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.motion import IMU_HZ
from hijack_detect.simulation.plan import ROUTES, FlightPlan
from hijack_detect.simulation.route import RATE_HZ

SEEDS = range(4)


def errors(flight: Flight) -> np.ndarray:
    """Distance from the plan at each of its rows in flight, metres."""
    off = flight.motion.position[:: IMU_HZ // RATE_HZ] - flight.route.position
    return np.linalg.norm(off, axis=1)[10 * RATE_HZ :]


def nose_off_course(flight: Flight) -> np.ndarray:
    """Heading less course where the vehicle is fast, radians."""
    velocity = flight.motion.velocity[::10]
    fast = np.hypot(velocity[:, 0], velocity[:, 1]) > 5.0
    course = np.arctan2(velocity[fast, 1], velocity[fast, 0])
    yaw = np.array([heading(tuple(q)) for q in flight.motion.quaternion[::10][fast].tolist()])
    return np.array([math.remainder(a, math.tau) for a in yaw - course])


@pytest.mark.parametrize("route", ROUTES)
def test_it_follows_its_plan_within_two_metres_in_wind(route: str) -> None:
    for seed in SEEDS:
        found = errors(generate_flight(FlightPlan(route, wind_m_s=4.0), seed))
        assert np.sqrt(np.square(found).mean()) < 2.0
        assert found.max() < 4.0


def test_the_error_is_that_of_the_gps_not_of_the_control() -> None:
    """What is left once the correlated noise of the fixes is taken away is small."""
    for seed in SEEDS:
        flight = generate_flight(FlightPlan("straight", wind_m_s=4.0), seed)
        off = (flight.motion.position - flight.motion.target)[30 * IMU_HZ : 95 * IMU_HZ]
        assert np.all(off.std(axis=0) < 0.7)


@pytest.mark.parametrize("route", ["straight", "curved", "survey"])
def test_the_nose_follows_the_course(route: str) -> None:
    for seed in SEEDS:
        off = nose_off_course(generate_flight(FlightPlan(route), seed))
        assert np.abs(off).max() < math.radians(15.0)
        assert np.sqrt(np.square(off).mean()) < math.radians(7.0)


def test_with_a_fixed_yaw_it_does_not() -> None:
    for seed in SEEDS:
        flight = generate_flight(FlightPlan("fixed_yaw"), seed)
        yaw = np.array([heading(tuple(q)) for q in flight.motion.quaternion[::10].tolist()])
        assert np.abs(np.angle(np.exp(1j * (yaw - yaw[0])))).max() < math.radians(7.0)
        assert np.abs(nose_off_course(flight)).max() > math.radians(40.0)


@pytest.mark.parametrize("seed", SEEDS)
def test_phases_of_the_flight(seed: int) -> None:
    flight = generate_flight(FlightPlan("curved"), seed)
    motion, cruise = flight.motion, flight.conditions.speed
    time = motion.offsets_ns / 1e9
    speed = np.hypot(motion.velocity[:, 0], motion.velocity[:, 1])
    hover = (time > flight.forward_start_s - 4.0) & (time < flight.forward_start_s)
    forward = (time > flight.forward_start_s + 7.0) & (time < flight.forward_end_s)
    assert np.all(motion.velocity[time < 6.0] == 0.0)
    assert np.all(motion.airborne[time > 9.0] == 1.0)
    assert speed[hover].max() < 0.5, "no course in hover"
    assert np.abs(speed[forward] - cruise).max() < 1.5
    assert np.abs(motion.position[forward, 2] - 20.0).max() < 3.5
    assert speed[-1] < 0.5


def test_a_stronger_wind_tilts_the_vehicle_more() -> None:
    tilts = []
    for wind in (0.0, 4.0, 8.0):
        motion = generate_flight(FlightPlan("hover", wind_m_s=wind), 2).motion
        x, y, _, _ = motion.quaternion[40 * IMU_HZ : 90 * IMU_HZ].T
        tilts.append(math.degrees(np.arccos(1.0 - 2.0 * (x * x + y * y)).mean()))
    assert tilts[0] < 1.5
    assert 4.0 < tilts[1] < 9.0
    assert 8.0 < tilts[2] < 18.0
