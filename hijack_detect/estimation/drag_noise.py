# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What is assumed of wind and drag, and how well drag explains the force of this vehicle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.rotation import Array

HUBER = 2.0
"""Residuals beyond so many standard deviations count linearly: gusts and bad samples."""
MEMORY_S = 30.0
"""The residual is that of about so long."""


@dataclass(frozen=True)
class DragNoise:
    """What the filter assumes; standard deviations, walks are per square root of a second.

    Attributes:
        force: Of the force of one block about the model, at least, m/s².
        first_residual: The same, before it is measured, m/s².
        correlation_s: How long a gust keeps such an error.
        wind: First wind, m/s.
        drag: Mean and deviation of the first k, 1/s.
        quadratic: Mean and deviation of the first q, 1/m.
        bias: First bias, m/s².
        wind_walk: m/s.
        drag_walk: 1/s.
        bias_walk: m/s².
    """

    force: float = 0.08
    first_residual: float = 0.25
    correlation_s: float = 1.0
    wind: float = 6.0
    drag: tuple[float, float] = (0.25, 0.08)
    quadratic: tuple[float, float] = (0.0, 0.01)
    bias: float = 0.2
    wind_walk: float = 0.15
    drag_walk: float = 0.002
    bias_walk: float = 0.005

    @property
    def sigmas(self) -> tuple[float, ...]:
        """First standard deviations of wind (2), k, q and bias (2)."""
        return (self.wind, self.wind, self.drag[1], self.quadratic[1], self.bias, self.bias)

    @property
    def walks(self) -> tuple[float, ...]:
        """Random walks of wind (2), k, q and bias (2)."""
        wind, bias = self.wind_walk, self.bias_walk
        return (wind, wind, self.drag_walk, 0.0, bias, bias)

    def variance(self, residual: float, seconds: float) -> float:
        """Variance of the force of a block, of which so many follow within one gust."""
        return max(self.force, residual) ** 2 * max(1.0, 2.0 * self.correlation_s / seconds)


class ForceNoise:
    """Variance of the force about the model, learnt while it is used."""

    def __init__(self, noise: DragNoise) -> None:
        """Start with the first residual."""
        self._noise = noise
        self.residual = noise.first_residual
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
