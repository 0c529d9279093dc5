# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Heading without GPS: on motions worked out by hand, and against the truth of a simulation."""

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hijack_detect.estimation.compass import Compass, earth_field
from hijack_detect.estimation.magnetic import declination
from hijack_detect.simulation.flight import Flight
from hijack_detect.streams.samples import FixSample, ImuSample, MagneticSample, Sample

SECOND = 10**9
FIX = FixSample(0, 48.0, 11.0, 500.0)
FIELD = np.array(earth_field(FIX))
UP = np.array([0.0, 0.0, 9.80665])
Sent = list[tuple[str, Sample]]


def resting(
    compass: Compass,
    seconds: tuple[float, float],
    yaw: Callable[[float], float],
    disturbance: tuple[float, float, float] = (0.0, 0.0, 0.0),
    bias: float = 0.0,
) -> None:
    """A body at one place that turns about Up, tilted by nothing: IMU 50 Hz, compass 10 Hz."""
    for k in range(round(seconds[0] * 50), round(seconds[1] * 50)):
        t = k / 50
        rate = (yaw(t + 1e-3) - yaw(t - 1e-3)) / 2e-3 + bias
        stamp = k * SECOND // 50
        compass.imu(ImuSample(stamp, (0.0, 0.0, rate), (0.0, 0.0, 9.80665)))
        if k % 5 == 0:
            turn = Rotation.from_euler("Z", yaw(t))
            seen = turn.inv().apply(FIELD) + disturbance
            compass.mag(MagneticSample(stamp, (float(seen[0]), float(seen[1]), float(seen[2]))))


def off(compass: Compass, yaw: float) -> float:
    """Error of the heading, degrees."""
    return abs(math.degrees(math.remainder(compass.heading - yaw, math.tau)))


def test_the_field_agrees_with_the_declination() -> None:
    east, north, up = earth_field(FIX)
    assert math.atan2(east, north) == pytest.approx(declination(48.0, 11.0, 500.0))
    assert math.hypot(east, north, up) == pytest.approx(48.5e-6, abs=1e-6)
    assert up < 0.0


@settings(max_examples=10)
@given(st.floats(-math.pi, math.pi))
def test_a_body_at_rest_points_where_it_points(yaw: float) -> None:
    compass = Compass(earth_field(FIX))
    assert not compass.aligned
    resting(compass, (0.0, 3.0), lambda _: yaw)
    assert compass.aligned
    assert off(compass, yaw) < 0.1


def test_a_spin_of_several_turns() -> None:
    compass = Compass(earth_field(FIX))
    resting(compass, (0.0, 5.0), lambda _: 0.3)
    before = compass.gyro_heading
    resting(compass, (5.0, 15.0), lambda t: 0.3 + 2.0 * (t - 5.0))
    assert off(compass, 0.3 + 2.0 * (14.98 - 5.0)) < 2.0
    assert compass.gyro_heading - before == pytest.approx(20.0, abs=0.1)


def test_the_gyro_bias_is_learnt_slowly_and_within_bounds() -> None:
    compass = Compass(earth_field(FIX))
    resting(compass, (0.0, 60.0), lambda _: 1.0, bias=math.radians(0.5))
    assert math.degrees(compass.gyro_bias[2]) == pytest.approx(0.5, abs=0.1)
    broken = Compass(earth_field(FIX))
    resting(broken, (0.0, 60.0), lambda _: 1.0, bias=math.radians(30.0))
    assert all(abs(bias) <= 0.05 for bias in broken.gyro_bias)


def test_a_disturbed_field_is_not_used_and_is_the_new_field_after_a_minute() -> None:
    compass = Compass(earth_field(FIX))
    resting(compass, (0.0, 10.0), lambda _: 0.0)
    resting(compass, (10.0, 30.0), lambda _: 0.0, disturbance=(20e-6, 0.0, 0.0))
    assert off(compass, 0.0) < 0.5
    resting(compass, (30.0, 80.0), lambda _: 0.0, disturbance=(20e-6, 0.0, 0.0))
    assert off(compass, 0.0) > 20.0


def test_a_gap_of_the_imu_begins_afresh() -> None:
    compass = Compass(earth_field(FIX))
    resting(compass, (0.0, 5.0), lambda _: 0.0)
    assert not compass.imu(ImuSample(8 * SECOND, (0.0, 0.0, 0.0), (0.0, 0.0, 9.8)))
    assert not compass.aligned


def test_a_field_of_nothing_is_left_out() -> None:
    compass = Compass(earth_field(FIX))
    resting(compass, (0.0, 5.0), lambda _: 0.0)
    assert compass.mag(MagneticSample(6 * SECOND, (0.0, 0.0, 0.0))) is None
    assert off(compass, 0.0) < 0.1


def test_on_a_simulated_flight_without_gps(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    curved = flight("curved", 1)
    compass = Compass(earth_field(curved.fixes[0]))
    stamps, headings, turns = [], [], []
    for _, sample in samples(curved, "imu", "mag"):
        if isinstance(sample, MagneticSample):
            compass.mag(sample)
            stamps.append(sample.stamp_ns)
            headings.append(compass.heading)
            turns.append(compass.gyro_heading)
        elif isinstance(sample, ImuSample):
            compass.imu(sample)
    rows = np.searchsorted(curved.motion.offsets_ns, np.array(stamps) - curved.plan.start_ns)
    truth = np.unwrap(Rotation.from_quat(curved.motion.quaternion[rows]).as_euler("ZYX")[:, 0])
    wrapped = np.degrees((np.array(headings) - truth + math.pi) % math.tau - math.pi)
    assert np.max(np.abs(wrapped[100:])) < 12.0
    drift = np.degrees(np.array(turns) - truth)[100:]
    assert max(abs(b - a) for a, b in itertools.pairwise(drift[::100])) < 5.0
