# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From samples to ROS messages: the inverse of `streams.messages`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hijack_detect.bags.reader import typestore
from hijack_detect.streams.messages import (
    APPROXIMATED,
    UNKNOWN,
    position_covariance,
)
from hijack_detect.streams.samples import (
    NANOSECONDS,
    AttitudeSample,
    CourseSample,
    FixSample,
    ImuSample,
    MagneticSample,
    PressureSample,
    Quaternion,
    Sample,
    SatelliteSample,
    Vector3,
    VelocitySample,
)

BODY_FRAME = "base_link"
GPS_FRAME = "gps"
WORLD_FRAME = "map"


def encode_sample(sample: Sample) -> tuple[str, bytes]:
    """Return message type and CDR bytes of a sample.

    Covariances that a sample does not carry are zero, which in ROS means unknown. A raw
    ImuSample says with a first orientation covariance of -1 that it has no orientation
    (REP-145).

    Raises:
        TypeError: It is no sample.
    """
    if isinstance(sample, ImuSample):
        return _imu(sample, (0.0, 0.0, 0.0, 1.0), -1.0, 0.0)
    if isinstance(sample, AttitudeSample):
        if sample.orientation is None:
            return _imu(sample, (0.0, 0.0, 0.0, 1.0), -1.0, 0.0)
        return _imu(sample, sample.orientation, 0.0, sample.heading_variance)
    if isinstance(sample, FixSample):
        return _fix(sample)
    if isinstance(sample, SatelliteSample):
        return encode_count(sample.count)
    if isinstance(sample, VelocitySample):
        twist = _make(
            "geometry_msgs/msg/Twist",
            linear=_vector(sample.velocity),
            angular=_vector((0.0, 0.0, 0.0)),
        )
        return _encode(
            "geometry_msgs/msg/TwistStamped",
            header=_header(sample.stamp_ns, WORLD_FRAME),
            twist=twist,
        )
    if isinstance(sample, PressureSample):
        return encode_pressure(sample.stamp_ns, sample.pressure_pa)
    if isinstance(sample, MagneticSample):
        return _encode(
            "sensor_msgs/msg/MagneticField",
            header=_header(sample.stamp_ns, BODY_FRAME),
            magnetic_field=_vector(sample.field),
            magnetic_field_covariance=np.zeros(9),
        )
    if isinstance(sample, CourseSample):
        return encode_orientation(sample.stamp_ns, (0.0, 0.0, sample.qz, sample.qw))
    raise TypeError(f"{sample!r} is no sample")


def encode_orientation(stamp_ns: int, quaternion: Quaternion) -> tuple[str, bytes]:
    """Return `geometry_msgs/QuaternionStamped`, a rotation from FLU to ENU as (x, y, z, w)."""
    return _encode(
        "geometry_msgs/msg/QuaternionStamped",
        header=_header(stamp_ns, WORLD_FRAME),
        quaternion=_quaternion(quaternion),
    )


def encode_pressure(stamp_ns: int, pascal: float) -> tuple[str, bytes]:
    """Return `sensor_msgs/FluidPressure`: static pressure in pascal."""
    return _encode(
        "sensor_msgs/msg/FluidPressure",
        header=_header(stamp_ns, BODY_FRAME),
        fluid_pressure=float(pascal),
        variance=0.0,
    )


def encode_count(value: int) -> tuple[str, bytes]:
    """Return `std_msgs/UInt32`, which has no stamp: the log time is its time."""
    return _encode("std_msgs/msg/UInt32", data=int(value))


def encode_bool(value: bool) -> tuple[str, bytes]:
    """Return `std_msgs/Bool`, which has no stamp: the log time is its time."""
    return _encode("std_msgs/msg/Bool", data=bool(value))


def _imu(
    sample: ImuSample | AttitudeSample,
    orientation: Quaternion,
    first_covariance: float,
    heading_variance: float,
) -> tuple[str, bytes]:
    covariance = np.zeros(9)
    covariance[0] = first_covariance
    covariance[8] = heading_variance
    return _encode(
        "sensor_msgs/msg/Imu",
        header=_header(sample.stamp_ns, BODY_FRAME),
        orientation=_quaternion(orientation),
        orientation_covariance=covariance,
        angular_velocity=_vector(sample.angular_velocity),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=_vector(sample.specific_force),
        linear_acceleration_covariance=np.zeros(9),
    )


def _fix(sample: FixSample) -> tuple[str, bytes]:
    latitude, longitude, altitude = sample.latitude_deg, sample.longitude_deg, sample.altitude_m
    if not sample.has_fix:
        latitude = longitude = altitude = math.nan
    claims = (sample.accuracy_m, sample.vertical_accuracy_m)
    return _encode(
        "sensor_msgs/msg/NavSatFix",
        header=_header(sample.stamp_ns, GPS_FRAME),
        status=_make("sensor_msgs/msg/NavSatStatus", status=0 if sample.has_fix else -1, service=1),
        latitude=latitude,
        longitude=longitude,
        altitude=altitude,
        position_covariance=position_covariance(sample.accuracy_m, sample.vertical_accuracy_m),
        position_covariance_type=UNKNOWN if claims == (None, None) else APPROXIMATED,
    )


def _header(stamp_ns: int, frame: str) -> Any:
    seconds, nanoseconds = divmod(stamp_ns, NANOSECONDS)
    stamp = _make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)
    return _make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def _vector(vector: Vector3) -> Any:
    return _make("geometry_msgs/msg/Vector3", x=vector[0], y=vector[1], z=vector[2])


def _quaternion(quaternion: Quaternion) -> Any:
    x, y, z, w = quaternion
    return _make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)


def _make(msgtype: str, **fields: Any) -> Any:
    return typestore().types[msgtype](**fields)


def _encode(msgtype: str, **fields: Any) -> tuple[str, bytes]:
    return msgtype, bytes(typestore().serialize_cdr(_make(msgtype, **fields), msgtype))
