# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the border lets in: messages as rosbags decodes them, with every kind of bad value."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from hijack_detect.streams.messages import CONVERTERS, BadMessage, attitude_sample
from hijack_detect.streams.samples import (
    AttitudeSample,
    CourseSample,
    FixSample,
    ImuSample,
    MagneticSample,
    PressureSample,
    VelocitySample,
)

TYPES = get_typestore(Stores.ROS2_JAZZY).types
STAMP_NS = 1_700_000_000_123_456_789
BAD = [math.nan, math.inf, -math.inf]


def header() -> Any:
    time = TYPES["builtin_interfaces/msg/Time"](sec=1_700_000_000, nanosec=123_456_789)
    return TYPES["std_msgs/msg/Header"](stamp=time, frame_id="anything")


def vector(x: float, y: float, z: float) -> Any:
    return TYPES["geometry_msgs/msg/Vector3"](x=x, y=y, z=z)


def quaternion(x: float, y: float, z: float, w: float) -> Any:
    return TYPES["geometry_msgs/msg/Quaternion"](x=x, y=y, z=z, w=w)


def imu(orientation: Any = None, covariance: tuple[float, ...] = (-1.0,) + (0.0,) * 8) -> Any:
    return TYPES["sensor_msgs/msg/Imu"](
        header=header(),
        orientation=orientation or quaternion(0.0, 0.0, 0.0, 1.0),
        orientation_covariance=np.array(covariance),
        angular_velocity=vector(0.1, -0.2, 0.3),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=vector(1.0, -2.0, 9.8),
        linear_acceleration_covariance=np.zeros(9),
    )


def fix(latitude: float = -35.3, longitude: float = 149.1, status: int = 0) -> Any:
    return TYPES["sensor_msgs/msg/NavSatFix"](
        header=header(),
        status=TYPES["sensor_msgs/msg/NavSatStatus"](status=status, service=1),
        latitude=latitude,
        longitude=longitude,
        altitude=584.5,
        position_covariance=np.zeros(9),
        position_covariance_type=0,
    )


def velocity() -> Any:
    twist = TYPES["geometry_msgs/msg/Twist"](linear=vector(3.0, -4.0, 0.5), angular=vector(0, 0, 0))
    return TYPES["geometry_msgs/msg/TwistStamped"](header=header(), twist=twist)


def magnetic() -> Any:
    return TYPES["sensor_msgs/msg/MagneticField"](
        header=header(),
        magnetic_field=vector(2e-5, -1e-5, -4e-5),
        magnetic_field_covariance=np.zeros(9),
    )


def pressure(pascal: float = 95_000.5) -> Any:
    return TYPES["sensor_msgs/msg/FluidPressure"](
        header=header(), fluid_pressure=pascal, variance=0.0
    )


def course(z: float = 0.6, w: float = 0.8) -> Any:
    return TYPES["geometry_msgs/msg/QuaternionStamped"](
        header=header(), quaternion=quaternion(0.0, 0.0, z, w)
    )


GOOD: dict[str, tuple[Callable[[], Any], Any]] = {
    "imu": (imu, ImuSample(STAMP_NS, (0.1, -0.2, 0.3), (1.0, -2.0, 9.8))),
    "fix": (fix, FixSample(STAMP_NS, -35.3, 149.1, 584.5)),
    "velocity": (velocity, VelocitySample(STAMP_NS, (3.0, -4.0, 0.5))),
    "mag": (magnetic, MagneticSample(STAMP_NS, (2e-5, -1e-5, -4e-5))),
    "pressure": (pressure, PressureSample(STAMP_NS, 95_000.5)),
    "attitude": (
        imu,
        AttitudeSample(STAMP_NS, None, math.inf, (0.1, -0.2, 0.3), (1.0, -2.0, 9.8)),
    ),
    "course": (course, CourseSample(STAMP_NS, 0.6, 0.8)),
}
FIELDS = {
    "imu": [
        *(f"angular_velocity.{axis}" for axis in "xyz"),
        *(f"linear_acceleration.{axis}" for axis in "xyz"),
    ],
    "fix": ["latitude", "longitude"],
    "velocity": [f"twist.linear.{axis}" for axis in "xy"],
    "mag": [f"magnetic_field.{axis}" for axis in "xyz"],
    "pressure": ["fluid_pressure"],
    "attitude": [
        *(f"angular_velocity.{axis}" for axis in "xyz"),
        *(f"linear_acceleration.{axis}" for axis in "xyz"),
    ],
    "course": ["quaternion.z", "quaternion.w"],
}


def set_field(message: Any, path: str, value: float) -> None:
    *parents, last = path.split(".")
    for parent in parents:
        message = getattr(message, parent)
    object.__setattr__(message, last, value)


def test_every_converter_is_tested() -> None:
    assert {*GOOD, "phase"} == {*CONVERTERS} == {*FIELDS, "phase"}  # phase: test_phase_message


@pytest.mark.parametrize("name", GOOD)
def test_good_values_pass_unchanged(name: str) -> None:
    make, expected = GOOD[name]
    assert CONVERTERS[name](make()) == expected


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize(("name", "path"), [(n, p) for n, paths in FIELDS.items() for p in paths])
def test_non_finite_values_are_refused_by_name(name: str, path: str, value: float) -> None:
    message = GOOD[name][0]()
    set_field(message, path, value)
    with pytest.raises(BadMessage, match=path.rsplit(".", 1)[-1]) as refusal:
        CONVERTERS[name](message)
    assert str(value) in str(refusal.value)


def test_nan_says_that_height_or_climb_was_not_measured() -> None:
    position, speed = fix(), velocity()
    position.altitude = speed.twist.linear.z = math.nan
    assert not CONVERTERS["fix"](position).has_altitude
    assert CONVERTERS["velocity"](speed).velocity[:2] == (3.0, -4.0)
    assert not CONVERTERS["velocity"](speed).has_vertical
    for message, path in ((position, "altitude"), (speed, "twist.linear.z")):
        set_field(message, path, math.inf)
    for name, message in (("fix", position), ("velocity", speed)):
        with pytest.raises(BadMessage, match="inf"):
            CONVERTERS[name](message)


@pytest.mark.parametrize(
    ("kind", "diagonal", "claims"),
    [
        (2, (4.0, 4.0, 9.0), (2.0, 3.0)),
        (2, (4.0, 4.0, 0.0), (2.0, None)),
        (3, (0.0, 0.0, 0.0), (None, None)),
        (2, (math.nan,) * 3, (None, None)),
        (2, (1e12,) * 3, (None, None)),
        (2, (-1.0, 0.0, -1.0), (None, None)),
        (0, (-1.0, 0.0, 0.0), (None, None)),
    ],
)
def test_only_a_claim_is_an_accuracy(
    kind: int, diagonal: tuple[float, float, float], claims: tuple[float | None, float | None]
) -> None:
    message = fix()
    message.position_covariance_type = kind
    message.position_covariance = np.diag(diagonal).ravel()
    found = CONVERTERS["fix"](message)
    assert (found.accuracy_m, found.vertical_accuracy_m) == claims


@pytest.mark.parametrize(
    ("name", "path", "value"),
    [
        ("fix", "latitude", 91.0),
        ("fix", "latitude", -90.0001),
        ("fix", "longitude", 181.0),
        ("fix", "longitude", -180.0001),
        ("fix", "altitude", 1e6),
        ("imu", "angular_velocity.z", 1e3),
        ("imu", "linear_acceleration.x", 1e6),
        ("velocity", "twist.linear.y", -1e6),
        ("mag", "magnetic_field.x", 25.0),
        ("pressure", "fluid_pressure", 950.0),
        ("pressure", "fluid_pressure", 120_001.0),
        ("course", "quaternion.z", 1.5),
    ],
)
def test_impossible_values_are_refused(name: str, path: str, value: float) -> None:
    message = GOOD[name][0]()
    set_field(message, path, value)
    with pytest.raises(BadMessage, match=path.rsplit(".", 1)[-1]):
        CONVERTERS[name](message)


@pytest.mark.parametrize(
    ("latitude", "longitude"), [(90.0, 180.0), (-90.0, -180.0), (0.0, 0.0), (48.1, -11.5)]
)
def test_the_ends_of_the_globe_are_on_it(latitude: float, longitude: float) -> None:
    sample = CONVERTERS["fix"](fix(latitude, longitude))
    assert (sample.latitude_deg, sample.longitude_deg) == (latitude, longitude)
    assert sample.has_fix


@pytest.mark.parametrize("status", [-1, -2])
def test_no_fix_keeps_its_stamp_and_loses_its_position(status: int) -> None:
    sample = CONVERTERS["fix"](fix(math.nan, math.nan, status))
    assert not sample.has_fix
    assert sample.stamp_ns == STAMP_NS
    assert math.isfinite(sample.latitude_deg)


def test_a_first_covariance_of_minus_one_means_no_orientation() -> None:
    sample = attitude_sample(imu(quaternion(0.0, 0.0, 0.0, 0.0)))
    assert sample.orientation is None
    assert sample.heading_variance == math.inf


def test_an_orientation_comes_with_its_heading_variance() -> None:
    covariance = (0.01, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.03)
    sample = attitude_sample(imu(quaternion(0.5, -0.5, 0.5, -0.5), covariance))
    assert sample.orientation == (0.5, -0.5, 0.5, -0.5)
    assert sample.heading_variance == 0.03


@pytest.mark.parametrize(
    "values",
    [
        (0.0, 0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0, 2.0),
        (0.0, 0.0, 0.5, 0.5),
        *[(bad, 0.0, 0.0, 1.0) for bad in BAD],
        *[(0.0, 0.0, 0.0, bad) for bad in BAD],
    ],
)
def test_an_orientation_that_is_no_rotation_is_refused(values: tuple[float, ...]) -> None:
    with pytest.raises(BadMessage, match="norm"):
        attitude_sample(imu(quaternion(*values), (0.01,) * 9))


def test_a_course_of_zeros_is_not_observable() -> None:
    assert not CONVERTERS["course"](course(0.0, 0.0)).observable
    assert CONVERTERS["course"](course(0.0, 1.0)).observable


@given(st.integers(0, 2**31 - 1), st.integers(0, 999_999_999))
def test_stamps_keep_every_nanosecond(seconds: int, nanoseconds: int) -> None:
    message = velocity()
    stamp = TYPES["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
    object.__setattr__(message.header, "stamp", stamp)
    assert CONVERTERS["velocity"](message).stamp_ns == seconds * 10**9 + nanoseconds


@given(st.floats(allow_nan=True, allow_infinity=True))
def test_no_latitude_off_the_globe_gets_in(latitude: float) -> None:
    if -90.0 <= latitude <= 90.0:
        assert CONVERTERS["fix"](fix(latitude)).latitude_deg == latitude
    else:
        with pytest.raises(BadMessage, match="latitude"):
            CONVERTERS["fix"](fix(latitude))
