"""Attitude from gyroscope, accelerometer and GPS, with a magnetometer where there is one."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.course import CourseEstimator, CourseParameters
from hijack_detect.estimation.ekf import (
    POSITION,
    VELOCITY,
    Ekf,
    ProcessNoise,
)
from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.estimation.imu_buffer import ImuBuffer, mean
from hijack_detect.estimation.magnetic import declination, heading_error
from hijack_detect.estimation.quaternion_integration import QuaternionIntegration
from hijack_detect.estimation.rotation import (
    Array,
    exponential,
    from_roll_pitch_yaw,
    heading,
    level,
    multiply,
    normalized,
)
from hijack_detect.streams.samples import (
    NANOSECONDS,
    AttitudeSample,
    FixSample,
    ImuSample,
    MagneticSample,
    Quaternion,
    Sample,
    Vector3,
    VelocitySample,
)

OUTAGE_STEP_NS = NANOSECONDS // 2
"""Without GPS the filter still moves on in steps of this length."""

INITIAL_SIGMAS = np.array([10.0] * 3 + [1.0] * 3 + [0.1, 0.1, math.pi] + [0.3] * 3 + [0.01] * 3)
RESTART_SIGMAS = np.array([3.0] * 3 + [1.0] * 3)
"""Standard deviations of position and velocity when they are taken from the GPS afresh."""


class AttitudeEstimator:
    """Attitude at every IMU sample.

    The filter lives at the time the newest GPS measurement was valid, stamp minus lag; the
    output is its attitude carried forward to the newest IMU sample with the gyroscope.

    It levels itself on the accelerometer first. Until the heading is known, GPS steers only the
    vertical channel and the horizontal velocity is held near zero, which keeps roll and pitch
    upright. The heading comes from the magnetometer, or from the first course above a speed
    gate; from then on position and velocity are used in full.

    With `method: quaternion` the output is the paper's bare integration, which only takes its
    first yaw and its gyro bias from the filter.
    """

    inputs = ("imu", "fix", "velocity", "mag")

    def __init__(self, parameters: AttitudeParameters) -> None:
        """Start without attitude."""
        self._parameters = p = parameters
        self._noise = ProcessNoise(p.accel_noise, p.gyro_noise, p.accel_bias_walk, p.gyro_bias_walk)
        self._lag_ns = round(p.gps_lag_s * NANOSECONDS)
        self._restart()

    def _restart(self) -> None:
        self._ekf: Ekf | None = None
        self._filter_ns = 0
        """Time that the filter has reached; counts once there is a filter."""
        self._magnetic: deque[MagneticSample] = deque()
        self._buffer = ImuBuffer()
        self._output: Quaternion = (0.0, 0.0, 0.0, 1.0)
        self._aligned = False
        self._settled = False
        self._integration: QuaternionIntegration | None = None
        self._frame: LocalFrame | None = None
        self._declination: float | None = None
        self._last_imu: ImuSample | None = None
        self._last_position: Vector3 | None = None
        self._course = CourseEstimator(CourseParameters(min_speed=self._parameters.align_speed))

    @property
    def ekf(self) -> Ekf | None:
        """The filter, None while levelling."""
        return self._ekf

    def update(self, name: str, sample: Sample) -> AttitudeSample | None:
        """Take the next sample in order of stamp; every IMU sample gives an attitude."""
        if isinstance(sample, ImuSample):
            return self._imu(sample)
        if self._ekf is None:
            return None
        if isinstance(sample, FixSample):
            self._fix(self._ekf, sample)
        elif isinstance(sample, VelocitySample):
            self._velocity(self._ekf, sample)
        elif isinstance(sample, MagneticSample) and self._parameters.use_mag:
            self._magnetic.append(sample)
        return None

    def _imu(self, sample: ImuSample) -> AttitudeSample:
        last = self._last_imu
        if last is not None:
            dt = (sample.stamp_ns - last.stamp_ns) / NANOSECONDS
            if dt > self._parameters.max_imu_gap_s:
                self._restart()
            elif self._ekf is not None:
                omega = self._unbiased(mean(last.angular_velocity, sample.angular_velocity))
                self._output = _turned(self._output, dt, omega)
                if self._integration is not None:
                    self._integration.step(omega, dt)
        self._last_imu = sample
        self._buffer.append(sample)
        if self._ekf is None:
            self._level(sample)
        elif sample.stamp_ns - self._filter_ns > OUTAGE_STEP_NS + self._lag_ns:
            self._advance(self._ekf, sample.stamp_ns - self._lag_ns)
            self._carry_output(self._ekf)
        variance = self._ekf.heading_variance if self._ekf and self._aligned else math.inf
        self._settled |= math.sqrt(variance) < math.radians(self._parameters.settled_sigma_deg)
        return AttitudeSample(
            sample.stamp_ns,
            self._orientation(),
            variance,
            sample.angular_velocity,
            sample.specific_force,
        )

    def _orientation(self) -> Quaternion | None:
        """What is published: None until it can be trusted."""
        if self._parameters.method == "quaternion":
            return None if self._integration is None else self._integration.orientation
        return normalized(self._output) if self._settled else None

    def _level(self, sample: ImuSample) -> None:
        if sample.stamp_ns - self._buffer.oldest_ns < self._parameters.level_s * NANOSECONDS:
            return
        roll, pitch = level(self._buffer.mean_specific_force())
        self._output = from_roll_pitch_yaw(roll, pitch, 0.0)
        self._ekf = Ekf(self._output, INITIAL_SIGMAS, self._noise)
        self._filter_ns = sample.stamp_ns

    def _unbiased(self, omega: Vector3) -> Vector3:
        assert self._ekf is not None
        bx, by, bz = self._ekf.gyro_bias.tolist()
        return (omega[0] - bx, omega[1] - by, omega[2] - bz)

    def _advance(self, ekf: Ekf, to_ns: int) -> None:
        """Move the filter to a time, as far as there are IMU samples, by way of the compass."""
        to_ns = min(to_ns, self._buffer.newest_ns)
        while self._magnetic and self._magnetic[0].stamp_ns <= to_ns:
            sample = self._magnetic.popleft()
            self._propagate(ekf, sample.stamp_ns)
            self._mag(ekf, sample)
        self._propagate(ekf, to_ns)

    def _propagate(self, ekf: Ekf, to_ns: int) -> None:
        if to_ns > self._filter_ns:
            ekf.propagate(self._buffer.take(self._filter_ns, to_ns))
            self._filter_ns = to_ns

    def _carry_output(self, ekf: Ekf) -> None:
        """Bring the filter's attitude forward to the newest IMU sample."""
        q = ekf.attitude
        for dt, omega in self._buffer.steps(self._filter_ns):
            q = _turned(q, dt, self._unbiased(omega))
        self._output = q

    def _fix(self, ekf: Ekf, fix: FixSample) -> None:
        course = self._course.update("fix", fix)
        if not fix.has_fix:
            return
        self._advance(ekf, fix.stamp_ns - self._lag_ns)
        if self._frame is None:
            self._frame = LocalFrame(fix)
            self._declination = declination(fix.latitude_deg, fix.longitude_deg, fix.altitude_m)
        self._last_position = position = self._frame.enu(fix)
        if not self._aligned and course.observable:
            sigma = math.radians(self._parameters.align_sigma_deg)
            speed = self._course.speed
            velocity = np.array(
                [speed * math.cos(course.angle), speed * math.sin(course.angle), 0.0]
            )
            self._align(ekf, course.angle - heading(ekf.attitude), sigma, velocity)
        p = self._parameters
        variances = np.square([p.position_sigma, p.position_sigma, p.height_sigma])
        self._measure(ekf, POSITION, np.array(position) - ekf.position, variances)

    def _velocity(self, ekf: Ekf, sample: VelocitySample) -> None:
        self._advance(ekf, sample.stamp_ns - self._lag_ns)
        residual = np.array(sample.velocity) - ekf.velocity
        variances = np.full(3, self._parameters.velocity_sigma**2)
        self._measure(ekf, VELOCITY, residual, variances)

    def _measure(self, ekf: Ekf, block: slice, residual: Array, variances: Array) -> None:
        h = np.eye(15)[block]
        if not self._aligned:
            h, residual, variances = self._upright_only(ekf, h, residual, variances)
        ekf.update(h, residual, variances)
        self._carry_output(ekf)

    def _upright_only(
        self, ekf: Ekf, h: Array, residual: Array, variances: Array
    ) -> tuple[Array, Array, Array]:
        """Vertical part of a GPS measurement, and a horizontal velocity of about zero."""
        h = np.vstack([np.eye(15)[3:5], h[2:]])
        residual = np.concatenate([-ekf.velocity[:2], residual[2:]])
        variances = np.concatenate([[1.0, 1.0], variances[2:]])
        return h, residual, variances

    def _align(self, ekf: Ekf, angle: float, sigma: float, velocity: Array) -> None:
        assert self._last_position is not None
        ekf.turn(angle, sigma)
        ekf.position = np.array(self._last_position)
        ekf.velocity = velocity
        ekf.set_block(POSITION, RESTART_SIGMAS[POSITION])
        ekf.set_block(VELOCITY, RESTART_SIGMAS[VELOCITY])
        self._aligned = True
        self._integration = QuaternionIntegration(
            heading(ekf.attitude), first_order=self._parameters.first_order
        )

    def _mag(self, ekf: Ekf, sample: MagneticSample) -> None:
        """Heading from the magnetometer; the first one aligns the filter."""
        if self._declination is None:
            return
        error = heading_error(ekf.attitude, sample.field, self._declination)
        sigma = math.radians(self._parameters.mag_sigma_deg)
        if not self._aligned:
            self._align(ekf, error, sigma, np.zeros(3))
            return
        ekf.update(np.eye(15)[8:9], np.array([error]), np.array([sigma**2]))


def _turned(q: Quaternion, dt: float, omega: Vector3) -> Quaternion:
    """A quaternion after turning with a constant body angular velocity."""
    return multiply(q, exponential((omega[0] * dt, omega[1] * dt, omega[2] * dt)))
