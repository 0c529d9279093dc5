# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Filters with different headings: the motion decides, or nothing does."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hijack_detect.estimation.attitude import AttitudeEstimator
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.ekf import Ekf, Observation, ProcessNoise, Source
from hijack_detect.estimation.filter_bank import FilterBank
from hijack_detect.estimation.rotation import heading
from hijack_detect.simulation.flight import Flight
from hijack_detect.streams.samples import ImuSample

NOISE = ProcessNoise(0.1, 0.003, 0.005, 0.0007)


def bank() -> FilterBank:
    return FilterBank(Ekf((0.0, 0.0, 0.0, 1.0), np.full(15, 0.1), NOISE))


def headings(one: FilterBank) -> list[float]:
    found: list[float] = []
    one.apply(lambda ekf: found.append(heading(ekf.attitude)))
    return found


def test_a_bank_starts_with_one_filter_and_splits_into_all_directions() -> None:
    one = bank()
    assert one.decided
    one.split(0.5)
    assert not one.decided
    found = np.sort(np.degrees(headings(one)) % 360.0)
    gaps = np.diff([*found, found[0] + 360.0])
    assert np.max(gaps) <= 60.0
    assert np.min(gaps) >= 15.0
    assert one.best.heading_variance == pytest.approx(0.25)


def test_the_filters_of_a_bank_are_independent() -> None:
    one = bank()
    one.split(0.5)
    one.best.position[0] = 100.0
    positions: list[float] = []
    one.apply(lambda ekf: positions.append(ekf.position[0]))
    assert sorted(positions)[-2:] == [0.0, 100.0]


def test_measurements_leave_the_heading_that_they_fit() -> None:
    """A heading of 130° is measured again and again."""
    one = bank()
    one.split(np.radians(30.0))

    def compass(ekf: Ekf) -> Observation:
        error = (np.radians(130.0) - heading(ekf.attitude) + np.pi) % (2 * np.pi) - np.pi
        return Observation(Source.FIELD, np.eye(15)[8:9], np.array([error]), np.array([0.3**2]))

    for _ in range(200):
        one.measure(compass)
    assert one.decided
    assert np.degrees(heading(one.best.attitude)) == pytest.approx(130.0, abs=5.0)


def test_measurements_that_say_nothing_of_the_heading_decide_nothing() -> None:
    one = bank()
    one.split(np.radians(30.0))
    for _ in range(200):
        one.measure(lambda ekf: ekf.gps(Source.POSITION, np.zeros(3), np.ones(3)))
    assert not one.decided
    assert len(headings(one)) == 8


@pytest.mark.parametrize("mounted_deg", [90.0, 180.0, -120.0])
def test_a_vehicle_that_flies_sideways_finds_its_heading_without_a_magnetometer(
    mounted_deg: float,
    flight: Callable[..., Flight],
    samples: Callable[..., Any],
    errors: Callable[..., Any],
) -> None:
    """The same flight felt by an IMU that is turned in the vehicle: its nose is off the course."""
    curved = flight("curved", 2)
    mounted = Rotation.from_euler("Z", mounted_deg, degrees=True)
    estimator = AttitudeEstimator(AttitudeParameters())
    outputs = []
    for name, one in samples(curved, "imu", "fix", "velocity"):
        sample = one
        if isinstance(one, ImuSample):
            rate, force = mounted.inv().apply([one.angular_velocity, one.specific_force])
            sample = ImuSample(one.stamp_ns, tuple(rate), tuple(force))
        output = estimator.update(name, sample)
        if output is not None:
            outputs.append(output)
    offset = mounted.inv()
    turned = [
        type(one)(
            one.stamp_ns,
            tuple((Rotation.from_quat(one.orientation) * offset).as_quat().tolist()),
            one.heading_variance,
            one.angular_velocity,
            one.specific_force,
        )
        for one in outputs[::10]
        if one.orientation is not None
    ]
    found = errors(curved, turned)
    assert found[0, 0] < 50.0
    assert np.sqrt(np.mean(np.square(found[:, 3]))) < 5.0
    assert np.max(abs(found[:, 1:3])) < 4.0
