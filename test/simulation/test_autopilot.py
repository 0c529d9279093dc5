# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The autopilot points its thrust where it must, waits for a vehicle, and knows its limits."""

import math

import numpy as np
import pytest

from hijack_detect.estimation.rotation import matrices
from hijack_detect.simulation.autopilot import LEASH_M, MAX_TILT, Autopilot, pointing
from hijack_detect.simulation.route import RATE_HZ, Route
from hijack_detect.simulation.vehicle import GRAVITY
from hijack_detect.streams.samples import Vector3

STILL: Vector3 = (0.0, 0.0, 0.0)


def ahead(speed: float = 8.0, yaw: float = 0.0, seconds: float = 60.0) -> Autopilot:
    """An autopilot with a straight route to the East at constant speed."""
    count = round(seconds * RATE_HZ)
    velocity = np.tile([speed, 0.0, 0.0], (count, 1))
    position = np.arange(count)[:, None] * velocity / RATE_HZ
    row = np.zeros(count)
    return Autopilot(Route(position, velocity, np.zeros((count, 3)), row, row + yaw), 0.0)


def test_attitudes_point_up_and_forward() -> None:
    rng = np.random.default_rng(0)
    up = rng.normal(size=(200, 3)) + np.array([0.0, 0.0, 8.0])
    yaw = rng.uniform(-3.0, 3.0, 200)
    made = [pointing(tuple(one), angle) for one, angle in zip(up.tolist(), yaw, strict=True)]
    turn = matrices(np.array(made))
    assert np.allclose(turn[:, :, 2], up / np.linalg.norm(up, axis=1, keepdims=True))
    assert np.allclose(np.arctan2(turn[:, 1, 0], turn[:, 0, 0]), yaw)


def test_on_the_target_it_carries_the_weight_and_no_more() -> None:
    command = ahead(0.0).command(STILL, STILL, flying=True)
    assert command.thrust == pytest.approx(GRAVITY)
    assert command.attitude == pytest.approx((0.0, 0.0, 0.0, 1.0))


@pytest.mark.parametrize("error", [(300.0, 0.0, 0.0), (0.0, -300.0, 0.0), (50.0, 50.0, 90.0)])
def test_no_error_asks_for_more_than_the_largest_tilt(error: Vector3) -> None:
    autopilot = ahead(0.0)
    for _ in range(500):
        command = autopilot.command(error, error, flying=True)
    up = matrices(np.array([command.attitude]))[0, 2, 2]
    assert math.acos(up) < MAX_TILT + 1e-6
    assert 0.4 * GRAVITY < command.thrust < 2.0 * GRAVITY


def test_the_target_waits_for_a_vehicle_that_falls_behind() -> None:
    autopilot = ahead(8.0)
    for _ in range(20 * RATE_HZ):
        autopilot.command(STILL, STILL, flying=True)
    assert LEASH_M / 2.0 < autopilot.target[0] < LEASH_M


def test_the_integral_does_not_wind_up_on_the_ground() -> None:
    waiting = ahead(0.0)
    for _ in range(500):
        waiting.command((1.0, 0.0, 0.0), STILL, flying=False)
    fresh = ahead(0.0).command(STILL, STILL, flying=True)
    assert waiting.command(STILL, STILL, flying=True) == fresh


def test_the_nose_turns_no_faster_than_a_vehicle_can() -> None:
    autopilot = ahead(0.0, yaw=0.0)
    autopilot._yaws = [2.0] * len(autopilot._yaws)
    headings = []
    for _ in range(3 * RATE_HZ):
        _, _, z, w = autopilot.command(STILL, STILL, flying=True).attitude
        headings.append(2.0 * math.atan2(z, w))
    assert np.diff(headings).max() * RATE_HZ == pytest.approx(math.radians(60.0), rel=1e-6)
    assert headings[-1] == pytest.approx(2.0)
