# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Heading from gyroscope, accelerometer and magnetometer: nothing in it comes from the GPS.

A multiplicative error-state Kalman filter on attitude and gyroscope bias. The attitude error is
in ENU, R_true = exp([δθ]×) R, as in `estimation.ekf`; the state here has no position and no
velocity, since those would need the GPS. Two vectors hold the attitude: the specific force,
which points up on average, and the Earth's magnetic field.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.ekf import GRAVITY
from hijack_detect.estimation.imu_buffer import mean
from hijack_detect.estimation.kalman import update
from hijack_detect.estimation.magnetic import field_enu
from hijack_detect.estimation.rotation import (
    Array,
    exponential,
    from_roll_pitch_yaw,
    heading,
    level,
    matrix,
    multiply,
    normalized,
    rotate,
    skew,
)
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    ImuSample,
    MagneticSample,
    Quaternion,
    Vector3,
)

LEVEL_S = 0.5
"""Roll and pitch start from the mean specific force over this time. Chosen, not swept."""
MAX_STEP_S = 0.2
"""The covariance moves on at least this often. Chosen, not swept."""
MAX_GAP_S = 1.0
"""After a longer gap in the IMU data everything restarts: the gyroscope lost its turn.
Chosen, not swept."""
LEARN_S = 60.0
"""Strength and dip of the field are learnt this slowly: hard iron moves them for good.
Chosen, not swept."""
REALIGN_S = 60.0
"""A field that has been refused for this long is the new field, or the gyroscope is wrong.
Chosen, not swept."""
BIAS_LIMIT = 0.05
"""rad/s; a gyroscope bias of more than 3°/s is a broken sensor, or a compass that misleads.
Chosen, not swept."""
INITIAL_SIGMAS = np.array([0.1, 0.1, math.pi] + [0.01] * 3)
"""Standard deviations of the first error state: rad and rad/s. Chosen, not swept."""
ALIGN_SIGMA = 0.2
"""Standard deviation of a heading taken from one reading, rad: tilt is multiplied by the dip.
Chosen, not swept."""


def earth_field(fix: FixSample) -> Vector3:
    """The Earth's magnetic field at a fix, tesla in ENU (World Magnetic Model)."""
    return field_enu(fix.latitude_deg, fix.longitude_deg, fix.altitude_m)


@dataclass(frozen=True)
class FieldGate:
    """A reading that is further from what is expected is not used."""

    heading: float = math.radians(20.0)
    """From the heading of the filter, rad. Clean flights stay below 8°."""
    dip: float = math.radians(10.0)
    """From the learnt dip, rad. Clean flights stay below 3°."""
    strength: float = 0.15
    """From the learnt strength, as a part of it. Clean flights stay below 0.02."""


@dataclass(frozen=True)
class Reading:
    """Disagreement of a magnetometer reading with the filter, before it is used."""

    heading: float
    """Heading of the reading, with the filter's tilt, minus that of the filter, rad."""
    dip: float
    """Angle of the field below the horizon minus the learnt one, rad."""
    strength: float
    """Strength divided by the learnt one, minus one."""

    def margin(self, gate: FieldGate) -> float:
        """Largest disagreement in units of its gate; 1 and above is an anomaly."""
        return max(
            abs(self.heading) / gate.heading,
            abs(self.dip) / gate.dip,
            abs(self.strength) / gate.strength,
        )


@dataclass(frozen=True)
class CompassNoise:
    """Noise of the sensors of the filter; the defaults fit small multirotors."""

    gyro: float = 0.003
    """Gyroscope noise density, rad/s/√Hz: `gyro_noise` of the attitude."""
    gyro_bias_walk: float = 0.0007
    """Random walk of the gyroscope bias, rad/s/√s: `gyro_bias_walk` of the attitude."""
    acceleration: float = 4.0
    """Horizontal accelerations of the vehicle as white noise, m/s²/√Hz: without the GPS they
    look like gravity. Their mean vanishes over a quarter minute, a speed's worth.
    Chosen, not swept."""
    field: float = 0.03
    """Error of the direction of the field, rad/√Hz; slow errors are worse than white ones.
    Chosen, not swept."""


class Compass:
    """Tracks attitude and gyroscope bias; gives three headings that the GPS has no part in.

    Attributes:
        attitude: Rotation FLU → ENU.
        gyro_heading: The turn that the gyroscope alone has seen, rad, continuous, from an
            arbitrary zero. The compass enters only through the slowly learnt gyroscope bias.
    """

    def __init__(
        self, field: Vector3, noise: CompassNoise | None = None, gate: FieldGate | None = None
    ) -> None:
        """Start without attitude.

        Args:
            field: The Earth's field here, tesla in ENU.
            noise: Of the sensors.
            gate: What a reading may be off.
        """
        self._field = field
        self._noise = noise or CompassNoise()
        self._gate = gate or FieldGate()
        self._restart()

    def _restart(self) -> None:
        self.attitude: Quaternion = (0.0, 0.0, 0.0, 1.0)
        self.gyro_heading = 0.0
        self.gyro_bias: Vector3 = (0.0, 0.0, 0.0)
        self._covariance = np.diag(np.square(INITIAL_SIGMAS))
        self._levelled = self._aligned = False
        east, north, up = self._field
        self._dip = math.atan2(-up, math.hypot(east, north))
        self._strength = math.hypot(east, north, up)
        self._used_ns: int | None = None
        """Stamp of the last reading that was used."""
        self._mag_ns: int | None = None
        self._last: ImuSample | None = None
        self._dt = 0.0
        self._force = [0.0, 0.0, 0.0]
        """Time and specific force (ENU, m/s) since the covariance moved on, or levelling began."""

    @property
    def aligned(self) -> bool:
        """Whether the heading is known."""
        return self._aligned

    @property
    def heading(self) -> float:
        """Heading of gyroscope and compass together, rad counter-clockwise from East."""
        return heading(self.attitude)

    @property
    def heading_sigma(self) -> float:
        """Standard deviation of `heading` that the filter claims, rad."""
        return math.sqrt(float(self._covariance[2, 2]))

    def imu(self, sample: ImuSample) -> bool:
        """Take the next reading; false if a gap made everything restart."""
        last, self._last = self._last, sample
        if last is None:
            return True
        dt = (sample.stamp_ns - last.stamp_ns) / NANOSECONDS
        if dt > MAX_GAP_S:
            self._restart()
            self._last = sample
            return False
        omega = mean(last.angular_velocity, sample.angular_velocity)
        force = mean(last.specific_force, sample.specific_force)
        if self._levelled:
            self._turn(dt, omega)
            force = rotate(self.attitude, force)
        self._dt += dt
        for axis in range(3):
            self._force[axis] += dt * force[axis]
        if not self._levelled:
            self._level()
        elif self._dt >= MAX_STEP_S:
            self._advance()
        return True

    def _turn(self, dt: float, omega: Vector3) -> None:
        bx, by, bz = self.gyro_bias
        x, y, z = omega
        before = heading(self.attitude)
        step = exponential(((x - bx) * dt, (y - by) * dt, (z - bz) * dt))
        self.attitude = normalized(multiply(self.attitude, step))
        self.gyro_heading += math.remainder(heading(self.attitude) - before, math.tau)

    def _level(self) -> None:
        if self._dt >= LEVEL_S:
            x, y, z = self._force
            self.attitude = from_roll_pitch_yaw(*level((x, y, z)), 0.0)
            self._levelled = True
            self._dt, self._force = 0.0, [0.0, 0.0, 0.0]

    def _advance(self) -> None:
        """Move the covariance on, and pull the mean specific force upright."""
        dt = self._dt
        if dt <= 0.0:
            return
        phi = np.eye(6)
        phi[:3, 3:] = -dt * matrix(self.attitude)
        grown = np.repeat([self._noise.gyro**2 * dt, self._noise.gyro_bias_walk**2 * dt], 3)
        self._covariance = phi @ self._covariance @ phi.T + np.diag(grown)
        h = np.zeros((2, 6))
        h[0, 1], h[1, 0] = GRAVITY, -GRAVITY
        east, north, _ = self._force
        variance = self._noise.acceleration**2 / dt
        self._dt, self._force = 0.0, [0.0, 0.0, 0.0]
        self._update(h, np.array([-east / dt, -north / dt]), variance)

    def read(self, sample: MagneticSample) -> Reading:
        """Compare a reading, which must not be zero, with the filter."""
        east, north, up = rotate(self.attitude, sample.field)
        level_field = math.hypot(east, north)
        turn = math.atan2(self._field[1], self._field[0]) - math.atan2(north, east)
        return Reading(
            math.remainder(turn, math.tau),
            math.atan2(-up, level_field) - self._dip,
            math.hypot(level_field, up) / self._strength - 1.0,
        )

    def mag(self, sample: MagneticSample) -> Reading | None:
        """Use a reading, unless it is outside the gate; the first one gives the heading.

        Returns:
            How it disagreed; None before the filter is level.
        """
        before, self._mag_ns = self._mag_ns, sample.stamp_ns
        if not self._levelled or not any(sample.field):
            return None
        self._advance()
        if not self._aligned:
            self._align(sample)
        reading = self.read(sample)
        if reading.margin(self._gate) >= 1.0:
            assert self._used_ns is not None
            if sample.stamp_ns - self._used_ns > REALIGN_S * NANOSECONDS:
                self._align(sample)
            return reading
        self._used_ns = sample.stamp_ns
        dt = MAX_STEP_S if before is None else (sample.stamp_ns - before) / NANOSECONDS
        dt = min(max(dt, 0.001), MAX_STEP_S)
        measured = np.array(rotate(self.attitude, sample.field))
        measured /= np.linalg.norm(measured)
        h = np.zeros((3, 6))
        h[:, :3] = -skew(measured)
        self._update(h, self._reference() - measured, self._noise.field**2 / dt)
        self._dip += dt / LEARN_S * reading.dip
        self._strength *= 1.0 + dt / LEARN_S * reading.strength
        return reading

    def _reference(self) -> Array:
        """Direction of the field, ENU: declination of the place, learnt dip."""
        east, north, _ = self._field
        scale = math.cos(self._dip) / math.hypot(east, north)
        return np.array([east * scale, north * scale, -math.sin(self._dip)])

    def _align(self, sample: MagneticSample) -> None:
        """Take heading, dip and strength from a reading."""
        reading = self.read(sample)
        half = 0.5 * reading.heading
        turn = (0.0, 0.0, math.sin(half), math.cos(half))
        self.attitude = normalized(multiply(turn, self.attitude))
        self._dip += reading.dip
        self._strength *= 1.0 + reading.strength
        self._covariance[2, :] = self._covariance[:, 2] = 0.0
        self._covariance[2, 2] = ALIGN_SIGMA**2
        self._used_ns = sample.stamp_ns
        self._aligned = True

    def _update(self, h: Array, residual: Array, variance: float) -> None:
        """Use a measurement with equal variances of the noise."""
        noise = np.full(len(h), variance)
        found, self._covariance = update(self._covariance, h, residual, noise)
        dx, dy, dz, bx, by, bz = found.correction.tolist()
        self.attitude = normalized(multiply(exponential((dx, dy, dz)), self.attitude))
        x, y, z = self.gyro_bias
        self.gyro_bias = (_bounded(x + bx), _bounded(y + by), _bounded(z + bz))


def _bounded(bias: float) -> float:
    return min(max(bias, -BIAS_LIMIT), BIAS_LIMIT)
