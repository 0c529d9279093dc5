# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The inputs of a column map: which columns each has, and the sample that their numbers make."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from pydantic import Field, model_validator

from hijack_detect.logs.csv_units import ANGLE, FIELD, FORCE, LENGTH, PLACE, PRESSURE, RATE, SPEED
from hijack_detect.logs.csv_words import (
    Angle,
    Body,
    Column,
    Fields,
    Forces,
    HasFix,
    Length,
    PlaceAngle,
    Pressure,
    Rates,
    Speed,
    Speeds,
    Strictly,
    Time,
    World,
)
from hijack_detect.logs.frames import attitude, enu, flu, from_angles
from hijack_detect.logs.logged import ATTITUDE, Logged, fix_sample
from hijack_detect.streams.samples import (
    FixSample,
    ImuSample,
    MagneticSample,
    PressureSample,
    Quaternion,
    SatelliteSample,
    Vector3,
    VelocitySample,
)

Numbers = Sequence[float]


class Input(Strictly):
    """Keys of every input."""

    file: str | None = Field(None, min_length=1)
    """Its file, beside the others; without, the file that the command names."""
    time: Time | None = None
    """Its own time; without, that of the map."""
    when_changed: bool = False
    """Take a row only if its columns differ from those of the row before."""

    @property
    def optional(self) -> int:
        """How many of the last columns may be empty, which makes their number NaN."""
        return 0

    def columns(self) -> list[Column]:
        """Columns of the numbers, in the order in which `logged` takes them."""
        raise NotImplementedError

    def logged(self, stamp_ns: int, values: Numbers) -> Logged:
        """The reading that the numbers of a row make."""
        raise NotImplementedError


class Imu(Input):
    """Gyroscope and accelerometer (specific force: at rest it points up)."""

    gyro: Rates
    accel: Forces
    frame: Body

    def columns(self) -> list[Column]:
        """See Input."""
        return [*self.gyro.columns, *self.accel.columns]

    def logged(self, stamp_ns: int, values: Numbers) -> Logged:
        """See Input."""
        gyro = _body(self.frame, values[:3], RATE[self.gyro.unit])
        force = _body(self.frame, values[3:], FORCE[self.accel.unit])
        return Logged("imu", stamp_ns, ImuSample(stamp_ns, gyro, force))


class Fix(Input):
    """Position of the receiver, and the standard deviation it claims for East and North."""

    latitude: PlaceAngle
    longitude: PlaceAngle
    altitude: Length
    accuracy: Length | None = None
    has_fix: HasFix | None = None

    @property
    def optional(self) -> int:
        """See Input."""
        return 0 if self.accuracy is None else 1

    def columns(self) -> list[Column]:
        """See Input."""
        more = [] if self.accuracy is None else [self.accuracy.column]
        return [self.latitude.column, self.longitude.column, self.altitude.column, *more]

    def logged(self, stamp_ns: int, values: Numbers) -> Logged:
        """See Input."""
        latitude = values[0] * PLACE[self.latitude.unit]
        longitude = values[1] * PLACE[self.longitude.unit]
        height = values[2] * LENGTH[self.altitude.unit]
        accuracy = values[3] * LENGTH[self.accuracy.unit] if self.accuracy else math.nan
        place = (latitude, longitude, height)
        return Logged("fix", stamp_ns, fix_sample(stamp_ns, place, accuracy, has_fix=True))

    def none(self, stamp_ns: int) -> Logged:
        """A fix without a position."""
        return Logged("fix", stamp_ns, FixSample(stamp_ns, 0.0, 0.0, 0.0, has_fix=False))


class Velocity(Input):
    """Velocity of the receiver: three axes, or speed over ground, course and climb."""

    axes: Speeds | None = None
    frame: World | None = None
    speed: Speed | None = None
    course: Angle | None = None
    """Clockwise from North."""
    climb: Speed | None = None
    """Upwards; left out, or empty in a row, where the receiver does not measure it."""

    @model_validator(mode="after")
    def _check_one_way(self) -> Velocity:
        axes, polar = (self.axes, self.frame), (self.speed, self.course, self.climb)
        if (None not in axes and polar == (None,) * 3) or (
            None not in polar[:2] and axes == (None,) * 2
        ):
            return self
        raise ValueError("give axes and frame (ENU or NED), or speed, course and climb")

    @property
    def optional(self) -> int:
        """See Input: the vertical component."""
        return 1 if self.axes is not None or self.climb is not None else 0

    def columns(self) -> list[Column]:
        """See Input."""
        if self.axes is not None:
            return list(self.axes.columns)
        polar = (self.speed, self.course, self.climb)
        return [one.column for one in polar if one is not None]

    def logged(self, stamp_ns: int, values: Numbers) -> Logged:
        """See Input."""
        a, b, *_ = values
        velocity: Vector3
        if self.axes is not None:
            a, b, c = (one * SPEED[self.axes.unit] for one in values)
            velocity = (a, b, c) if self.frame == "ENU" else enu(a, b, c)
        else:
            assert self.speed is not None
            assert self.course is not None
            speed, course = a * SPEED[self.speed.unit], b * ANGLE[self.course.unit]
            up = math.nan if self.climb is None else values[2] * SPEED[self.climb.unit]
            velocity = (speed * math.sin(course), speed * math.cos(course), up)
        return Logged("velocity", stamp_ns, VelocitySample(stamp_ns, velocity))


class Satellites(Input):
    """Number of satellites in use."""

    column: Column

    def columns(self) -> list[Column]:
        """See Input."""
        return [self.column]

    def logged(self, stamp_ns: int, values: Numbers) -> Logged:
        """See Input."""
        return Logged("satellites", stamp_ns, SatelliteSample(stamp_ns, round(values[0])))


class Mag(Input):
    """Magnetometer."""

    field: Fields
    frame: Body

    def columns(self) -> list[Column]:
        """See Input."""
        return list(self.field.columns)

    def logged(self, stamp_ns: int, values: Numbers) -> Logged:
        """See Input."""
        field = _body(self.frame, values, FIELD[self.field.unit])
        return Logged("mag", stamp_ns, MagneticSample(stamp_ns, field))


class Barometer(Input):
    """Static pressure."""

    pressure: Pressure

    def columns(self) -> list[Column]:
        """See Input."""
        return [self.pressure.column]

    def logged(self, stamp_ns: int, values: Numbers) -> Logged:
        """See Input."""
        pascal = values[0] * PRESSURE[self.pressure.unit]
        return Logged("pressure", stamp_ns, PressureSample(stamp_ns, pascal))


class Attitude(Input):
    """The autopilot's own attitude: a quaternion from body to world, or its angles."""

    quaternion: list[Column] | None = Field(None, min_length=4, max_length=4)
    order: Literal["wxyz", "xyzw"] = "wxyz"
    roll: Angle | None = None
    pitch: Angle | None = None
    yaw: Angle | None = None
    frame: Literal["FRD to NED", "FLU to ENU"] = "FRD to NED"

    @model_validator(mode="after")
    def _check_one_way(self) -> Attitude:
        angles = (self.roll, self.pitch, self.yaw)
        if self.quaternion is not None and angles == (None,) * 3:
            return self
        if self.quaternion is None and None not in angles and self.frame == "FRD to NED":
            return self
        raise ValueError("give quaternion, or roll, pitch and yaw of FRD to NED")

    def columns(self) -> list[Column]:
        """See Input."""
        if self.quaternion is not None:
            return list(self.quaternion)
        return [one.column for one in (self.roll, self.pitch, self.yaw) if one is not None]

    def logged(self, stamp_ns: int, values: Numbers) -> Logged:
        """See Input."""
        if self.quaternion is None:
            units = [one.unit for one in (self.roll, self.pitch, self.yaw) if one is not None]
            angles = (one * ANGLE[unit] for one, unit in zip(values, units, strict=True))
            return Logged(ATTITUDE, stamp_ns, from_angles(*angles))
        norm = math.hypot(*values) or math.nan
        w, x, y, z = (one / norm for one in values)
        given: Quaternion = (x, y, z, w) if self.order == "wxyz" else (w, x, y, z)
        return Logged(ATTITUDE, stamp_ns, given if self.frame == "FLU to ENU" else attitude(given))


def _body(frame: str, values: Numbers, scale: float) -> Vector3:
    x, y, z = (one * scale for one in values)
    return (x, y, z) if frame == "FLU" else flu(x, y, z)
