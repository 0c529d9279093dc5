# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From ROS messages to samples, with every value checked.

The functions read attributes only, so the message may come from rclpy or from rosbags: a live
node and an offline run share this border, and refuse the same messages for the same reasons.
"""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from hijack_detect.streams.samples import (
    NANOSECONDS,
    AttitudeSample,
    CourseSample,
    FixSample,
    GpsSample,
    ImuSample,
    MagneticSample,
    Phase,
    PhaseSample,
    PressureSample,
    Quaternion,
    SatelliteSample,
    Vector3,
    VelocitySample,
)
from hijack_detect.streams.silence import RESTART_S

UNKNOWN_COUNT = 255
"""Number of satellites where the autopilot does not know it (MAVLink, uint8)."""
MOVING = 1.0
"""m/s over ground. No receiver measures a vertical velocity of exactly 0 several times at this
speed: the noise of the quietest (u-blox M8 to F9) is 0.01 to 0.05 m/s at a resolution of 1 mm/s."""
REPEATS = 20
"""Samples in motion after which a component that stays the same is a filler: 2 s at 10 Hz."""
MOVED_M = 30.0
"""A height that is the same to the bit is a filler once the vehicle has moved as far: GPS height
wanders by decimetres in that time, and the coarsest resolution in use is 0.1 m (NMEA)."""
DEGREE_M = 111_320.0
"""Length of a degree of latitude, and of longitude on the equator."""

VERTICAL_VELOCITY, HEIGHT, SATELLITES = "vertical GPS velocity", "GPS height", "satellites"

T = TypeVar("T")


class Absence:
    """Marks in the samples of one receiver, in order of arrival, the components not measured.

    The decision on each input depends on the samples of that input alone, so a part that
    subscribes to one input and a part that subscribes to all decide alike. Marking twice is
    marking once.

    * Vertical velocity (NaN): 0 since the stream began; again 0 in REPEATS samples in motion.
    * Height (NaN): 0 since the stream began, or the same to the bit since then while the vehicle
      moved by MOVED_M. A height that has changed once is measured.
    * Satellites (None): UNKNOWN_COUNT, or 0 since the stream began.

    Attributes:
        counts: How many samples in motion lacked a component, by its name.
    """

    def __init__(self) -> None:
        """Start before the first sample."""
        self.counts: Counter[str] = Counter()
        self._velocity = _Velocity()
        self._height = _Height()
        self._counted = False

    def __call__(self, sample: T) -> T | None:
        """The sample with NaN where it was not measured; None if nothing of it was.

        Args:
            sample: A `FixSample`, a `VelocitySample`, or the bare number of satellites; any
                other sample is returned as it is.
        """
        if isinstance(sample, VelocitySample):
            self._velocity = self._velocity.at(sample.stamp_ns)
            if self._velocity.measured(sample):
                return sample
            self.counts[VERTICAL_VELOCITY] += _moves(sample)
            east, north, _ = sample.velocity
            if not sample.has_vertical:
                return sample
            return dataclasses.replace(sample, velocity=(east, north, math.nan))
        if isinstance(sample, FixSample):
            self._height = self._height.at(sample.stamp_ns)
            if not sample.has_fix or self._height.measured(sample):
                return sample
            self.counts[HEIGHT] += 1
            if not sample.has_altitude:
                return sample
            return dataclasses.replace(sample, altitude_m=math.nan)
        if type(sample) is int:
            self._counted = self._counted or sample not in (0, UNKNOWN_COUNT)
            if sample == UNKNOWN_COUNT or not self._counted:
                self.counts[SATELLITES] += 1
                return None
        return sample

    @property
    def names(self) -> list[str]:
        """The components that are lacking for more than a start."""
        return [name for name, count in self.counts.items() if count >= REPEATS]


class _Stream:
    """Memory of one input, until its clock runs far backwards: another recording."""

    def __init__(self) -> None:
        self._newest_ns: int | None = None

    def at(self: S, stamp_ns: int) -> S:
        """This, or one that starts at the stamp."""
        newest_ns = self._newest_ns
        if newest_ns is not None and newest_ns - stamp_ns > RESTART_S * NANOSECONDS:
            return type(self)().at(stamp_ns)
        self._newest_ns = stamp_ns if newest_ns is None else max(newest_ns, stamp_ns)
        return self


S = TypeVar("S", bound=_Stream)


class _Velocity(_Stream):
    def __init__(self) -> None:
        super().__init__()
        self._filled = False
        self._zeros = 0

    def measured(self, sample: VelocitySample) -> bool:
        """Whether the vertical component was."""
        up = sample.velocity[2]
        if math.isnan(up):
            return False
        if up != 0.0:
            self._filled, self._zeros = True, 0
        elif _moves(sample):
            self._zeros += 1
            self._filled = self._filled and self._zeros < REPEATS
        return self._filled


class _Height(_Stream):
    def __init__(self) -> None:
        super().__init__()
        self._first: FixSample | None = None
        self._varies = self._moved = False
        self._fixes = 0

    def measured(self, fix: FixSample) -> bool:
        """Whether the height was."""
        if self._varies or not fix.has_altitude:
            return fix.has_altitude
        self._first = first = self._first or fix
        if fix.altitude_m != first.altitude_m:
            self._varies = True
            return True
        self._fixes += 1
        far = self._fixes > REPEATS and _apart_m(first, fix) > MOVED_M
        self._moved = self._moved or far
        return fix.altitude_m != 0.0 and not self._moved


def _moves(sample: VelocitySample) -> bool:
    return math.hypot(sample.velocity[0], sample.velocity[1]) >= MOVING


def _apart_m(one: FixSample, other: FixSample) -> float:
    """Horizontal distance on a sphere, good to a percent over kilometres."""
    east = math.remainder(other.longitude_deg - one.longitude_deg, 360.0)
    north = other.latitude_deg - one.latitude_deg
    return DEGREE_M * math.hypot(east * math.cos(math.radians(one.latitude_deg)), north)


MAX_ANGULAR_VELOCITY = 100.0
"""rad/s; three times the range of any gyroscope that flies."""
MAX_SPECIFIC_FORCE = 1000.0
"""m/s²; three times the range of any accelerometer that flies."""
MAX_SPEED = 1000.0
"""m/s; no GPS receiver for civil use reports more than 515 m/s."""
ALTITUDE_RANGE_M = (-1000.0, 50_000.0)
"""Wider than where a drone flies: no place on land is lower than -430 m. Chosen, not swept."""
PRESSURE_RANGE_PA = (1_000.0, 120_000.0)
"""From 31 km to 1.4 km below the sea: no barometer of a drone reads outside."""
MAX_SATELLITES = 200
"""No sky has more."""
WORST_ACCURACY_M = 10_000.0
"""A claim above it is a filler (u-blox: 2^32 mm): no fix is so poor. Nothing is claimed then."""


class BadMessage(ValueError):
    """A message holds a value that no sensor can mean; the text names field and value."""


def imu_sample(message: Any) -> ImuSample:
    """Convert raw `sensor_msgs/Imu`. Raises BadMessage on non-finite or impossible values."""
    return checked_imu(
        header_stamp_ns(message),
        _xyz(message.angular_velocity),
        _xyz(message.linear_acceleration),
    )


def checked_imu(stamp_ns: int, angular_velocity: Vector3, specific_force: Vector3) -> ImuSample:
    """A sample of the numbers in an Imu. Raises BadMessage."""
    return ImuSample(
        stamp_ns,
        _vector(angular_velocity, "angular_velocity", MAX_ANGULAR_VELOCITY),
        _vector(specific_force, "linear_acceleration", MAX_SPECIFIC_FORCE),
    )


def attitude_sample(message: Any) -> AttitudeSample:
    """Convert `sensor_msgs/Imu` with orientation. Raises BadMessage.

    REP-145: a first orientation covariance of -1 means no orientation.
    """
    covariance, orientation = message.orientation_covariance, message.orientation
    return checked_attitude(
        header_stamp_ns(message),
        (*_xyz(orientation), float(orientation.w)),
        (float(covariance[0]), float(covariance[8])),
        _xyz(message.angular_velocity),
        _xyz(message.linear_acceleration),
    )


def checked_attitude(
    stamp_ns: int,
    orientation: Quaternion,
    variances: tuple[float, float],
    angular_velocity: Vector3,
    specific_force: Vector3,
) -> AttitudeSample:
    """A sample of the numbers in an Imu, of its covariance [0] and [8]. Raises BadMessage."""
    roll, yaw = variances
    known = _within(roll, "orientation_covariance[0]", -1.0, math.inf) >= 0.0
    return AttitudeSample(
        stamp_ns,
        _quaternion(orientation) if known else None,
        _within(yaw, "orientation_covariance[8]", 0.0, math.inf) if known else math.inf,
        _vector(angular_velocity, "angular_velocity", MAX_ANGULAR_VELOCITY),
        _vector(specific_force, "linear_acceleration", MAX_SPECIFIC_FORCE),
    )


def fix_sample(message: Any) -> FixSample:
    """Convert `sensor_msgs/NavSatFix`. Raises BadMessage.

    A message whose status is no fix keeps its stamp and loses its position. An
    altitude of NaN was not measured.
    """
    if message.status.status < 0:
        return FixSample(header_stamp_ns(message), 0.0, 0.0, 0.0, has_fix=False)
    return FixSample(
        header_stamp_ns(message),
        _within(message.latitude, "latitude", -90.0, 90.0),
        _within(message.longitude, "longitude", -180.0, 180.0),
        _unless_absent(message.altitude, "altitude", *ALTITUDE_RANGE_M),
        accuracy_m=_accuracy(message, 0, 4),
        vertical_accuracy_m=_accuracy(message, 8, 8),
    )


def velocity_sample(message: Any) -> VelocitySample:
    """Convert `geometry_msgs/TwistStamped` in ENU; z is NaN if not measured. Raises BadMessage."""
    east, north, up = velocity = _xyz(message.twist.linear)
    _vector((east, north, 0.0 if math.isnan(up) else up), "velocity", MAX_SPEED)
    return VelocitySample(header_stamp_ns(message), velocity)


def magnetic_sample(message: Any) -> MagneticSample:
    """Convert `sensor_msgs/MagneticField`. Raises BadMessage."""
    return MagneticSample(
        header_stamp_ns(message), _vector(_xyz(message.magnetic_field), "magnetic_field", 1.0)
    )


def pressure_sample(message: Any) -> PressureSample:
    """Convert `sensor_msgs/FluidPressure` in pascal. Raises BadMessage, also on hectopascal."""
    return PressureSample(
        header_stamp_ns(message),
        _within(message.fluid_pressure, "fluid_pressure", *PRESSURE_RANGE_PA),
    )


def course_sample(message: Any) -> CourseSample:
    """Convert `geometry_msgs/QuaternionStamped` about Up; all zeros mean not observable."""
    return CourseSample(
        header_stamp_ns(message),
        _within(message.quaternion.z, "quaternion.z", -1.0, 1.0),
        _within(message.quaternion.w, "quaternion.w", -1.0, 1.0),
    )


def phase_sample(message: Any) -> PhaseSample:
    """Convert the `diagnostic_msgs/DiagnosticArray` of flight_phase. Raises BadMessage."""
    status = only_status(message)
    values = {pair.key: pair.value for pair in status.values}
    try:
        return PhaseSample(
            header_stamp_ns(message),
            Phase(values["phase"]),
            int(values["since_ns"]),
            status.message,
            _within(float(values["imu_rate_hz"]), "imu_rate_hz", 0.0, math.inf),
            values["imu_fault"],
        )
    except KeyError as error:
        raise BadMessage(f"the phase of the flight has no {error}") from error
    except BadMessage:
        raise
    except ValueError as error:
        raise BadMessage(f"the phase of the flight: {error}") from error


def satellite_count(message: Any) -> int:
    """The number in a `std_msgs/UInt32` of satellites in use. Raises BadMessage.

    It may be `absence.UNKNOWN_COUNT`.
    """
    if message.data == UNKNOWN_COUNT:
        return UNKNOWN_COUNT
    return int(_within(message.data, "data", 0, MAX_SATELLITES))


CONVERTERS: dict[str, Callable[[Any], Any]] = {
    "imu": imu_sample,
    "fix": fix_sample,
    "velocity": velocity_sample,
    "mag": magnetic_sample,
    "pressure": pressure_sample,
    "attitude": attitude_sample,
    "course": course_sample,
    "phase": phase_sample,
}
"""Converter of each input that has a header, by the input's name."""


class Limited(NamedTuple):
    """A number of a sample: its field in the message, value, unit, and what it can be."""

    field: str
    value: float
    unit: str
    low: float
    high: float


def limited(sample: object) -> Iterator[Limited]:
    """The numbers of a sample that were measured, and their limits.

    Nothing of a value of another kind.
    """
    if isinstance(sample, ImuSample):
        yield from _axes("angular_velocity", sample.angular_velocity, "rad/s", MAX_ANGULAR_VELOCITY)
        yield from _axes("linear_acceleration", sample.specific_force, "m/s2", MAX_SPECIFIC_FORCE)
    elif isinstance(sample, FixSample):
        yield Limited("latitude", sample.latitude_deg, "deg", -90.0, 90.0)
        yield Limited("longitude", sample.longitude_deg, "deg", -180.0, 180.0)
        if sample.has_altitude:
            yield Limited("altitude", sample.altitude_m, "m", *ALTITUDE_RANGE_M)
    elif isinstance(sample, VelocitySample):
        axes = list(_axes("velocity", sample.velocity, "m/s", MAX_SPEED))
        yield from axes if sample.has_vertical else axes[:2]
    elif isinstance(sample, MagneticSample):
        yield from _axes("magnetic_field", sample.field, "T", 1.0)
    elif isinstance(sample, PressureSample):
        yield Limited("fluid_pressure", sample.pressure_pa, "Pa", *PRESSURE_RANGE_PA)
    elif isinstance(sample, SatelliteSample):
        yield Limited("satellites", sample.count, "satellites", 0, MAX_SATELLITES)


def check(sample: object) -> None:
    """Hold a sample that was not made of a ROS message to the same limits. Raises BadMessage.

    A value of another kind passes.
    """
    for one in limited(sample):
        _within(one.value, one.field, one.low, one.high)


def header_stamp_ns(message: Any) -> int:
    """Header stamp of a message, nanoseconds."""
    stamp = message.header.stamp
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)


def only_status(message: Any) -> Any:
    """The status of a `diagnostic_msgs/DiagnosticArray` that is a verdict. Raises BadMessage."""
    if len(message.status) != 1:
        raise BadMessage(f"a verdict has one status, this has {len(message.status)}")
    return message.status[0]


def claimed(accuracy_m: float) -> float | None:
    """A standard deviation (m) that a receiver claims; None where it is a filler."""
    return accuracy_m if 0.0 < accuracy_m <= WORST_ACCURACY_M else None


def _accuracy(fix: Any, first: int, second: int) -> float | None:
    """Standard deviation (m) from two diagonal entries of a NavSatFix; None if it claims none."""
    if fix.position_covariance_type == 0:
        return None
    covariance = fix.position_covariance
    variance = 0.5 * (float(covariance[first]) + float(covariance[second]))
    return claimed(math.sqrt(variance)) if 0.0 < variance < math.inf else None


def _unless_absent(value: float, name: str, low: float, high: float) -> float:
    return math.nan if math.isnan(value) else _within(value, name, low, high)


def _within(value: float, name: str, low: float, high: float) -> float:
    if not low <= value <= high:
        raise BadMessage(f"{name} is {value!r}, not within [{low:g}, {high:g}]")
    return float(value)


def _axes(field: str, vector: Vector3, unit: str, limit: float) -> Iterator[Limited]:
    for axis, value in zip("xyz", vector, strict=True):
        yield Limited(f"{field}.{axis}", value, unit, -limit, limit)


def _xyz(vector: Any) -> Vector3:
    return (float(vector.x), float(vector.y), float(vector.z))


def _vector(vector: Vector3, name: str, limit: float) -> Vector3:
    x, y, z = vector
    if not (-limit <= x <= limit and -limit <= y <= limit and -limit <= z <= limit):
        for axis, value in zip("xyz", vector, strict=True):
            _within(value, f"{name}.{axis}", -limit, limit)
    return vector


def _quaternion(quaternion: Quaternion) -> Quaternion:
    norm = math.hypot(*quaternion)
    if not abs(norm - 1.0) < 1e-3:
        raise BadMessage(f"orientation {quaternion} has norm {norm:g}, not 1")
    return quaternion


UNKNOWN, APPROXIMATED = 0, 1
"""Types of covariance of a NavSatFix."""


def write_change(message: Any, before: GpsSample, after: GpsSample) -> bool:
    """Write what an attack made of a sample into the sample's message.

    Args:
        message: `sensor_msgs/NavSatFix`, `geometry_msgs/TwistStamped` or `std_msgs/UInt32`; it is
            changed.
        before: The sample that was read from the message.
        after: A sample of the same kind.

    Returns:
        Whether they differ; otherwise the message is left alone.
    """
    if after == before:
        return False
    if isinstance(before, FixSample) and isinstance(after, FixSample):
        message.latitude, message.longitude = after.latitude_deg, after.longitude_deg
        message.altitude = after.altitude_m
        if after.accuracy_m is not None and after.accuracy_m != before.accuracy_m:
            message.position_covariance = position_covariance(
                after.accuracy_m, after.vertical_accuracy_m
            )
            message.position_covariance_type = APPROXIMATED
    elif isinstance(after, VelocitySample):
        linear = message.twist.linear
        linear.x, linear.y, linear.z = after.velocity
    elif isinstance(after, SatelliteSample):
        message.data = after.count
    return True


def position_covariance(
    horizontal_m: float | None, vertical_m: float | None
) -> npt.NDArray[np.float64]:
    """Row-major diagonal covariance (9,) in m², ENU, of claimed standard deviations.

    It is 0, which `messages` reads as no claim, where there is none.
    """
    across, up = (0.0 if one is None else one**2 for one in (horizontal_m, vertical_m))
    return np.diag([across, across, up]).ravel()
