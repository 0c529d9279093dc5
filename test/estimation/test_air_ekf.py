# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The filter that feels the air: against flights in closed form with a known wind and drag."""

from __future__ import annotations

import itertools
import math

import numpy as np
import numpy.typing as npt
import pytest
from filter_start import AIR, ERRORS, LEVEL, NOISE, SIGMAS, hover

from hijack_detect.estimation.air_ekf import DRAG, SIZE, TILT, WIND, AirEkf
from hijack_detect.estimation.drag_filter import FIRST_RESIDUAL, FIRST_WIND, SMALLEST_DRAG
from hijack_detect.estimation.ekf import (
    ACCEL_BIAS,
    ATTITUDE,
    GRAVITY,
    VELOCITY,
    ImuBlock,
    Observation,
    Source,
)
from hijack_detect.estimation.kalman import Innovation
from hijack_detect.estimation.lag_ekf import LagEkf, Measured
from hijack_detect.estimation.rotation import exponential, matrix, multiply
from hijack_detect.estimation.velocity_error import VelocityNoise

Array = npt.NDArray[np.float64]
SIZES, RATES = np.array([20.0, 10.0, 0.0]), np.array([0.4, 0.8, 0.0])
"""A figure of eight: metres and rad/s."""
WALKED = np.array([-3.0, 2.0])
"""The wind, m/s."""
K, Q = 0.3, 0.01
RECEIVER = VelocityNoise()


def make(*, heading_sigma: float = 0.2, receiver: VelocityNoise = RECEIVER) -> AirEkf:
    sigmas = SIGMAS.copy()
    sigmas[8] = heading_sigma
    ekf = AirEkf(LEVEL, sigmas, NOISE, ERRORS, AIR, receiver)
    ekf.velocity = velocity(0.0)
    return ekf


def velocity(t: float) -> Array:
    made: Array = SIZES * RATES * np.cos(RATES * t)
    return made


def attitude(t: float, turn_rate: float = 0.3) -> tuple[float, float, float, float]:
    """The attitude of a vehicle whose thrust makes up for drag, gravity and acceleration.

    Its x and y axes then feel nothing but drag, which is what the model says.
    """
    heading = exponential((0.0, 0.0, turn_rate * t))
    felt = -SIZES * RATES**2 * np.sin(RATES * t) + [0.0, 0.0, GRAVITY]
    through = velocity(t) - [*WALKED, 0.0]
    q = heading
    for _ in range(6):  # the tilt decides the drag along the axes, and drag the tilt
        body = matrix(q).T
        air = (body @ through)[:2]
        speed = math.hypot(*air)
        pull = -(K + Q * speed) * air
        thrust = felt - body.T @ np.append(pull, 0.0)
        up = body @ (thrust / np.linalg.norm(thrust))
        turn = np.cross([0.0, 0.0, 1.0], up)
        q = multiply(q, exponential((turn[0], turn[1], turn[2])))
    return q


def fly(ekf: AirEkf, seconds: float, seed: int = 1) -> None:
    rng = np.random.default_rng(seed)
    dt = 0.02
    ekf.attitude = attitude(0.0)
    after = matrix(ekf.attitude)
    for step in range(round(seconds / 0.2)):
        rates, forces = [], []
        for k in range(10):
            t = 0.2 * step + dt * k
            before, after = after, matrix(attitude(t + dt))
            turned = before.T @ after
            rates.append([turned[2, 1], turned[0, 2], turned[1, 0]] / np.array(dt))
            middle = t + 0.5 * dt
            felt = -SIZES * RATES**2 * np.sin(RATES * middle) + [0.0, 0.0, GRAVITY]
            forces.append(0.5 * (before + after).T @ felt)
        noise = 0.05 * rng.normal(size=(10, 3))
        ekf.propagate(ImuBlock(np.full(10, dt), np.array(rates), np.array(forces) + noise))
        t = 0.2 * (step + 1)
        position = SIZES * np.sin(RATES * t) + 0.3 * rng.normal(size=3)
        ekf.update(ekf.gps(Source.POSITION, position, np.full(3, 0.49)))
        told = velocity(t) + 0.05 * rng.normal(size=3)
        ekf.update(ekf.gps(Source.VELOCITY, told, np.full(3, 0.01)))


def test_wind_and_drag_are_learnt_and_the_deviations_are_right() -> None:
    ekf = make()
    fly(ekf, 60.0)
    np.testing.assert_allclose(ekf.wind, WALKED, atol=0.8)
    speed = 8.0
    assert ekf.drag @ [1.0, speed] == pytest.approx(K + Q * speed, rel=0.1)
    assert ekf.residual < FIRST_RESIDUAL
    deviation = np.sqrt(np.diag(ekf.covariance))
    assert np.all(np.abs(ekf.wind - WALKED) < 4.0 * deviation[WIND])
    assert np.all(deviation[WIND] < 0.25 * FIRST_WIND)
    assert np.all(np.abs(ekf.tilt) < 4.0 * deviation[TILT])


def test_the_observation_is_the_derivative_of_the_force() -> None:
    """Each state moved a little changes what is expected as the matrix says."""
    rng = np.random.default_rng(4)
    block = ImuBlock(np.full(20, 0.01), np.zeros((20, 3)), np.tile([1.0, -2.0, 9.0], (20, 1)))

    def flown(moved: Array) -> Innovation:
        ekf = make()
        ekf.velocity = np.array([6.0, -3.0, 1.0])
        ekf.attitude = exponential((0.2, -0.1, 0.7))
        ekf.wind, ekf.drag = np.array([2.0, 1.0]), np.array([0.3, 0.02])
        ekf.propagate(block)
        ekf._inject(moved)
        vague = np.zeros(3), np.full(3, 1e12)
        ekf.update(Observation(Source.VELOCITY, np.eye(SIZE)[VELOCITY], *vague))
        last = ekf.steps[-1]
        assert isinstance(last, Measured)
        assert last.source is Source.DRAG
        return last.innovation

    zero = flown(np.zeros(SIZE))
    for state in [*range(3, 11), *range(17, SIZE)]:
        moved = np.zeros(SIZE)
        moved[state] = 1e-5 * rng.choice([-1.0, 1.0])
        shown = flown(moved).residual - zero.residual
        np.testing.assert_allclose(shown / moved[state], -zero.H[:, state], atol=2e-3)
    others = [*range(3), 11, *range(12, 17)]
    np.testing.assert_array_equal(zero.H[:, others], 0.0)
    assert np.all(zero.H[:, [VELOCITY.start, ATTITUDE.start, ACCEL_BIAS.start]].any(axis=0))


def measures(ekf: AirEkf) -> int:
    """How often drag was used."""
    return sum(isinstance(step, Measured) and step.source is Source.DRAG for step in ekf.steps)


def still(ekf: AirEkf, seconds: float) -> None:
    n = round(seconds / 0.05)
    force = np.tile([0.0, 0.0, GRAVITY], (n, 1))
    ekf.propagate(ImuBlock(np.full(n, 0.05), np.zeros((n, 3)), force))
    ekf.update(ekf.gps(Source.VELOCITY, np.zeros(3), np.full(3, 0.01)))


def test_drag_is_used_once_for_a_gps_velocity() -> None:
    ekf = make()
    for _ in range(5):
        still(ekf, 0.2)
        ekf.update(ekf.gps(Source.POSITION, np.zeros(3), np.full(3, 0.49)))
    assert measures(ekf) == 5


def test_velocities_in_quick_succession_share_one_mean() -> None:
    ekf = make()
    for _ in range(8):
        still(ekf, 0.1)
    assert measures(ekf) == 4


def test_a_force_over_a_gap_is_not_used() -> None:
    ekf = make()
    still(ekf, 5.0)
    assert measures(ekf) == 0
    still(ekf, 0.2)
    assert measures(ekf) == 1


def test_without_a_heading_a_wind_has_no_direction() -> None:
    ekf = make(heading_sigma=1.0)
    ekf.velocity = np.zeros(3)
    for _ in range(5):
        still(ekf, 0.2)
    assert measures(ekf) == 0
    np.testing.assert_array_equal(ekf.wind, 0.0)


def test_a_force_that_no_drag_explains_is_trusted_less() -> None:
    """A fixed wing: sideslip and thrust along x and y. The filter is nearly that without air."""
    rng = np.random.default_rng(6)
    white = VelocityNoise(sigma=0.0, worst=1.0)
    feeling, plain = make(receiver=white), LagEkf(LEVEL, SIGMAS, NOISE, ERRORS)
    plain.velocity = feeling.velocity
    for _ in range(300):
        force = np.tile([0.0, 0.0, GRAVITY], (10, 1)) + 2.0 * np.append(rng.normal(size=2), 0.0)
        block = ImuBlock(np.full(10, 0.02), np.zeros((10, 3)), force)
        gps = 0.1 * rng.normal(size=3)
        for ekf in (feeling, plain):
            ekf.propagate(block)
            ekf.update(ekf.gps(Source.VELOCITY, gps, np.full(3, 0.01)))
    assert feeling.residual > 1.0
    sigma = math.sqrt(plain.covariance[VELOCITY, VELOCITY][0, 0])
    np.testing.assert_allclose(feeling.velocity, plain.velocity, atol=sigma)


def test_drag_never_falls_below_the_smallest() -> None:
    ekf = make()
    error = np.zeros(SIZE)
    error[DRAG] = (-5.0, -5.0)
    ekf._inject(error)
    np.testing.assert_array_equal(ekf.drag, [SMALLEST_DRAG, 0.0])


@pytest.mark.parametrize(("velocities", "tilts"), [(True, False), (False, True)])
def test_a_fix_that_jumps_beside_a_steady_velocity_does_not_tilt(
    velocities: bool, tilts: bool
) -> None:
    """6 m for 5 s, and back; alone, fixes have to be believed."""
    flown = hover(
        RECEIVER,
        350,
        lambda step: 6.0 if 300 <= step < 325 else 0.0,
        (lambda _: 0.0) if velocities else None,
    )
    most = max(2.0 * math.hypot(*ekf.attitude[:2]) for ekf in itertools.islice(flown, 300, None))
    assert (most > math.radians(1.0)) is tilts
