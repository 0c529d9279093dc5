# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What is assumed of wind and drag, and how well drag explains the force of this vehicle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from hijack_detect.estimation.rotation import Array
from hijack_detect.parameters import param

HUBER = 2.0
"""Residuals beyond so many standard deviations count linearly: gusts and bad samples."""
MEMORY_S = 30.0
"""The residual is that of about so long."""


FORCE = 0.08
"""m/s²: the residual is taken to be at least this. Chosen: the noise of a MEMS accelerometer
(400 µg/√Hz, MPU-6000) over 0.2 s is a tenth of it, so it stands for what is not white."""
FIRST_RESIDUAL = 0.25
"""m/s²: the residual before it is measured. Chosen: about half of what `drag` believes at most."""
WIND = 6.0
"""m/s, standard deviation of the first wind along each axis. Chosen: 95 % of winds are then below
2.45 times as much (Rayleigh), 15 m/s, and small multirotors are rated for 10 to 12 m/s."""
DRAG_WALK = 0.002
"""1/s/√s, random walk of k. Chosen: 0.05 in ten minutes, less than it differs between vehicles."""
BIAS_WALK = 0.005
"""m/s²/√s, random walk of the bias. 0.003 to 0.01 fit the accelerometers of 11 of 13 recorded
flights best, see `accel_bias_walk` of coast."""


def first_drag() -> Any:
    """Declare the drag k of a vehicle that is not learnt yet."""
    return param(
        0.25,
        "Drag k of the vehicle before it is learnt: specific force per airspeed. Quadrotors have "
        "0.15 to 0.35.",
        unit="1/s",
        low=0.02,
        high=2.0,
    )


def first_drag_sigma() -> Any:
    """Declare how well `first_drag` is known."""
    return param(
        0.08,
        "Standard deviation of `drag`. Lower it for a vehicle that was measured.",
        unit="1/s",
        low=0.001,
        high=2.0,
    )


def first_quadratic_sigma(default: float) -> Any:
    """Declare the standard deviation of the drag q, whose mean is 0."""
    return param(
        default,
        "Standard deviation of the drag q that grows with airspeed, which most quadrotors lack.",
        unit="1/m",
        low=0.0001,
        high=1.0,
    )


@dataclass(frozen=True)
class DragNoise:
    """What a filter assumes of wind and vehicle.

    Attributes:
        correlation_s: How long a gust keeps the force away from the model, s.
        drag: Mean and deviation of the first k, 1/s.
        quadratic_sigma: Deviation of the first q, whose mean is 0, 1/m.
        bias: Deviation of the first bias, m/s².
        wind_walk: Random walk of the wind, m/s/√s.
    """

    correlation_s: float
    drag: tuple[float, float]
    quadratic_sigma: float
    bias: float
    wind_walk: float

    @property
    def sigmas(self) -> tuple[float, ...]:
        """First standard deviations of wind (2), k, q and bias (2)."""
        return (WIND, WIND, self.drag[1], self.quadratic_sigma, self.bias, self.bias)

    @property
    def walks(self) -> tuple[float, ...]:
        """Random walks of wind (2), k, q and bias (2)."""
        wind = self.wind_walk
        return (wind, wind, DRAG_WALK, 0.0, BIAS_WALK, BIAS_WALK)

    def variance(self, residual: float, seconds: float) -> float:
        """Variance of the force of a block, of which so many follow within one gust."""
        return max(FORCE, residual) ** 2 * max(1.0, 2.0 * self.correlation_s / seconds)


class ForceNoise:
    """Variance of the force about the model, learnt while it is used."""

    def __init__(self, noise: DragNoise) -> None:
        """Start with the first residual."""
        self._noise = noise
        self.residual = FIRST_RESIDUAL
        """Root mean square of what is left of the force, m/s²."""

    def variance(self, spread: Array, innovation: Array, seconds: float) -> float:
        """Variance for one measurement, larger for an outlier; what is left of it is learnt.

        Args:
            spread: Covariance of the expected force, (m/s²)², shape (2, 2).
            innovation: Measured minus expected, m/s², shape (2,).
            seconds: Length of the interval that the force is the mean of.
        """
        r, eye = self._noise.variance(self.residual, seconds), np.eye(2)
        size = math.sqrt(0.5 * float(innovation @ np.linalg.solve(spread + r * eye, innovation)))
        r *= max(1.0, size / HUBER)
        left = r * np.linalg.solve(spread + r * eye, innovation)
        square = min(0.5 * float(left @ left), (4.0 * self.residual) ** 2)
        memory = min(1.0, seconds / MEMORY_S)
        self.residual = math.sqrt(self.residual**2 + memory * (square - self.residual**2))
        return r
