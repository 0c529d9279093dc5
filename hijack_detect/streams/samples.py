# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The samples that travel between the parts of the monitor.

Every sample carries the header stamp of its message in integer nanoseconds, so that no
precision is lost and decisions made on stamps are reproducible to the bit. Vectors are plain
tuples of floats: body vectors in FLU (x forward, y left, z up), world vectors in ENU (REP-103).
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import TypeAlias

Vector3: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]
"""Quaternion as (x, y, z, w), the order of geometry_msgs."""

NANOSECONDS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class ImuSample:
    """One raw `sensor_msgs/Imu`: angular velocity (rad/s) and specific force (m/s²), FLU."""

    stamp_ns: int
    angular_velocity: Vector3
    specific_force: Vector3


@dataclass(frozen=True, slots=True)
class FixSample:
    """One `sensor_msgs/NavSatFix`: WGS-84 geodetic position.

    Latitude and longitude stay in degrees, as in the message, so that a fix that is only
    passed on is not rounded. `altitude_m` is NaN where no height was measured. `has_fix` is false
    when the receiver reports no fix. `accuracy_m` is the standard deviation that the receiver
    claims for East and North, `vertical_accuracy_m` that for the height; None if it claims none.
    `clock_offset_ns` was taken off the stamp of its message, see `ReceiverClock`.
    """

    stamp_ns: int
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    has_fix: bool = True
    accuracy_m: float | None = None
    vertical_accuracy_m: float | None = None
    clock_offset_ns: int = 0

    @property
    def has_altitude(self) -> bool:
        """Whether the height was measured."""
        return not math.isnan(self.altitude_m)


@dataclass(frozen=True, slots=True)
class VelocitySample:
    """One GPS velocity, `geometry_msgs/TwistStamped`: m/s in ENU.

    The vertical component is NaN where the receiver does not measure it.
    """

    stamp_ns: int
    velocity: Vector3

    @property
    def has_vertical(self) -> bool:
        """Whether the vertical velocity was measured."""
        return not math.isnan(self.velocity[2])


@dataclass(frozen=True, slots=True)
class SatelliteSample:
    """One number of satellites in use, `std_msgs/UInt32`, with the stamp of the fix it is of."""

    stamp_ns: int
    count: int


@dataclass(frozen=True, slots=True)
class MagneticSample:
    """One `sensor_msgs/MagneticField`: tesla, FLU."""

    stamp_ns: int
    field: Vector3


@dataclass(frozen=True, slots=True)
class PressureSample:
    """One `sensor_msgs/FluidPressure`: static pressure of the barometer, pascal."""

    stamp_ns: int
    pressure_pa: float


@dataclass(frozen=True, slots=True)
class AttitudeSample:
    """One `sensor_msgs/Imu` with orientation (REP-145), the attitude estimator's output.

    `orientation` turns FLU vectors into ENU; it is None until the estimator knows its heading.
    `heading_variance` is in rad². Angular velocity and specific force are the raw readings.
    """

    stamp_ns: int
    orientation: Quaternion | None
    heading_variance: float
    angular_velocity: Vector3
    specific_force: Vector3


@dataclass(frozen=True, slots=True)
class CourseSample:
    """Direction of motion over ground as a rotation about Up, `geometry_msgs/QuaternionStamped`.

    The course angle is `2 atan2(qz, qw)`, counter-clockwise from East (REP-103). Both parts are
    zero where the course is not observable, which no rotation is.
    """

    stamp_ns: int
    qz: float
    qw: float

    @property
    def observable(self) -> bool:
        """True where the vehicle moved fast enough for its course to be known."""
        return self.qz != 0.0 or self.qw != 0.0

    @property
    def angle(self) -> float:
        """Course in radians, counter-clockwise from East, within [-2π, 2π]."""
        return 2.0 * math.atan2(self.qz, self.qw)


class Phase(enum.Enum):
    """Phase of the flight, by the flight-phase estimator."""

    UNKNOWN = "unknown"
    """Too little data yet."""
    STANDING = "standing"
    """At rest on the ground."""
    HANDLED = "handled"
    """Turned about or carried by hand."""
    FLYING = "flying"
    """In the air, hover included."""
    LANDING = "landing"
    """In the air, sinking slowly just above the height of the take-off."""
    CRASHED = "crashed"
    """Lies on its side or back after a flight."""

    @property
    def airborne(self) -> bool:
        """Whether the vehicle is in the air."""
        return self in (Phase.FLYING, Phase.LANDING)


@dataclass(frozen=True, slots=True)
class PhaseSample:
    """Phase of the flight, and what the IMU is worth.

    Attributes:
        stamp_ns: Stamp of the IMU sample that it was decided at.
        phase: The phase.
        since_ns: Stamp from which the phase holds.
        reason: Why, with figures.
        imu_rate_hz: Rate at which IMU samples arrive over the last seconds, Hz.
        imu_fault: Why the IMU cannot be used, with figures; empty while it can.
    """

    stamp_ns: int
    phase: Phase
    since_ns: int
    reason: str
    imu_rate_hz: float = 0.0
    imu_fault: str = ""


GpsSample: TypeAlias = FixSample | VelocitySample | SatelliteSample
"""A sample of a GPS receiver."""

Sample: TypeAlias = (
    ImuSample
    | FixSample
    | VelocitySample
    | SatelliteSample
    | MagneticSample
    | PressureSample
    | AttitudeSample
    | CourseSample
    | PhaseSample
)
