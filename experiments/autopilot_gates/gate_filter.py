# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A navigation filter that runs under an autopilot's gate: accepted lies drag it along."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from experiments.autopilot_gates.epochs import Compass, Epoch
from hijack_detect.estimation.ekf import ATTITUDE, Ekf, ImuBlock, Observation, ProcessNoise, Source
from hijack_detect.estimation.magnetic import heading_error
from hijack_detect.estimation.rotation import (
    Array,
    from_roll_pitch_yaw,
    heading,
    level,
    wrap,
)
from hijack_detect.streams.samples import NANOSECONDS, Quaternion, Vector3

SETTLE_S = 20.0
"""Rejections do not count before: the filter has just been started."""
INITIAL_SIGMAS = np.array(
    [0.5, 0.5, 1.0] + [0.5] * 3 + [0.1, 0.1, 0.3] + [0.2] * 3 + [math.radians(1.0)] * 3
)
"""First error state: m, m/s, rad, m/s² and rad/s. The last are the values of EKF2_ANGERR_INIT,
EKF2_HEAD_NOISE and EKF2_ABIAS_INIT; the gyro bias is known from the ground to 1 °/s."""
EAST, NORTH, UP = 0, 1, 2
V_EAST, V_NORTH, V_UP = 3, 4, 5


@dataclass(frozen=True)
class Imu:
    """An autopilot's process noise, in its own units: standard deviations of one step.

    Attributes:
        step_s: Length of a step, s.
        accel: Specific force, m/s².
        gyro: Angular velocity, rad/s.
        accel_bias: Change of the accelerometer bias, m/s³.
        gyro_bias: Change of the gyroscope bias, rad/s².
    """

    step_s: float
    accel: float
    gyro: float
    accel_bias: float
    gyro_bias: float

    def densities(self) -> ProcessNoise:
        """The same as white noise: n steps of σ dt have a variance of n σ² dt² = (σ² dt) t."""
        root = math.sqrt(self.step_s)
        return ProcessNoise(
            self.accel * root, self.gyro * root, self.accel_bias * root, self.gyro_bias * root
        )


@dataclass(frozen=True, slots=True)
class Judged:
    """What a gate did with one epoch.

    Attributes:
        stamp_ns: Stamp of the fix, nanoseconds.
        ratios: Test ratio of each measurement; 1 and above is rejected.
        resets: The states that were set to the measurement after a time-out.
        settled: Whether the filter has run for SETTLE_S.
    """

    stamp_ns: int
    ratios: Mapping[str, float]
    resets: tuple[str, ...]
    settled: bool

    @property
    def rejected(self) -> list[str]:
        """The measurements that were not used."""
        return [name for name, ratio in self.ratios.items() if ratio >= 1.0]

    @property
    def worst(self) -> float:
        """The largest test ratio."""
        return max(self.ratios.values())


@dataclass
class Rows:
    """Measurements that passed, fused in one update."""

    h: list[Array] = field(default_factory=list)
    residual: list[float] = field(default_factory=list)
    variance: list[float] = field(default_factory=list)

    def states(self, states: tuple[int, ...], residual: Array, variance: Array) -> None:
        """Add direct measurements of some error states."""
        self.h += list(np.eye(15)[list(states)])
        self.residual += residual.tolist()
        self.variance += variance.tolist()


class GateFilter(ABC):
    """Position, velocity, attitude and biases from what an autopilot's gate lets pass.

    All measurements of an epoch are tested before any is used. An autopilot tests and fuses them
    one after the other within the same step; what the first changes is small against the gates.
    """

    heading_sigma: float
    imu: Imu

    def __init__(self) -> None:
        """Wait for the first epoch."""
        self._ekf: Ekf | None = None
        self._begun_ns = 0

    @property
    def ekf(self) -> Ekf:
        """The filter; only after the first epoch."""
        assert self._ekf is not None
        return self._ekf

    def step(self, epoch: Epoch, position: Vector3, velocity: Vector3) -> Judged:
        """Take the next epoch with the position and velocity that the receiver reports.

        Args:
            epoch: The next epoch.
            position: Position by the reported fix, ENU, metres.
            velocity: Reported velocity, ENU, m/s.
        """
        z, v = np.array(position), np.array(velocity)
        if self._ekf is None or epoch.restart:
            self._begin(epoch, z, v)
        before = self.ekf.velocity
        self.ekf.propagate(epoch.block)
        acceleration = float(np.linalg.norm(self.ekf.velocity - before) / np.sum(epoch.block.dt))
        rows = Rows()
        ratios, resets = self._judge(epoch, z, v, acceleration, rows)
        self._steer(epoch.compass, rows)
        fused = np.array(rows.h), np.array(rows.residual), np.array(rows.variance)
        self.ekf.update(Observation(Source.POSITION, *fused, horizontal=False))
        settled = epoch.stamp_ns - self._begun_ns >= SETTLE_S * NANOSECONDS
        return Judged(epoch.stamp_ns, ratios, resets, settled)

    @abstractmethod
    def _judge(
        self, epoch: Epoch, position: Array, velocity: Array, acceleration: float, rows: Rows
    ) -> tuple[dict[str, float], tuple[str, ...]]:
        """Test the measurements, add those that pass to the rows, and reset what timed out.

        Returns:
            The test ratios and the resets, see Judged.
        """

    @abstractmethod
    def _forget(self, stamp_ns: int) -> None:
        """Start the clocks of the time-outs."""

    def _begin(self, epoch: Epoch, position: Array, velocity: Array) -> None:
        force = epoch.block.specific_force.mean(axis=0).tolist()
        roll, pitch = level((force[0], force[1], force[2]))
        attitude = from_roll_pitch_yaw(roll, pitch, 0.0)
        self._ekf = Ekf(attitude, INITIAL_SIGMAS, self.imu.densities())
        self._ekf.turn(_error(attitude, epoch.compass)[0], self.heading_sigma)
        # The block ends where the fix was true, so begin as far back as the block reaches.
        self._ekf.position = position - velocity * _seconds(epoch.block)
        self._ekf.velocity = velocity
        self._begun_ns = epoch.stamp_ns
        self._forget(epoch.stamp_ns)

    def _steer(self, compass: Compass, rows: Rows) -> None:
        angle, by_attitude = _error(self.ekf.attitude, compass)
        h = np.zeros(15)
        h[ATTITUDE] = by_attitude
        rows.h.append(h)
        rows.residual.append(angle)
        rows.variance.append(self.heading_sigma**2)

    def _variances(self, states: tuple[int, ...]) -> Array:
        found: Array = np.diag(self.ekf.covariance)[list(states)]
        return found

    def _reset(self, states: slice, values: Array, sigma: float) -> None:
        """Set part of position or velocity to measured values without correlations."""
        ekf = self.ekf
        both = np.concatenate([ekf.position, ekf.velocity])
        both[states] = values
        ekf.position, ekf.velocity = both[:3], both[3:]
        ekf.set_block(states, np.full(len(values), sigma))


def _seconds(block: ImuBlock) -> float:
    return float(np.sum(block.dt))


def _error(attitude: Quaternion, compass: Compass) -> tuple[float, Vector3]:
    """How far the attitude must turn about Up, rad, and its derivatives by the attitude error."""
    if compass.field is not None:
        return heading_error(attitude, compass.field, compass.angle)
    return wrap(compass.angle - heading(attitude)), (0.0, 0.0, 1.0)
