# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The 15-state error-state Kalman filter of Feng et al. 2018, §3.5.

Nominal state: position and velocity (ENU, m and m/s), attitude (quaternion FLU → ENU),
accelerometer bias (m/s²) and gyroscope bias (rad/s). The error state is [δp δv δθ δba δbg]; the
attitude error is in ENU, R_true = exp([δθ]×) R. IMU samples are integrated in blocks between
two fixes, so the cost of the covariance does not grow with the IMU's rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from hijack_detect.estimation.kalman import Innovation, add_diagonal, update
from hijack_detect.estimation.rotation import (
    UNIT,
    Array,
    exponential,
    exponentials,
    matrices,
    multiply,
    normalized,
    skew,
)
from hijack_detect.streams.samples import Quaternion

GRAVITY = 9.80665
"""m/s²; its variation over the Earth (0.5 %) ends up in the accelerometer bias."""

POSITION, VELOCITY, ATTITUDE = slice(0, 3), slice(3, 6), slice(6, 9)
ACCEL_BIAS, GYRO_BIAS = slice(9, 12), slice(12, 15)
BOTH_WAYS = np.arange(6), (np.arange(6) + 3) % 6
"""Entries of a covariance that tie each component of the position to its velocity."""
UP = np.array([0.0, 0.0, 1.0])
UNSEEN_S = 0.1
"""s: an interval between two IMU samples beyond this is time without a measurement of the motion.
Chosen, not swept."""
UNSEEN_RATE, UNSEEN_ACCELERATION = 0.5, 3.0
"""rad/s and m/s²: what it may have done then, standard deviations of a vehicle that manoeuvres.
Chosen, not swept."""


class Source(Enum):
    """Measured quantity of an observation."""

    POSITION = "position"
    """Position of the GPS."""
    VELOCITY = "velocity"
    """Velocity of the GPS."""
    FIELD = "field"
    """Magnetometer."""
    DRAG = "drag"
    """Specific force that the air exerts."""


@dataclass(frozen=True, slots=True)
class Observation:
    """A measurement as a filter of n states sees it.

    Attributes:
        source: What measured it.
        H: Observation matrix, shape (m, n).
        residual: Measured minus predicted, shape (m,).
        R: Variances of the measurement noise, shape (m,).
        horizontal: Whether the first two rows are East and North of the GPS. Without a heading
            they are the assumption that the vehicle stands still, see `AttitudeFilter`.
    """

    source: Source
    H: Array
    residual: Array
    R: Array
    horizontal: bool = True


@dataclass(frozen=True)
class ProcessNoise:
    """Densities of the white noise that drives the error state."""

    accel: float
    """Specific force, m/s²/√Hz."""
    gyro: float
    """Angular velocity, rad/s/√Hz."""
    accel_bias: float
    """Random walk of the accelerometer bias, m/s²/√s."""
    gyro_bias: float
    """Random walk of the gyroscope bias, rad/s/√s."""


@dataclass(frozen=True)
class ImuBlock:
    """IMU readings over consecutive intervals.

    Attributes:
        dt: Lengths of the intervals, s, shape (n,).
        angular_velocity: Mean over each interval, rad/s, FLU, shape (n, 3).
        specific_force: Mean over each interval, m/s², FLU, shape (n, 3).
    """

    dt: Array
    angular_velocity: Array
    specific_force: Array

    @cached_property
    def seconds(self) -> float:
        """Length of the block, s."""
        return float(self.dt.sum())


class Ekf:
    """Position, velocity, attitude and IMU biases from IMU blocks and GPS."""

    def __init__(self, attitude: Quaternion, sigmas: Array, noise: ProcessNoise) -> None:
        """Start at rest at the origin.

        Args:
            attitude: Initial attitude, FLU → ENU.
            sigmas: Initial standard deviations of the error state, shape (15,) or more: a
                subclass may add states behind these.
            noise: Process noise.
        """
        self.position: Array = np.zeros(3)
        self.velocity: Array = np.zeros(3)
        self.attitude = attitude
        self.accel_bias: Array = np.zeros(3)
        self.gyro_bias: Array = np.zeros(3)
        self.covariance = np.diag(np.square(sigmas))
        self.transition: Array = np.eye(len(self.covariance))
        """Φ of the last block, shape (n, n)."""
        self._noise = noise

    def propagate(self, block: ImuBlock) -> None:
        """Advance the state over a block of IMU readings (INS mechanisation and Q of §3.5)."""
        if not block.seconds:
            return
        dt = block.dt[:, None]
        halves = exponentials((block.angular_velocity - self.gyro_bias) * (0.5 * dt))
        middles = []
        q = self.attitude
        for x, y, z, w in halves.tolist():
            half = (x, y, z, w)
            middle = multiply(q, half)
            middles.append(middle)
            q = multiply(middle, half)
        self.attitude = normalized(q)

        rotation = matrices(np.array(middles))
        force = (rotation @ (block.specific_force - self.accel_bias)[:, :, None])[:, :, 0]
        self.transition = phi = self.transition_over(dt, rotation, force)
        covariance = phi @ self.covariance @ phi.T
        add_diagonal(covariance, slice(0, len(phi)), self.process_noise(block, force.mean(axis=0)))
        covariance[BOTH_WAYS] += self._noise.accel**2 * block.seconds**2 / 2
        self.covariance = covariance
        steps = (force - UP * GRAVITY) * dt
        after = self.velocity + steps.cumsum(axis=0)
        self.position = self.position + ((after - 0.5 * steps) * dt).sum(axis=0)
        self.velocity = after[-1]

    def transition_over(self, dt: Array, rotation: Array, force: Array) -> Array:
        """Φ over a block, shape (n, n); a subclass adds how its own states move.

        Args:
            dt: Lengths of the intervals, s, shape (m, 1).
            rotation: FLU → ENU in the middle of each, shape (m, 3, 3).
            force: Specific force in each, ENU, m/s², shape (m, 3).
        """
        return _transition(dt, rotation, force, len(self.covariance))

    def process_noise(self, block: ImuBlock, force: Array) -> Array:
        """Diagonal of Q of §3.5 over a block, shape (n,); `propagate` adds what ties p to v.

        Args:
            block: The readings.
            force: Mean specific force, ENU, m/s², shape (3,).
        """
        seconds, accel = block.seconds, self._noise.accel**2
        noise = np.zeros(len(self.covariance))
        noise[POSITION] = accel * seconds**3 / 3
        noise[VELOCITY] = accel * seconds
        noise[ATTITUDE] = self._noise.gyro**2 * seconds
        noise[ACCEL_BIAS] = self._noise.accel_bias**2 * seconds
        noise[GYRO_BIAS] = self._noise.gyro_bias**2 * seconds
        self.add_unseen(noise, float(np.maximum(block.dt - UNSEEN_S, 0.0).sum()))
        return noise

    @staticmethod
    def add_unseen(noise: Array, seconds: float) -> None:
        """Add to the diagonal of Q what the vehicle may have done without a measurement."""
        if seconds:
            noise[VELOCITY] += (UNSEEN_ACCELERATION * seconds) ** 2
            noise[ATTITUDE] += (UNSEEN_RATE * seconds) ** 2

    def gps(self, source: Source, measured: Array, variances: Array) -> Observation:
        """Observation of a GPS position or velocity.

        Args:
            source: Which of the two.
            measured: ENU, m or m/s, shape (3,).
            variances: Of the measurement's noise, shape (3,).
        """
        H = np.zeros((3, len(self.covariance)))
        if source is Source.POSITION:
            block, predicted = POSITION, self.position
        else:
            block, predicted = VELOCITY, self.velocity
        H[:, block] = UNIT
        return Observation(source, H, measured - predicted, variances)

    @property
    def beyond_band(self) -> float:
        """Time by which the filter should run later, s: 0 for one that does not know lags."""
        return 0.0

    def rebase(self, shift_s: float) -> None:
        """The filter runs later by this from now on, s; for those that know lags."""

    def update(self, seen: Observation) -> Innovation:
        """Use an observation."""
        found, self.covariance = update(self.covariance, seen.H, seen.residual, seen.R)
        self._inject(found.correction)
        return found

    def _inject(self, error: Array) -> None:
        self.position = self.position + error[POSITION]
        self.velocity = self.velocity + error[VELOCITY]
        x, y, z = error[ATTITUDE].tolist()
        self.attitude = normalized(multiply(exponential((x, y, z)), self.attitude))
        self.accel_bias = self.accel_bias + error[ACCEL_BIAS]
        self.gyro_bias = self.gyro_bias + error[GYRO_BIAS]

    def turn(self, angle: float, sigma: float) -> None:
        """Turn the attitude about Up by an angle and restart the heading's uncertainty, rad.

        The uncertainty of the tilt turns along; the heading forgets its correlations.
        """
        self.attitude = normalized(
            multiply((0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2)), self.attitude)
        )
        cosine, sine = math.cos(angle), math.sin(angle)
        turn = np.eye(len(self.covariance))
        turn[6:8, 6:8] = [[cosine, -sine], [sine, cosine]]
        self.covariance = turn @ self.covariance @ turn.T
        self.set_block(slice(8, 9), np.array([sigma]))

    def set_block(self, block: slice, sigmas: Array) -> None:
        """Give some error states new standard deviations and no correlations."""
        self.covariance[block, :] = 0.0
        self.covariance[:, block] = 0.0
        self.covariance[block, block] = np.diag(np.square(sigmas))

    @property
    def heading_variance(self) -> float:
        """Variance of the heading, rad²."""
        return float(self.covariance[8, 8])


def _transition(dt: Array, rotation: Array, force: Array, size: int) -> Array:
    """Φ accumulated over a block; states behind the first 15 are constants.

    dt has shape (n, 1), rotation (n, 3, 3), force (n, 3) in ENU. With δθ' = −R δbg and
    δv' = −[R f]× δθ − R δba, every block of Φ is a single or double integral over the samples:
    a reading counts with its interval, and again with the time from its middle to the end.
    """
    turns = rotation * dt[:, :, None]
    turned = turns.cumsum(axis=0)
    rates = np.empty((len(dt), 3, 9))
    rates[:, :, :3] = cross = skew(force)
    rates[:, :, 3:6] = rotation
    rates[:, :, 6:] = cross @ (0.5 * turns - turned)
    ends = dt.cumsum()
    weights = np.empty((2, len(dt)))
    weights[1] = dt[:, 0]
    weights[0] = weights[1] * (ends[-1] - ends + 0.5 * weights[1])
    phi = np.zeros((size, size))
    add_diagonal(phi, slice(0, size), 1.0)
    phi[POSITION, VELOCITY] = ends[-1] * UNIT
    phi[:6, 6:15] = (weights @ rates.reshape(len(dt), 27)).reshape(6, 9)
    np.negative(phi[:6, 6:15], out=phi[:6, 6:15])
    phi[ATTITUDE, GYRO_BIAS] = -turned[-1]
    return phi
