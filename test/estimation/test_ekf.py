# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The 15-state filter against numerical derivatives, the textbook and simulated truth."""

import copy
import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from hijack_detect.estimation.ekf import GRAVITY, Ekf, ImuBlock, Observation, ProcessNoise, Source

Array = npt.NDArray[np.float64]
QUIET = ProcessNoise(0.0, 0.0, 0.0, 0.0)
NOISE = ProcessNoise(accel=0.1, gyro=0.003, accel_bias=0.005, gyro_bias=0.0007)


def random_block(rng: np.random.Generator, count: int = 20) -> ImuBlock:
    """A tenth to a fifth of a second of hard manoeuvre, intervals of unequal length."""
    rate = rng.normal(0.0, 1.0, 3) + rng.normal(0.0, 0.3, (count, 3))
    force = np.array([0.0, 0.0, GRAVITY]) + rng.normal(0.0, 3.0, 3) + rng.normal(size=(count, 3))
    return ImuBlock(rng.uniform(0.005, 0.01, count), rate, force)


def random_filter(rng: np.random.Generator, noise: ProcessNoise = QUIET) -> Ekf:
    q = Rotation.random(random_state=np.random.RandomState(int(rng.integers(1000)))).as_quat()
    ekf = Ekf(tuple(q.tolist()), np.ones(15), noise)
    ekf.position, ekf.velocity = rng.normal(size=3), rng.normal(0.0, 5.0, 3)
    ekf.accel_bias, ekf.gyro_bias = rng.normal(0.0, 0.1, 3), rng.normal(0.0, 0.01, 3)
    return ekf


def random_covariance(rng: np.random.Generator) -> Array:
    root = rng.normal(size=(15, 15))
    covariance: Array = 1e-4 * (root @ root.T + np.eye(15))
    return covariance


def displaced(ekf: Ekf, error: Array) -> Ekf:
    """The filter whose state is the given one plus an error, as the module defines it."""
    other = copy.deepcopy(ekf)
    other.position = ekf.position + error[0:3]
    other.velocity = ekf.velocity + error[3:6]
    turned = Rotation.from_rotvec(error[6:9]) * Rotation.from_quat(ekf.attitude)
    other.attitude = tuple(turned.as_quat().tolist())
    other.accel_bias = ekf.accel_bias + error[9:12]
    other.gyro_bias = ekf.gyro_bias + error[12:15]
    return other


def error_between(true: Ekf, estimate: Ekf) -> Array:
    turned = Rotation.from_quat(true.attitude) * Rotation.from_quat(estimate.attitude).inv()
    return np.concatenate(
        [
            true.position - estimate.position,
            true.velocity - estimate.velocity,
            turned.as_rotvec(),
            true.accel_bias - estimate.accel_bias,
            true.gyro_bias - estimate.gyro_bias,
        ]
    )


def numerical_transition(ekf: Ekf, block: ImuBlock) -> Array:
    """How the state after the block depends on each error before it, by central differences."""
    after = copy.deepcopy(ekf)
    after.propagate(block)
    columns = []
    for index in range(15):
        step = np.zeros(15)
        step[index] = 1e-5
        ends = []
        for sign in (1.0, -1.0):
            other = displaced(ekf, sign * step)
            other.propagate(block)
            ends.append(error_between(other, after))
        columns.append((ends[0] - ends[1]) / 2e-5)
    return np.array(columns).T


@pytest.mark.parametrize("seed", range(5))
def test_the_transition_of_a_block_is_the_derivative_of_its_propagation(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ekf, block = random_filter(rng), random_block(rng)
    jacobian = numerical_transition(ekf, block)
    for vector in [*np.eye(15), *rng.normal(size=(10, 15))]:
        one = copy.deepcopy(ekf)
        one.covariance = np.outer(vector, vector)
        one.propagate(block)
        expected = np.outer(jacobian @ vector, jacobian @ vector)
        np.testing.assert_allclose(one.covariance, expected, atol=3e-4 * np.max(abs(expected)))


def test_the_process_noise_of_a_block_is_the_integral_of_its_densities() -> None:
    """Level and at rest, against Van Loan's integral of the linear system."""
    f = np.zeros((15, 15))
    f[0:3, 3:6] = np.eye(3)
    q = np.zeros((15, 15))
    q[3:6, 3:6] = NOISE.accel**2 * np.eye(3)
    q[9:12, 9:12] = NOISE.accel_bias**2 * np.eye(3)
    q[12:15, 12:15] = NOISE.gyro_bias**2 * np.eye(3)
    q[6:9, 6:9] = NOISE.gyro**2 * np.eye(3)
    total = 0.2
    loan = expm(np.block([[-f, q], [np.zeros((15, 15)), f.T]]) * total)
    expected = loan[15:, 15:].T @ loan[:15, 15:]

    ekf = Ekf((0.0, 0.0, 0.0, 1.0), np.zeros(15), NOISE)
    still = np.tile([0.0, 0.0, GRAVITY], (20, 1))
    ekf.propagate(ImuBlock(np.full(20, 0.01), np.zeros((20, 3)), still))
    np.testing.assert_allclose(ekf.covariance, expected, atol=1e-12)


def test_propagation_at_constant_rate_and_force_is_exact_motion() -> None:
    """Free fall sideways: f = 0 leaves gravity alone; then a turn at constant rate."""
    ekf = Ekf((0.0, 0.0, 0.0, 1.0), np.ones(15), QUIET)
    ekf.velocity = np.array([3.0, 0.0, 0.0])
    block = ImuBlock(np.full(100, 0.01), np.tile([0.1, 0.2, 0.3], (100, 1)), np.zeros((100, 3)))
    ekf.propagate(block)
    np.testing.assert_allclose(ekf.velocity, [3.0, 0.0, -GRAVITY], atol=1e-9)
    np.testing.assert_allclose(ekf.position, [3.0, 0.0, -GRAVITY / 2], atol=1e-9)
    expected = Rotation.from_rotvec([0.1, 0.2, 0.3])
    assert (Rotation.from_quat(ekf.attitude) * expected.inv()).magnitude() < 1e-9


def test_biases_are_taken_off_the_readings() -> None:
    ekf = Ekf((0.0, 0.0, 0.0, 1.0), np.ones(15), QUIET)
    ekf.accel_bias, ekf.gyro_bias = np.array([0.1, -0.2, 0.3]), np.array([0.01, 0.02, -0.03])
    force = np.array([0.0, 0.0, GRAVITY]) + ekf.accel_bias
    ekf.propagate(ImuBlock(np.array([1.0]), ekf.gyro_bias[None, :], force[None, :]))
    np.testing.assert_allclose(ekf.position, np.zeros(3), atol=1e-12)
    np.testing.assert_allclose(ekf.attitude, (0.0, 0.0, 0.0, 1.0), atol=1e-12)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 1000), st.integers(1, 19))
def test_splitting_a_block_gives_the_same_state(seed: int, cut: int) -> None:
    rng = np.random.default_rng(seed)
    ekf, block = random_filter(rng), random_block(rng)
    halves = copy.deepcopy(ekf)
    ekf.propagate(block)
    for part in (slice(0, cut), slice(cut, None)):
        halves.propagate(
            ImuBlock(block.dt[part], block.angular_velocity[part], block.specific_force[part])
        )
    np.testing.assert_allclose(error_between(ekf, halves), np.zeros(15), atol=1e-9)
    np.testing.assert_allclose(ekf.covariance, halves.covariance, rtol=1e-3, atol=1e-3)


def test_an_empty_block_changes_nothing() -> None:
    ekf = random_filter(np.random.default_rng(0), NOISE)
    before = copy.deepcopy(ekf)
    ekf.propagate(ImuBlock(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3))))
    np.testing.assert_array_equal(error_between(ekf, before), np.zeros(15))
    np.testing.assert_array_equal(ekf.covariance, before.covariance)


@pytest.mark.parametrize("seed", range(5))
def test_the_update_is_the_textbook_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ekf = random_filter(rng)
    ekf.covariance = random_covariance(rng)
    before = copy.deepcopy(ekf)
    h, residual, r = rng.normal(size=(4, 15)), rng.normal(0.0, 0.01, 4), rng.uniform(0.01, 1, 4)
    gain = before.covariance @ h.T @ np.linalg.inv(h @ before.covariance @ h.T + np.diag(r))

    ekf.update(Observation(Source.FIELD, h, residual, r))

    expected = (np.eye(15) - gain @ h) @ before.covariance
    np.testing.assert_allclose(ekf.covariance, expected, atol=1e-12)
    np.testing.assert_allclose(error_between(ekf, before), gain @ residual, atol=1e-12)


def test_the_covariance_stays_symmetric_and_positive_definite() -> None:
    rng = np.random.default_rng(3)
    ekf = random_filter(rng, NOISE)
    sigmas = [10.0] * 3 + [1.0] * 3 + [0.1, 0.1, math.pi] + [0.3] * 3 + [0.01] * 3
    ekf.covariance = np.diag(np.square(sigmas))
    for _ in range(500):
        ekf.propagate(random_block(rng))
        part = slice(0, 3) if rng.uniform() < 0.5 else slice(3, 6)
        exact = np.zeros(3), np.full(3, 1e-4)
        ekf.update(Observation(Source.FIELD, np.eye(15)[part], *exact))
    scale = np.sqrt(np.diag(ekf.covariance))
    correlation = ekf.covariance / np.outer(scale, scale)
    np.testing.assert_allclose(correlation, correlation.T, atol=1e-9)
    assert np.min(np.linalg.eigvalsh(correlation)) > 1e-9


def test_turn_restarts_the_heading_and_turns_the_tilt() -> None:
    ekf = Ekf((0.0, 0.0, 0.0, 1.0), np.ones(15), QUIET)
    ekf.covariance = random_covariance(np.random.default_rng(1))
    tilt = ekf.covariance[6:8, 6:8].copy()
    ekf.turn(math.radians(90.0), 0.2)
    np.testing.assert_allclose(ekf.attitude, (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)), atol=1e-12)
    assert ekf.heading_variance == pytest.approx(0.04)
    np.testing.assert_allclose(np.delete(ekf.covariance[8], 8), np.zeros(14))
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    np.testing.assert_allclose(ekf.covariance[6:8, 6:8], quarter @ tilt @ quarter.T, atol=1e-12)


def test_set_block_forgets_correlations() -> None:
    ekf = Ekf((0.0, 0.0, 0.0, 1.0), np.ones(15), QUIET)
    ekf.covariance = random_covariance(np.random.default_rng(1))
    rest = ekf.covariance[3:, 3:].copy()
    ekf.set_block(slice(0, 3), np.array([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(ekf.covariance[:3, :3], np.diag([1.0, 4.0, 9.0]))
    np.testing.assert_array_equal(ekf.covariance[:3, 3:], np.zeros((3, 12)))
    np.testing.assert_array_equal(ekf.covariance[3:, 3:], rest)


def circling(rng: np.random.Generator, sigmas: Array) -> list[float]:
    """Normalised squared error once a second of a flight in circles of changing speed.

    Truth, noise and initial error are drawn exactly as the filter believes them to be.
    """
    dt, steps = 0.01, 20
    time = np.arange(3000) * dt
    rate = np.stack([0.2 * np.sin(0.7 * time), 0.1 * np.cos(0.9 * time), 0.4 + 0 * time], axis=1)
    force = np.stack([np.sin(0.5 * time), np.cos(0.3 * time), GRAVITY + 0 * time], axis=1)
    truth = Ekf((0.0, 0.0, 0.0, 1.0), sigmas, QUIET)
    start = Ekf((0.0, 0.0, 0.0, 1.0), sigmas, NOISE)
    ekf = displaced(start, -sigmas * rng.normal(size=15))
    biases = np.concatenate([np.zeros(3), np.zeros(3)])
    walk = np.array([NOISE.accel_bias] * 3 + [NOISE.gyro_bias] * 3) * math.sqrt(dt)
    white = math.sqrt(1 / dt)
    squared = []
    for first in range(0, len(time), steps):
        rows = slice(first, first + steps)
        drift = biases + np.cumsum(walk * rng.normal(size=(steps, 6)), axis=0)
        biases = drift[-1]
        truth.propagate(ImuBlock(np.full(steps, dt), rate[rows], force[rows]))
        gyro = rate[rows] + drift[:, 3:] + NOISE.gyro * white * rng.normal(size=(steps, 3))
        accel = force[rows] + drift[:, :3] + NOISE.accel * white * rng.normal(size=(steps, 3))
        ekf.propagate(ImuBlock(np.full(steps, dt), gyro, accel))
        truth.accel_bias, truth.gyro_bias = np.zeros(3), np.zeros(3)
        measured = np.concatenate([truth.position, truth.velocity])
        measured = measured + np.array([1.0] * 3 + [0.2] * 3) * rng.normal(size=6)
        residual = measured - np.concatenate([ekf.position, ekf.velocity])
        variances = np.array([1.0] * 3 + [0.04] * 3)
        ekf.update(Observation(Source.FIELD, np.eye(15)[:6], residual, variances))
        if first // steps % 5 == 4:
            error = error_between(truth, ekf)
            error[9:] += biases
            squared.append(float(error @ np.linalg.solve(ekf.covariance, error)))
    return squared


def test_errors_are_as_large_as_the_filter_believes() -> None:
    """Mean of the squared error over runs follows χ² with 15 degrees of freedom a run."""
    rng = np.random.default_rng(11)
    sigmas = np.array([1.0] * 3 + [0.5] * 3 + [0.05, 0.05, 0.2] + [0.1] * 3 + [0.005] * 3)
    runs = np.array([circling(rng, sigmas) for _ in range(20)])
    low, high = chi2.ppf([1e-4, 1 - 1e-4], 15 * len(runs)) / len(runs)
    means = runs.mean(axis=0)
    assert low < means[-1] < high
    assert np.mean((low < means) & (means < high)) > 0.9
