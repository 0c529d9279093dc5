# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The coloured error of GPS velocities: in closed form, and what of it a receiver can train."""

import math

import numpy as np
import pytest
from filter_start import hover
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.estimation.air_ekf import VELOCITY_ERROR, AirEkf
from hijack_detect.estimation.ekf import ATTITUDE
from hijack_detect.estimation.kalman import Innovation
from hijack_detect.estimation.velocity_error import VelocityError, VelocityNoise

SIGMA = 0.4


def innovation(size: float) -> Innovation:
    """Each axis off by so many of its standard deviations."""
    return Innovation(np.zeros((3, 1)), np.full(3, size), np.eye(3), np.zeros((1, 3)))


@given(st.lists(st.floats(0.01, 3.0), min_size=1, max_size=20))
def test_its_variance_stays_that_of_a_gauss_markov_process(steps: list[float]) -> None:
    error = VelocityError(VelocityNoise(sigma=SIGMA))
    variance = SIGMA**2
    for seconds in steps:
        variance = error.kept(seconds) ** 2 * variance + error.walked(seconds)
    assert variance == pytest.approx(SIGMA**2)


def test_a_receiver_is_never_better_than_nominal_nor_worse_than_the_bound() -> None:
    for size, expected in ((0.0, 1.0), (0.5, 1.0), (1e6, 5.0)):
        error = VelocityError(VelocityNoise())
        for _ in range(300):
            error.propagate(0.2)
            error.learn(innovation(size))
        assert error.scale == pytest.approx(expected)


def test_what_is_learnt_is_at_least_3_s_old() -> None:
    error = VelocityError(VelocityNoise())
    for _ in range(14):
        error.propagate(0.2)
        error.learn(innovation(100.0))
    assert error.scale == 1.0


def filter_after(seconds: float, wrong: float, noise: VelocityNoise) -> AirEkf:
    """A hover whose GPS velocity is right for 60 s, then wrong to the East for some time."""
    steps = round((60.0 + seconds) * 5)
    *_, last = hover(noise, steps, lambda _: 0.0, lambda step: wrong if step >= 300 else 0.0)
    return last


def tilt(ekf: AirEkf) -> float:
    x, y, _, _ = ekf.attitude
    return 2.0 * math.hypot(x, y)


def test_a_velocity_that_is_wrong_for_a_second_does_not_tilt_the_vehicle() -> None:
    white, coloured = VelocityNoise(sigma=0.0, worst=1.0), VelocityNoise(sigma=SIGMA)
    believed, known = filter_after(1.2, 0.5, white), filter_after(1.2, 0.5, coloured)
    assert tilt(known) < 0.5 * tilt(believed)
    assert known.velocity_error.value[0] > 0.2
    sigma = math.sqrt(known.covariance[VELOCITY_ERROR, VELOCITY_ERROR][0, 0])
    assert known.velocity_error.value[0] == pytest.approx(0.5, abs=3.0 * sigma)
    assert np.all(np.diag(known.covariance)[ATTITUDE] > 0.0)
