# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The quality of forged data: by hand, and in the units of Table 2."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from scipy.stats import poisson

from hijack_detect.evaluation.scores.forged import ForgedData, forging_times, likelihood
from hijack_detect.replay.truth import Attack
from hijack_detect.streams.samples import FixSample, SatelliteSample, VelocitySample

SECOND = 10**9


def test_likelihood_is_the_derivative_of_the_logarithm_of_poissons_likelihood() -> None:
    values, mean = [9.0, 14.0, 17.0, 12.0], 12.5
    slope = approx_fprime(
        np.array([mean]), lambda at: poisson.logpmf(values, at[0]).sum(), epsilon=1e-6
    )
    assert likelihood(values, mean) == pytest.approx(float(slope[0]), abs=1e-4)
    assert likelihood(values, mean) == pytest.approx(52.0 / 12.5 - 4.0)


def test_likelihood_is_zero_at_the_mean_and_has_the_sign_of_the_change() -> None:
    values = [9.0, 14.0, 17.0, 12.0]
    assert likelihood(values, 13.0) == 0.0
    assert likelihood(values, 20.0) < 0.0 < likelihood(values, 5.0)
    assert likelihood([0.0, 0.0], 0.0) == 0.0


def data(forged_m: float) -> ForgedData:
    """100 s at 5 Hz: altitude 2000 m, forged by ± some metres from 50 s to 60 s."""
    found = ForgedData()
    for index in range(500):
        stamp = index * SECOND // 5
        sign = (-1) ** index if 250 <= index < 300 else 0
        found.add(VelocitySample(stamp, (3.0, 4.0, 0.0)))
        found.add(SatelliteSample(stamp, 12 + 2 * sign))
        found.add(FixSample(stamp, 48.0, 11.0, 2000.0 + forged_m * sign))
        found.add(FixSample(stamp + 1, 0.0, 0.0, 0.0, has_fix=False))
    return found


def test_deviations_are_those_within_the_attack_and_before_it() -> None:
    found = data(3.0).quality(Attack(50 * SECOND, 60 * SECOND))
    assert found["altitude"].sigma == pytest.approx(3.0)
    assert found["altitude"].normal_sigma == pytest.approx(0.0)
    assert found["altitude"].likelihood == pytest.approx(0.0, abs=1e-9)
    assert found["satellites"].sigma == pytest.approx(2.0)
    assert found["speed"].sigma == 0.0
    assert set(found) == {"altitude", "satellites", "speed", "track", "latitude", "longitude"}


def test_a_clean_flight_gives_lambda_itself() -> None:
    found = data(3.0).quality(None)
    assert {one.likelihood for one in found.values()} == {0.0}
    assert {one.normal_sigma for one in found.values()} == {None}
    assert found["altitude"].sigma == pytest.approx(3.0 * math.sqrt(50 / 150), rel=0.02)


def test_topics_that_are_absent_have_no_quality() -> None:
    found = ForgedData()
    assert found.quality(None) == {}
    found.add(SatelliteSample(0, 9))
    assert set(found.quality(None)) == {"satellites"}


def test_forging_more_takes_longer() -> None:
    times = forging_times()
    assert [one.parameters for one in times][0::3] == ["satellites", "all"]
    assert times[-1].microseconds > times[0].microseconds > 0.0
