# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The Gauss-Markov error of a GPS height: what is normal, by claim and by what was seen."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.detectors.altitude import AltitudeDetector
from hijack_detect.detectors.altitude_parameters import AltitudeParameters
from hijack_detect.detectors.height_error import HeightError
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.streams.samples import FixSample, PressureSample

SECOND = 10**9
DEFAULT = AltitudeParameters()
HZ = 5


def wander(seconds: float, sigma: float, tau_s: float, seed: int) -> list[float]:
    """A Gauss-Markov process at the rate of the fixes."""
    rng = np.random.default_rng(seed)
    kept = math.exp(-1.0 / (HZ * tau_s))
    values = [float(rng.normal()) * sigma]
    for _ in range(round(seconds * HZ)):
        fresh = float(rng.normal()) * sigma * math.sqrt(1.0 - kept * kept)
        values.append(kept * values[-1] + fresh)
    return values


def hover(
    seconds: float, offset: Callable[[float], float], claimed_m: float | None = None
) -> list[Verdict]:
    """Verdicts on a hover with fixes and a barometer at 5 Hz, without an IMU."""
    detector = AltitudeDetector(DEFAULT)
    verdicts = []
    for tick in range(round(seconds * HZ)):
        stamp = tick * SECOND // HZ
        detector.update("pressure", PressureSample(stamp, 100_000.0))
        fix = FixSample(stamp, 48.0, 11.0, 100.0 + offset(tick / HZ), vertical_accuracy_m=claimed_m)
        verdict = detector.update("fix", fix)
        assert verdict is not None
        verdicts.append(verdict)
    return verdicts


def alarm_s(verdicts: list[Verdict]) -> float | None:
    return next((one.stamp_ns / SECOND for one in verdicts if one.state is State.ALARM), None)


def fix_of(second: float, claimed_m: float | None) -> FixSample:
    return FixSample(round(second * SECOND), 48.0, 11.0, 100.0, vertical_accuracy_m=claimed_m)


@pytest.mark.parametrize("horizon_s", [1.0, 10.0, 60.0])
def test_a_normal_change_is_so_many_deviations_of_the_process(horizon_s: float) -> None:
    """4 hours of the process with its white noise: the deviation of its changes, within 8 %."""
    values = np.array(wander(14_400.0, DEFAULT.wander_m, DEFAULT.wander_s, 1))
    lag = round(horizon_s * HZ)
    change = values[lag:] - values[:-lag]
    deviation = math.hypot(float(np.std(change)), DEFAULT.height_noise_m)
    normal = HeightError(DEFAULT).poor(horizon_s)
    assert normal == pytest.approx(DEFAULT.height_sigmas * deviation, rel=0.08)


@settings(deadline=None, max_examples=50)
@given(st.lists(st.one_of(st.none(), st.floats(0.01, 1e4)), min_size=1, max_size=300))
def test_no_claims_take_it_beyond_its_bounds(claims: list[float | None]) -> None:
    error = HeightError(DEFAULT)
    for second, claimed_m in enumerate(claims):
        error.claim(fix_of(second, claimed_m))
        error.learn(second * SECOND, 0.0, 0.0, moving=True)
        assert DEFAULT.baro_floor <= error.part <= max(2.5, DEFAULT.baro_ceiling)
        assert error.sigma == error.part * DEFAULT.wander_m
        highest = DEFAULT.baro_ceiling * error.poor(math.inf)
        assert DEFAULT.baro_total_m <= error.total() <= max(highest, 2.5 * DEFAULT.baro_total_m)


def test_an_error_outlives_the_claim_by_its_time_constant() -> None:
    error = HeightError(DEFAULT)
    for second in range(200):
        error.claim(fix_of(second, 12.0))
        error.learn(second * SECOND, 0.0, 0.0, moving=True)
    assert error.part == DEFAULT.baro_ceiling
    for second in range(200, 260):
        error.claim(fix_of(second, 1.0))
        error.learn(second * SECOND, 0.0, 0.0, moving=True)
    assert DEFAULT.baro_floor < error.part < DEFAULT.baro_ceiling
    error.claim(fix_of(800, 1.0))
    assert error.part == DEFAULT.baro_floor


@pytest.mark.parametrize(("sigma", "tau_s"), [(3.0, 30.0), (5.0, 60.0), (8.0, 120.0)])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_wander_that_the_receiver_admits_is_no_alarm(
    sigma: float, tau_s: float, seed: int
) -> None:
    values = wander(300.0, sigma, tau_s, seed)
    assert max(values) - min(values) > 2.0 * sigma
    assert alarm_s(hover(300.0, lambda t: values[round(t * HZ)], sigma)) is None


def test_a_slow_drift_trains_no_more_than_a_bounded_part() -> None:
    """0.1 m/s for 120 s, below every limit of a minute, then 1 m/s: 3.5 s when untrained."""
    start = 100.0

    def drift(t: float) -> float:
        return 0.1 * min(max(0.0, t - start), 120.0) + max(0.0, t - start - 120.0)

    verdicts = hover(300.0, drift, 1.0)
    before = [one for one in verdicts if one.stamp_ns < (start + 120.0) * SECOND]
    assert max(one.values.get("barometer_limit", 0.0) for one in before[-5:]) < 1.1
    found = alarm_s(verdicts)
    assert found is not None
    assert found < start + 120.0 + 8.0


def test_a_drift_of_0_2_metres_per_second_is_seen_before_it_has_trained_anything() -> None:
    found = alarm_s(hover(200.0, lambda t: 0.2 * max(0.0, t - 100.0), 1.0))
    assert found is not None
    assert found < 150.0


@pytest.mark.parametrize("claimed_m", [0.7, 5.0, 50.0])
@pytest.mark.parametrize("name", ["smallest_step", "smallest_ramp"])
def test_the_smallest_step_and_ramp_are_seen_and_no_smaller_ones(
    name: str, claimed_m: float
) -> None:
    """A step at once; a ramp within the 10 s that it is stated for, and the alarm's 0.6 s."""
    smallest = hover(120.0, lambda _: 0.0, claimed_m)[-1].values[name]
    for factor in (0.9, 1.1):
        size = factor * smallest

        def offset(t: float, size: float = size) -> float:
            after = t - 119.9
            return 0.0 if after < 0.0 else size if name == "smallest_step" else size * after

        found = alarm_s(hover(131.0, offset, claimed_m))
        assert (found is not None) == (factor > 1.0)
