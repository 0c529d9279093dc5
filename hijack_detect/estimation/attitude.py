# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attitude at every IMU sample, from gyroscope, accelerometer, GPS and magnetometer."""

from __future__ import annotations

import math
from collections.abc import Mapping

from hijack_detect.estimation.attitude_filter import AttitudeFilter
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.ekf import Ekf
from hijack_detect.estimation.imu_buffer import mean
from hijack_detect.estimation.quaternion_integration import QuaternionIntegration
from hijack_detect.estimation.rotation import exponential, multiply, normalized
from hijack_detect.streams.samples import (
    NANOSECONDS,
    AttitudeSample,
    ImuSample,
    Quaternion,
    Sample,
    Vector3,
)

LEVEL: Quaternion = (0.0, 0.0, 0.0, 1.0)
SETTLED_TILT = math.radians(2.0)
"""Roll and pitch are published from this standard deviation on: 2° feel like 0.34 m/s²."""


class AttitudeEstimator:
    """Carries the attitude of an `AttitudeFilter` forward to the newest IMU sample.

    The filter is behind by the lag of the GPS; between its corrections the gyroscope turns the
    attitude on.

    With `method: quaternion` the output is the paper's bare integration, which only takes its
    first yaw and its gyro bias from the filter.
    """

    PARAMETERS = AttitudeParameters

    def __init__(self, parameters: AttitudeParameters) -> None:
        """Start without attitude."""
        self._parameters = parameters
        self._filter = AttitudeFilter(parameters)
        self.inputs: Mapping[str, float] = self._filter.inputs
        self._last: ImuSample | None = None
        self._bridged = 0
        self._forget()

    def _forget(self) -> None:
        self._carried = LEVEL
        self._behind = False
        """Whether the filter has moved since the attitude was carried forward from it."""
        self._settled = False
        self._integration: QuaternionIntegration | None = None

    @property
    def ekf(self) -> Ekf | None:
        """The filter behind, None while levelling."""
        return self._filter.ekf

    def update(self, name: str, sample: Sample) -> AttitudeSample | None:
        """Take the next sample in order of stamp; every IMU sample gives an attitude."""
        if isinstance(sample, ImuSample):
            return self._imu(sample)
        self._behind |= self._filter.update(name, sample)
        return None

    def _imu(self, sample: ImuSample) -> AttitudeSample:
        last, self._last = self._last, sample
        if last is not None and self._filter.ekf is not None:
            self._turn(last, sample, self._filter.ekf)
        self._behind |= self._filter.update("imu", sample)
        if self._filter.bridged != self._bridged:
            self._bridged, self._settled = self._filter.bridged, False
        if self._filter.ekf is None:
            self._forget()
        elif self._behind:
            self._carry(self._filter.ekf)
        variance = self._heading_variance()
        self._settled = self._settled or (
            not self._filter.regaining
            and math.sqrt(variance) < math.radians(self._parameters.settled_sigma_deg)
            and self._tilt_variance() < SETTLED_TILT**2
        )
        orientation = self._orientation()
        return AttitudeSample(
            sample.stamp_ns,
            orientation,
            math.inf if orientation is None else variance,
            sample.angular_velocity,
            sample.specific_force,
        )

    def _turn(self, last: ImuSample, sample: ImuSample, ekf: Ekf) -> None:
        """Turn on to a sample."""
        first, p = self._filter.first_heading, self._parameters
        if self._integration is None and first is not None and p.method == "quaternion":
            self._integration = QuaternionIntegration(first, first_order=p.first_order)
        dt = (sample.stamp_ns - last.stamp_ns) / NANOSECONDS
        omega = mean(last.angular_velocity, sample.angular_velocity)
        omega = _unbiased(omega, ekf.gyro_bias.tolist())
        if not self._behind:
            self._carried = _turned(self._carried, dt, omega)
        if self._integration is not None:
            self._integration.step(omega, dt)

    def _carry(self, ekf: Ekf) -> None:
        """Bring the filter's attitude forward to the newest IMU sample."""
        q, bias = ekf.attitude, ekf.gyro_bias.tolist()
        for dt, omega in self._filter.buffer.steps(self._filter.valid_ns):
            q = _turned(q, dt, _unbiased(omega, bias))
        self._carried, self._behind = q, False

    def _heading_variance(self) -> float:
        """Variance of the heading, rad²; infinite while several headings are possible."""
        ekf = self._filter.ekf
        return ekf.heading_variance if ekf is not None and self._filter.decided else math.inf

    def _tilt_variance(self) -> float:
        """Larger variance of roll and pitch, rad²."""
        ekf = self._filter.ekf
        return math.inf if ekf is None else float(ekf.covariance.diagonal()[6:8].max())

    def _orientation(self) -> Quaternion | None:
        """Attitude to publish: None until it can be trusted."""
        if self._parameters.method == "quaternion":
            return None if self._integration is None else self._integration.orientation
        return normalized(self._carried) if self._settled else None


def _unbiased(omega: Vector3, bias: list[float]) -> Vector3:
    """An angular velocity without the bias of the gyroscope."""
    return (omega[0] - bias[0], omega[1] - bias[1], omega[2] - bias[2])


def _turned(q: Quaternion, dt: float, omega: Vector3) -> Quaternion:
    """A quaternion after turning with a constant body angular velocity."""
    return multiply(q, exponential((omega[0] * dt, omega[1] * dt, omega[2] * dt)))
