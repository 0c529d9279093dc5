# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How the filters of the tests start: level, and with these deviations and noises; a hover."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from hijack_detect.estimation.air_ekf import AirEkf
from hijack_detect.estimation.drag_filter import DragNoise
from hijack_detect.estimation.ekf import GRAVITY, ImuBlock, ProcessNoise, Source
from hijack_detect.estimation.lag_ekf import ModelErrors
from hijack_detect.estimation.velocity_error import VelocityNoise

LEVEL = (0.0, 0.0, 0.0, 1.0)
SIGMAS = np.array([1.0] * 3 + [0.5] * 3 + [0.05, 0.05, 0.2] + [0.1] * 3 + [0.005] * 3)
ERRORS = ModelErrors(
    lag_sigma_s=0.07,
    lag_walk=0.05,
    lag_difference_walk=0.001,
    lag_jitter_s=0.1,
    position_jitter_s=0.05,
    force_scale=0.03,
    rate_scale=0.02,
    max_lag_s=0.4,
    max_force=math.inf,
    max_rate=math.inf,
)
AIR = DragNoise(
    correlation_s=1.0, drag=(0.25, 0.08), quadratic_sigma=0.01, bias=0.2, wind_walk=0.15
)
NOISE = ProcessNoise(accel=0.1, gyro=0.003, accel_bias=0.005, gyro_bias=0.0007)


def hover(
    receiver: VelocityNoise,
    steps: int,
    position: Callable[[int], float],
    velocity: Callable[[int], float] | None,
) -> Iterator[AirEkf]:
    """The filter of `coast` after each of some steps of 0.2 s in which the vehicle hovers.

    Args:
        receiver: What is assumed of the GPS velocities.
        steps: How many.
        position: East of the fix of a step, m.
        velocity: East of its GPS velocity, m/s, with white noise; None for no velocities.
    """
    ekf = AirEkf(LEVEL, SIGMAS * 0.2, NOISE, ERRORS, AIR, receiver)
    rng = np.random.default_rng(4)
    block = ImuBlock(np.full(10, 0.02), np.zeros((10, 3)), np.tile([0.0, 0.0, GRAVITY], (10, 1)))
    for step in range(steps):
        ekf.propagate(block)
        fix = np.array([position(step), 0.0, 0.0])
        ekf.update(ekf.gps(Source.POSITION, fix, np.full(3, 0.49)))
        if velocity is not None:
            told = np.array([velocity(step), 0.0, 0.0]) + 0.05 * rng.normal(size=3)
            ekf.update(ekf.gps(Source.VELOCITY, told, np.full(3, 0.05**2)))
        yield ekf
