# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the attitude filter knows after a hole in a simulated flight, by its own covariance."""

from collections.abc import Callable

import numpy as np
import pytest
from filter_start import ERRORS
from scipy.spatial.transform import Rotation

from hijack_detect.estimation.attitude_filter import LONGEST_BRIDGE_S, AttitudeFilter
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.ekf import ATTITUDE, ProcessNoise
from hijack_detect.estimation.lag_ekf import LagEkf, Measured
from hijack_detect.estimation.rotation import Array
from hijack_detect.simulation.flight import Flight
from hijack_detect.streams.samples import NANOSECONDS, Quaternion, Sample

Sent = list[tuple[str, Sample]]
START_S, FOLLOWED_S = 45.0, 15.0


def without(flight: Flight, sent: Sent, lost: tuple[str, ...], length_s: float) -> Sent:
    start = flight.plan.start_ns + round(START_S * NANOSECONDS)
    end = start + round(length_s * NANOSECONDS)
    late = end + round(FOLLOWED_S * NANOSECONDS)
    return [
        (name, one)
        for name, one in sent
        if one.stamp_ns < late and not (name in lost and start <= one.stamp_ns < end)
    ]


@pytest.mark.parametrize(
    "inputs",
    [
        ("imu", "fix"),
        ("imu", "fix", "velocity"),
        ("imu", "fix", "mag"),
        ("imu", "fix", "velocity", "mag"),
    ],
)
@pytest.mark.parametrize("lost", [("imu",), ("imu", "fix", "velocity", "mag")], ids=["imu", "all"])
@pytest.mark.parametrize("length_s", [2.0, 4.0, 10.0])
def test_after_a_hole_attitude_is_within_3_sigma_of_its_covariance(
    length_s: float,
    lost: tuple[str, ...],
    inputs: tuple[str, ...],
    flight: Callable[..., Flight],
    samples: Callable[..., Sent],
) -> None:
    """It takes the way of the vehicle in the hole neither for tilt nor for a bias."""
    curved = flight("curved", 1)
    start = curved.plan.start_ns
    hole_end = start + round((START_S + length_s) * NANOSECONDS)
    estimator = AttitudeFilter(AttitudeParameters())
    truth = Rotation.from_quat(curved.motion.quaternion)
    ratios = []
    for name, one in without(curved, samples(curved, *inputs), lost, length_s):
        estimator.update(name, one)
        ekf = estimator.ekf
        if one.stamp_ns < hole_end or name != "fix" or ekf is None or not estimator.decided:
            continue
        row = np.searchsorted(curved.motion.offsets_ns, estimator.valid_ns - start)
        error = (truth[int(row)] * Rotation.from_quat(ekf.attitude).inv()).as_rotvec()
        ratios.append(abs(error) / np.sqrt(np.diag(ekf.covariance)[ATTITUDE]))
    assert estimator.bridged == 1
    assert len(ratios) > 10
    assert np.max(ratios) < 3.0


@pytest.mark.parametrize(("length_s", "bridged"), [(29.0, 1), (31.0, 0)])
def test_a_gap_that_may_be_another_flight_is_not_bridged(
    length_s: float, bridged: int, flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    assert 29.0 < LONGEST_BRIDGE_S < 31.0
    curved = flight("curved", 1)
    estimator = AttitudeFilter(AttitudeParameters())
    for name, one in without(curved, samples(curved, "imu", "fix", "mag"), ("imu",), length_s):
        estimator.update(name, one)
    assert estimator.bridged == bridged


def test_biases_outlive_a_gap(flight: Callable[..., Flight], samples: Callable[..., Sent]) -> None:
    curved = flight("curved", 1)
    end = curved.plan.start_ns + round((START_S + 4.0) * NANOSECONDS)
    estimator = AttitudeFilter(AttitudeParameters())
    sent = without(curved, samples(curved, "imu", "fix", "velocity"), ("imu",), 4.0)
    first = next(n for n, (name, one) in enumerate(sent) if name == "imu" and one.stamp_ns >= end)
    for name, one in sent[:first]:
        estimator.update(name, one)
    assert estimator.ekf is not None
    before = estimator.ekf.gyro_bias.copy(), estimator.ekf.accel_bias.copy()
    estimator.update(*sent[first])
    assert estimator.bridged == 1
    np.testing.assert_array_equal(estimator.ekf.gyro_bias, before[0])
    np.testing.assert_array_equal(estimator.ekf.accel_bias, before[1])
    assert np.any(before[0] != 0.0)


def test_the_record_says_when_horizontal_rows_are_no_measurement(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    """Until the first course the vehicle is taken to stand still, whatever the GPS says."""
    curved = flight("curved", 1)

    def make(attitude: Quaternion, sigmas: Array, noise: ProcessNoise) -> LagEkf:
        return LagEkf(attitude, sigmas, noise, ERRORS)

    estimator = AttitudeFilter(AttitudeParameters(use_mag=False), make)
    found = []
    for name, one in samples(curved, "imu", "fix", "velocity"):
        estimator.update(name, one)
        if isinstance(estimator.ekf, LagEkf):
            found += [
                (estimator.first_heading is not None, step.horizontal)
                for step in estimator.ekf.steps
                if isinstance(step, Measured)
            ]
            estimator.ekf.steps.clear()
        if len(found) > 100 and found[-1][0]:
            break
    assert {known for known, _ in found} == {False, True}
    assert all(known == horizontal for known, horizontal in found)
