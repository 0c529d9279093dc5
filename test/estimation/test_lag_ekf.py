# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The filter with lags: against motion in closed form, the textbook and the filter without them."""

import copy
import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from filter_start import ERRORS, LEVEL, NOISE, SIGMAS
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.estimation.ekf import (
    ACCEL_BIAS,
    ATTITUDE,
    GRAVITY,
    GYRO_BIAS,
    POSITION,
    VELOCITY,
    Ekf,
    ImuBlock,
    Observation,
    Source,
)
from hijack_detect.estimation.lag_ekf import (
    DIFFERENCE,
    LAG,
    LAG_BAND_S,
    MOST_LAG_SIGMA_S,
    SIZE,
    STEPS,
    LagEkf,
    Measured,
    ModelErrors,
    Propagated,
)

Array = npt.NDArray[np.float64]
NONE = replace(
    ERRORS,
    lag_sigma_s=0.0,
    lag_walk=0.0,
    lag_difference_walk=0.0,
    lag_jitter_s=0.0,
    position_jitter_s=0.0,
    force_scale=0.0,
    rate_scale=0.0,
)
VARIANCES = {Source.POSITION: np.full(3, 0.49), Source.VELOCITY: np.full(3, 0.01)}


def random_block(rng: np.random.Generator, count: int = 20) -> ImuBlock:
    force = np.array([0.0, 0.0, GRAVITY]) + rng.normal(0.0, 3.0, (count, 3))
    return ImuBlock(rng.uniform(0.005, 0.01, count), rng.normal(0.0, 1.0, (count, 3)), force)


def still_block(count: int = 20, force: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> ImuBlock:
    """At rest or at a constant acceleration for 0.2 s, level."""
    felt = np.tile(np.array([0.0, 0.0, GRAVITY]) + np.array(force), (count, 1))
    return ImuBlock(np.full(count, 0.2 / count), np.zeros((count, 3)), felt)


def measure(ekf: Ekf, source: Source, measured: Array) -> None:
    ekf.update(ekf.gps(source, measured, VARIANCES[source]))


@pytest.mark.parametrize("seed", range(3))
def test_without_errors_of_the_model_it_is_the_filter_without_lags(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plain, lagged = Ekf(LEVEL, SIGMAS, NOISE), LagEkf(LEVEL, SIGMAS, NOISE, NONE)
    for _ in range(40):
        block, position, velocity = random_block(rng), rng.normal(size=3), rng.normal(size=3)
        for ekf in (plain, lagged):
            ekf.propagate(block)
            measure(ekf, Source.POSITION, position)
            measure(ekf, Source.VELOCITY, velocity)
    np.testing.assert_allclose(lagged.covariance[:15, :15], plain.covariance, atol=1e-10)
    for name in ("position", "velocity", "attitude", "accel_bias", "gyro_bias"):
        np.testing.assert_allclose(getattr(lagged, name), getattr(plain, name), atol=1e-9)
    np.testing.assert_array_equal(lagged.lags, np.zeros(2))
    np.testing.assert_array_equal(lagged.covariance[15:], np.zeros((2, SIZE)))


STEADY = replace(ERRORS, lag_walk=0.001)
"""Of a receiver whose latency does not change."""


def states_of(position_lag: float, velocity_lag: float) -> Array:
    return np.array([velocity_lag, position_lag - velocity_lag])


def flown(
    position_lag: float,
    velocity_lag: float,
    seconds: float,
    errors: ModelErrors = STEADY,
    growth: float = 0.0,
) -> LagEkf:
    """A level flight along a figure of eight, known in closed form; GPS lags by what is asked."""
    rng = np.random.default_rng(1)
    sizes, rates = np.array([20.0, 10.0, 0.0]), np.array([0.4, 0.8, 0.0])

    def position(t: float) -> Array:
        return sizes * np.sin(rates * t)

    def velocity(t: float) -> Array:
        return sizes * rates * np.cos(rates * t)

    ekf = LagEkf(LEVEL, SIGMAS, NOISE, errors)
    ekf.velocity = velocity(0.0)
    for step in range(round(seconds / 0.2)):
        middles = 0.2 * step + 0.01 * (np.arange(20) + 0.5)
        felt = -sizes * rates**2 * np.sin(rates * middles[:, None])
        force = felt + [0.0, 0.0, GRAVITY] + 0.2 * rng.normal(size=(20, 3))
        gyro = 0.01 * rng.normal(size=(20, 3))
        ekf.propagate(ImuBlock(np.full(20, 0.01), gyro, force))
        t = 0.2 * (step + 1)
        more = growth * t
        measure(ekf, Source.POSITION, position(t - position_lag - more) + 0.3 * rng.normal(size=3))
        measure(ekf, Source.VELOCITY, velocity(t - velocity_lag - more) + 0.05 * rng.normal(size=3))
    return ekf


@pytest.mark.parametrize("lags", [(0.0, 0.0), (0.1, -0.05), (-0.08, 0.12), (0.15, 0.15)])
def test_the_lags_of_a_manoeuvring_vehicle_are_learnt(lags: tuple[float, float]) -> None:
    ekf = flown(*lags, 60.0)
    learnt = states_of(*lags)
    np.testing.assert_allclose(ekf.lags, learnt, atol=0.025)
    deviations = np.sqrt(np.diag(ekf.covariance)[15:])
    assert np.all(deviations < 0.3 * STEADY.lag_sigma_s)
    assert np.all(abs(ekf.lags - learnt) < 4.0 * deviations)
    least = np.array(ekf.least_lags)
    assert np.all(least < lags)
    assert np.all(np.array(lags) < least + 4.0 * STEADY.lag_sigma_s)


def test_a_latency_that_grows_is_followed() -> None:
    """By 0.01 s/s for 15 s: a filter for a receiver in order is behind it."""
    slow, fast = (flown(0.0, 0.0, 15.0, errors, 0.01) for errors in (STEADY, ERRORS))
    assert fast.lags[0] == pytest.approx(0.15, abs=0.03)
    assert slow.lags[0] < fast.lags[0] - 0.03


@given(lag=st.floats(-0.2, 0.2), difference=st.floats(-0.1, 0.1))
def test_what_is_beyond_the_band_can_be_taken_over(lag: float, difference: float) -> None:
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, ERRORS)
    assert ekf.beyond_band == 0.0
    ekf.lags, ekf.acceleration = np.array([lag, difference]), np.array([0.0, 1.0, 0.0])
    middle = lag + 0.5 * difference
    if abs(middle) <= LAG_BAND_S:
        assert ekf.beyond_band == 0.0
    beyond = ekf.beyond_band
    ekf.rebase(beyond)
    assert abs(ekf.lags[0] + 0.5 * ekf.lags[1]) <= LAG_BAND_S + 1e-12
    assert ekf.lags[0] + beyond == pytest.approx(lag)
    assert ekf.lags[1] == difference


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_lag_beyond_the_bound_is_held_at_it(sign: float) -> None:
    ekf = flown(0.8 * sign, 0.8 * sign, 40.0)
    assert ekf.lags[0] == sign * STEADY.max_lag_s
    assert abs(ekf.lags[1]) <= STEADY.max_lag_s


def test_a_vehicle_at_rest_shows_no_lag() -> None:
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, ERRORS)
    for _ in range(50):
        ekf.propagate(still_block())
        measure(ekf, Source.POSITION, np.zeros(3))
        measure(ekf, Source.VELOCITY, np.zeros(3))
    np.testing.assert_allclose(ekf.lags, np.zeros(2), atol=1e-9)
    assert np.all(np.diag(ekf.covariance)[15:] >= 0.99 * ERRORS.lag_sigma_s**2)


def test_a_long_hover_makes_no_filter_run_later() -> None:
    """Ten minutes with the noise of a receiver: the state may drift, the uncertainty ends."""
    rng = np.random.default_rng(3)
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, ERRORS)
    wander = np.zeros(3)
    for _ in range(3000):
        ekf.propagate(still_block(4, tuple(rng.normal(0.0, 0.1, 3))))
        wander = math.exp(-0.01) * wander + rng.normal(0.0, 0.07, 3)
        measure(ekf, Source.POSITION, wander)
        measure(ekf, Source.VELOCITY, rng.normal(0.0, 0.1, 3))
        assert ekf.beyond_band == 0.0
    assert ekf.covariance[LAG, LAG] < 1.1 * MOST_LAG_SIGMA_S**2


def test_what_a_lagging_position_is_expected_to_be_by_hand() -> None:
    """At 3 and 4 m/s with 0.1 s of lag: 0.3 and 0.4 m back; noise grows by (0.05 s · 5 m/s)²."""
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, replace(ERRORS, position_jitter_s=0.05))
    ekf.position, ekf.velocity = np.array([10.0, 20.0, 30.0]), np.array([3.0, 4.0, 12.0])
    ekf.lags = states_of(0.1, 0.0)
    seen = ekf.gps(Source.POSITION, np.array([9.7, 19.6, 28.8]), np.full(3, 0.49))
    np.testing.assert_allclose(seen.residual, np.zeros(3), atol=1e-12)
    np.testing.assert_allclose(seen.R, np.full(3, 0.49 + 0.25**2))
    expected = np.zeros((3, SIZE))
    expected[:, POSITION] = np.eye(3)
    expected[:, LAG] = expected[:, DIFFERENCE] = [-3.0, -4.0, -12.0]
    np.testing.assert_array_equal(seen.H, expected)


def test_what_a_lagging_velocity_is_expected_to_be_by_hand() -> None:
    """At 2 m/s² with 0.1 s of lag: 0.2 m/s back; noise grows by (0.1 s · 2 m/s²)²."""
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, replace(ERRORS, lag_jitter_s=0.1))
    ekf.propagate(still_block(force=(2.0, 0.0, 0.0)))
    np.testing.assert_allclose(ekf.acceleration, [2.0, 0.0, 0.0], atol=1e-12)
    ekf.lags = states_of(0.0, 0.1)
    seen = ekf.gps(Source.VELOCITY, np.array([0.2, 0.0, 0.0]), np.full(3, 0.01))
    np.testing.assert_allclose(seen.residual, np.zeros(3), atol=1e-12)
    np.testing.assert_allclose(seen.R, np.full(3, 0.01 + 0.2**2))
    expected = np.zeros((3, SIZE))
    expected[:, VELOCITY] = np.eye(3)
    expected[:, LAG] = [-2.0, 0.0, 0.0]
    np.testing.assert_allclose(seen.H, expected, atol=1e-12)


def test_process_noise_grows_with_acceleration_and_rate_by_hand() -> None:
    errors = replace(ERRORS, force_scale=0.03, rate_scale=0.02, lag_walk=0.05)
    plain, lagged = Ekf(LEVEL, SIGMAS, NOISE), LagEkf(LEVEL, SIGMAS, NOISE, errors)
    block = ImuBlock(
        np.full(10, 0.02), np.tile([0.0, 0.0, 1.5], (10, 1)), np.zeros((10, 3))
    )  # 0.2 s
    force = np.array([3.0, 4.0, GRAVITY])
    more = lagged.process_noise(block, force)
    more[:15] -= plain.process_noise(block, force)
    expected = np.zeros(SIZE)
    expected[VELOCITY] = (0.03 * 5.0) ** 2 * 0.2
    expected[ATTITUDE] = (0.02 * 1.5) ** 2 * 0.2
    expected[15:] = np.square([0.05, 0.001]) * 0.2
    np.testing.assert_allclose(more, expected, atol=1e-15)


def test_the_record_of_a_propagation() -> None:
    """An error before it is Φ times that after it: here one of velocity, bias, and lag."""
    rng = np.random.default_rng(2)
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, NONE)
    block = random_block(rng)
    error = np.zeros(SIZE)
    error[VELOCITY], error[ACCEL_BIAS], error[GYRO_BIAS] = rng.normal(0.0, 1e-5, (3, 3))
    error[15:] = 0.03
    other = copy.deepcopy(ekf)
    other.velocity, other.accel_bias, other.gyro_bias = (
        error[part] for part in (VELOCITY, ACCEL_BIAS, GYRO_BIAS)
    )
    ekf.propagate(block)
    other.propagate(block)
    (step,) = ekf.steps
    assert isinstance(step, Propagated)
    assert step.dt_s == pytest.approx(float(np.sum(block.dt)))
    after = step.transition @ error
    np.testing.assert_allclose(other.position - ekf.position, after[POSITION], atol=1e-8)
    np.testing.assert_allclose(other.velocity - ekf.velocity, after[VELOCITY], atol=1e-7)
    np.testing.assert_array_equal(after[15:], error[15:])


@pytest.mark.parametrize("source", [Source.POSITION, Source.VELOCITY, Source.FIELD])
def test_the_record_of_a_measurement_is_the_textbook_one(source: Source) -> None:
    rng = np.random.default_rng(7)
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, ERRORS)
    ekf.propagate(random_block(rng))
    if source is Source.FIELD:
        row = rng.normal(size=(1, SIZE))
        seen = Observation(source, row, rng.normal(size=1), np.array([0.2]))
    else:
        seen = ekf.gps(source, rng.normal(0.0, 0.1, 3), np.full(3, 0.5))
    before = copy.deepcopy(ekf)
    ekf.steps.clear()
    ekf.update(seen)

    (step,) = ekf.steps
    assert isinstance(step, Measured)
    assert (step.source, step.horizontal) == (source, True)
    h, r = seen.H, seen.R
    spread = h @ before.covariance @ h.T + np.diag(r)
    said = step.innovation
    np.testing.assert_allclose(said.precision @ spread, np.eye(len(r)), atol=1e-12)
    np.testing.assert_allclose(said.K @ spread, before.covariance @ h.T, atol=1e-12)
    np.testing.assert_array_equal(said.H, h)
    np.testing.assert_array_equal(said.residual, seen.residual)
    moved = said.K @ said.residual
    np.testing.assert_allclose(ekf.position - before.position, moved[POSITION], atol=1e-12)
    np.testing.assert_allclose(ekf.lags - before.lags, moved[15:], atol=1e-12)


def test_another_sensor_after_the_gps_is_not_taken_for_it() -> None:
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, ERRORS)
    measure(ekf, Source.POSITION, np.zeros(3))
    ekf.gps(Source.VELOCITY, np.zeros(3), np.full(3, 0.01))  # asked, and not used
    h = np.zeros((1, SIZE))
    h[0, 8] = 1.0
    ekf.update(Observation(Source.FIELD, h, np.array([0.1]), np.array([0.04])))
    sources = [step.source for step in ekf.steps if isinstance(step, Measured)]
    assert sources == [Source.POSITION, Source.FIELD]


def test_an_empty_block_is_no_step() -> None:
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, ERRORS)
    ekf.propagate(ImuBlock(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3))))
    assert len(ekf.steps) == 0


def test_a_record_that_nobody_reads_does_not_grow() -> None:
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, ERRORS)
    for _ in range(STEPS + 100):
        ekf.propagate(still_block(count=1))
    assert len(ekf.steps) == STEPS


def test_a_turn_leaves_the_lags_alone() -> None:
    ekf = flown(0.1, 0.1, 4.0)
    before = copy.deepcopy(ekf)
    ekf.turn(math.radians(90.0), 0.2)
    np.testing.assert_array_equal(ekf.lags, before.lags)
    np.testing.assert_allclose(ekf.covariance[15:, 15:], before.covariance[15:, 15:])
