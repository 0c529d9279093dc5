# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The vehicle conserves what it must, and follows its commands with the lags it claims."""

import math

import numpy as np
import pytest

from hijack_detect.estimation.rotation import from_roll_pitch_yaw, matrix, roll_pitch_yaw
from hijack_detect.simulation.vehicle import (
    GRAVITY,
    TILT_DAMPING,
    TILT_RATE,
    YAW_DAMPING,
    YAW_RATE,
    Multirotor,
)
from hijack_detect.streams.samples import Quaternion, Vector3

STEP_S = 0.005
CALM = (0.0, 0.0, 0.0)
LEVEL = (0.0, 0.0, 0.0, 1.0)
HIGH = (0.0, 0.0, 1000.0)


def airborne(
    drag: float = 0.0,
    attitude: Quaternion = LEVEL,
    velocity: Vector3 = CALM,
    thrust: float = GRAVITY,
    quadratic: float = 0.0,
) -> Multirotor:
    """A vehicle high in the air whose motors already run, with the acceleration of its state."""
    vehicle = Multirotor(drag, quadratic, attitude, HIGH, velocity, thrust=thrust, on_ground=False)
    vehicle.acceleration = vehicle._forces(velocity, CALM)
    return vehicle


def energy(vehicle: Multirotor) -> float:
    """Kinetic and potential energy over mass, m²/s²."""
    return 0.5 * math.hypot(*vehicle.velocity) ** 2 + GRAVITY * vehicle.position[2]


def test_a_free_fall_without_drag_conserves_energy() -> None:
    vehicle = airborne(velocity=(8.0, -3.0, 20.0), thrust=0.0)
    before = energy(vehicle)
    for _ in range(2000):
        vehicle.step(0.0, LEVEL, CALM, STEP_S)
    assert vehicle.position[2] < HIGH[2] - 200.0
    assert energy(vehicle) == pytest.approx(before, rel=1e-12)
    assert vehicle.velocity == pytest.approx((8.0, -3.0, 20.0 - 10.0 * GRAVITY), abs=1e-9)


def test_without_drag_energy_changes_by_the_work_of_the_thrust() -> None:
    vehicle = airborne(velocity=(5.0, 0.0, 0.0))
    before, work = energy(vehicle), 0.0
    for step in range(4000):
        tilt = 0.4 * math.sin(step * STEP_S)
        command = from_roll_pitch_yaw(tilt, -0.5 * tilt, 0.3 * tilt)
        power = np.dot(matrix(vehicle.attitude)[:, 2] * vehicle.thrust, vehicle.velocity)
        vehicle.step(GRAVITY + 3.0 * tilt, command, CALM, STEP_S)
        after = np.dot(matrix(vehicle.attitude)[:, 2] * vehicle.thrust, vehicle.velocity)
        work += 0.5 * float(power + after) * STEP_S
    assert abs(work) > 10.0
    assert energy(vehicle) - before == pytest.approx(work, rel=1e-3)


@pytest.mark.parametrize(("drag", "quadratic"), [(0.25, 0.0), (0.0, 0.05), (0.25, 0.01)])
def test_drag_in_still_air_only_takes_energy_away(drag: float, quadratic: float) -> None:
    vehicle = airborne(drag, velocity=(9.0, 4.0, 0.0), quadratic=quadratic)
    energies = [energy(vehicle)]
    for _ in range(1000):
        vehicle.step(GRAVITY, LEVEL, CALM, STEP_S)
        energies.append(energy(vehicle))
    assert np.all(np.diff(energies) < 0.0)


def test_linear_drag_decays_exponentially() -> None:
    vehicle = airborne(0.25, velocity=(9.0, 0.0, 0.0))
    for _ in range(800):
        vehicle.step(GRAVITY, LEVEL, CALM, STEP_S)
    assert vehicle.velocity[0] == pytest.approx(9.0 * math.exp(-0.25 * 4.0), rel=1e-4)


def test_hover_at_rest_stays_at_rest() -> None:
    vehicle = airborne(0.25)
    for _ in range(2000):
        vehicle.step(GRAVITY, LEVEL, CALM, STEP_S)
    assert vehicle.position == HIGH
    assert vehicle.velocity == CALM
    assert vehicle.specific_force == (0.0, 0.0, GRAVITY)


def test_a_level_vehicle_drifts_off_with_the_wind() -> None:
    vehicle, wind = airborne(0.25), (3.0, -2.0, 0.0)
    for _ in range(8000):
        vehicle.step(GRAVITY, LEVEL, wind, STEP_S)
    assert vehicle.velocity == pytest.approx(wind, abs=1e-3)
    assert vehicle.specific_force == pytest.approx((0.0, 0.0, GRAVITY), abs=1e-3)


@pytest.mark.parametrize("attitude", [LEVEL, from_roll_pitch_yaw(0.05, -0.03, 2.0)])
def test_the_ground_carries_the_vehicle(attitude: Quaternion) -> None:
    vehicle = Multirotor(0.25, 0.0, attitude)
    for _ in range(1000):
        vehicle.step(0.9 * GRAVITY, LEVEL, (5.0, 0.0, 0.0), STEP_S)
    assert vehicle.on_ground
    assert vehicle.position == vehicle.velocity == vehicle.rate == CALM
    assert vehicle.attitude == attitude
    gravity = matrix(attitude).T @ [0.0, 0.0, GRAVITY]
    assert vehicle.specific_force == pytest.approx(gravity.tolist())


def test_it_takes_off_when_thrust_exceeds_weight_and_stops_when_it_falls() -> None:
    vehicle = Multirotor(0.25, 0.0, LEVEL)
    for _ in range(200):
        vehicle.step(1.1 * GRAVITY, LEVEL, CALM, STEP_S)
    assert not vehicle.on_ground
    assert vehicle.position[2] > 0.3
    for _ in range(400):
        vehicle.step(0.5 * GRAVITY, LEVEL, CALM, STEP_S)
    assert vehicle.on_ground
    assert vehicle.position[2] == 0.0


@pytest.mark.parametrize(
    ("axis", "lag_s"),
    [(0, 2.0 * TILT_DAMPING / TILT_RATE), (1, 2.0 * TILT_DAMPING / TILT_RATE),
     (2, 2.0 * YAW_DAMPING / YAW_RATE)],
)  # fmt: skip
def test_each_axis_follows_a_turning_command_with_its_lag(axis: int, lag_s: float) -> None:
    vehicle, rate = airborne(), 0.1
    for step in range(600):
        angles = [0.0, 0.0, 0.0]
        angles[axis] = rate * step * STEP_S
        vehicle.step(GRAVITY, from_roll_pitch_yaw(*angles), CALM, STEP_S)
    lag = (599 * STEP_S * rate - roll_pitch_yaw(vehicle.attitude)[axis]) / rate
    assert lag == pytest.approx(lag_s, abs=0.01)


def test_specific_force_is_acceleration_without_gravity_in_body_axes() -> None:
    attitude = from_roll_pitch_yaw(0.2, -0.3, 1.0)
    vehicle = airborne(0.25, attitude, (6.0, 2.0, -1.0), quadratic=0.01)
    felt = matrix(attitude).T @ (np.array(vehicle.acceleration) + np.array([0.0, 0.0, GRAVITY]))
    assert vehicle.specific_force == pytest.approx(felt.tolist(), abs=1e-12)
