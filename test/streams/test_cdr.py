# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Stamps and Imu read from bytes are those of the message, as rosbags and rclpy write it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import Imu

from hijack_detect.streams.cdr import (
    FROM_BYTES,
    attitude_from_bytes,
    imu_from_bytes,
    stamp_from_bytes,
    with_stamp,
)
from hijack_detect.streams.messages import CONVERTERS, BadMessage, header_stamp_ns
from hijack_detect.streams.samples import NANOSECONDS

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES = STORE.types
NAME = "sensor_msgs/msg/Imu"
numbers = st.floats(allow_nan=True, allow_infinity=True)
names = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=20)
vectors = st.tuples(numbers, numbers, numbers)


def made(
    frame: str,
    orientation: tuple[float, ...] = (0.0, 0.6, 0.0, 0.8),
    covariance: tuple[float, ...] = (0.1,) * 9,
    rate: tuple[float, ...] = (0.1, -0.2, 0.3),
    force: tuple[float, ...] = (1.0, -2.0, 9.8),
) -> Any:
    vector, quaternion = TYPES["geometry_msgs/msg/Vector3"], TYPES["geometry_msgs/msg/Quaternion"]
    time = TYPES["builtin_interfaces/msg/Time"](sec=1_700_000_000, nanosec=123_456_789)
    return TYPES[NAME](
        header=TYPES["std_msgs/msg/Header"](stamp=time, frame_id=frame),
        orientation=quaternion(*orientation),
        orientation_covariance=np.array(covariance),
        angular_velocity=vector(*rate),
        angular_velocity_covariance=np.full(9, 0.2),
        linear_acceleration=vector(*force),
        linear_acceleration_covariance=np.full(9, 0.3),
    )


def written(message: Any, *, little_endian: bool = True) -> bytes:
    return bytes(STORE.serialize_cdr(message, NAME, little_endian=little_endian))


def said(convert: Any, given: Any) -> Any:
    """The sample, or why there is none."""
    try:
        return convert(given)
    except BadMessage as error:
        return str(error)


@pytest.mark.parametrize("name", FROM_BYTES)
@given(frame=names, covariance=st.tuples(*[numbers] * 9), rate=vectors, force=vectors)
def test_bytes_say_what_the_message_says(
    name: str,
    frame: str,
    covariance: tuple[float, ...],
    rate: tuple[float, ...],
    force: tuple[float, ...],
) -> None:
    message = made(frame, covariance=covariance, rate=rate, force=force)
    assert said(FROM_BYTES[name], written(message)) == said(CONVERTERS[name], message)


@pytest.mark.parametrize("name", FROM_BYTES)
@pytest.mark.parametrize("frame", ["", "a", "imu", "base_link", "imu_link_1", "x" * 255])
def test_bytes_of_rclpy_are_read(name: str, frame: str) -> None:
    message = Imu()
    message.header.frame_id, message.header.stamp.sec = frame, -1
    message.header.stamp.nanosec = 999_999_999
    message.orientation.x, message.orientation.w = 0.6, 0.8
    message.orientation_covariance[0], message.orientation_covariance[8] = 0.5, 0.25
    message.angular_velocity.y, message.linear_acceleration.z = 0.125, 9.75
    found = FROM_BYTES[name](serialize_message(message))
    assert found == CONVERTERS[name](message)
    assert found.stamp_ns == -1
    assert found.specific_force == (0.0, 0.0, 9.75)


def test_an_attitude_is_read() -> None:
    found = attitude_from_bytes(written(made("imu")))
    assert found is not None
    assert found.orientation == (0.0, 0.6, 0.0, 0.8)
    assert found.heading_variance == 0.1
    unknown = attitude_from_bytes(written(made("imu", covariance=(-1.0, *[0.0] * 8))))
    assert unknown is not None
    assert unknown.orientation is None
    assert math.isinf(unknown.heading_variance)
    with pytest.raises(BadMessage, match=r"norm 1\.5, not 1"):
        attitude_from_bytes(written(made("imu", orientation=(1.5, 0.0, 0.0, 0.0))))


@pytest.mark.parametrize("read", FROM_BYTES.values())
def test_another_layout_is_left_to_the_message(read: Any) -> None:
    whole = written(made("imu"))
    assert read(whole) is not None
    assert read(written(made("imu"), little_endian=False)) is None
    assert read(b"\x00\x03" + whole[2:]) is None  # parameter list
    assert all(read(whole[:size]) is None for size in range(len(whole)))


def test_a_frame_name_longer_than_the_message_is_left_to_the_message() -> None:
    whole = bytearray(written(made("imu")))
    whole[12:16] = (2**32 - 1).to_bytes(4, "little")
    assert imu_from_bytes(bytes(whole)) is None


@given(
    frame=names,
    little_endian=st.booleans(),
    stamp_ns=st.integers(-(2**31) * NANOSECONDS, 2**31 * NANOSECONDS - 1),
)
def test_a_stamp_is_read_and_replaced_where_the_message_has_it(
    frame: str, little_endian: bool, stamp_ns: int
) -> None:
    data = written(made(frame), little_endian=little_endian)
    assert stamp_from_bytes(data) == 1_700_000_000_123_456_789
    changed = with_stamp(data, stamp_ns)
    assert stamp_from_bytes(changed) == stamp_ns
    message = STORE.deserialize_cdr(changed, NAME)
    assert header_stamp_ns(message) == stamp_ns
    assert changed[:4] + changed[12:] == data[:4] + data[12:]


def test_bytes_too_short_for_a_stamp_have_none() -> None:
    whole = written(made("imu"))
    assert stamp_from_bytes(whole[:12]) is not None
    assert all(stamp_from_bytes(whole[:size]) is None for size in range(12))
