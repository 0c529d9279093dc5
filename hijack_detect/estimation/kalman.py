# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The Kalman measurement update, which every filter of the package uses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.rotation import Array


@dataclass(frozen=True, slots=True)
class Innovation:
    """A measurement's disagreement with its prediction, and how the filter weighed it.

    Attributes:
        H: Observation matrix, shape (m, n) for n states.
        residual: Measured minus predicted, shape (m,).
        precision: S⁻¹, inverse of the residual's covariance S = H P Hᵀ + R, shape (m, m).
        K: Kalman gain, shape (n, m).
    """

    H: Array
    residual: Array
    precision: Array
    K: Array

    @property
    def correction(self) -> Array:
        """Correction of the state, K times the residual, shape (n,)."""
        return self.K @ self.residual

    @property
    def distance(self) -> float:
        """Squared Mahalanobis distance of the residual, χ² with m degrees of freedom."""
        return float(self.residual @ self.precision @ self.residual)

    def log_likelihood(self) -> float:
        """Logarithm of the residual's density, without its constant term."""
        return float(0.5 * (np.linalg.slogdet(self.precision)[1] - self.distance))


def update(P: Array, H: Array, residual: Array, R: Array) -> tuple[Innovation, Array]:
    """Weigh a measurement and reduce the covariance, in the form of Bucy and Joseph.

        S = H P Hᵀ + R,   K = P Hᵀ S⁻¹,   P⁺ = (I − K H) P (I − K H)ᵀ + K R Kᵀ

    P⁺ stays symmetric and positive in floating-point numbers, where (I − K H) P does not
    (Bucy and Joseph, Filtering for Stochastic Processes, 1968, ch. 16).

    Args:
        P: Covariance of the state, shape (n, n); it is not changed.
        H: Observation matrix, shape (m, n).
        residual: Measured minus predicted, shape (m,).
        R: Variances of the measurement noise, uncorrelated, shape (m,).

    Returns:
        The innovation, whose `correction` is to be added to the state, and P⁺.
    """
    HP = H @ P
    S = HP @ H.T
    add_diagonal(S, slice(0, len(R)), R)
    precision = np.asarray(np.linalg.inv(S), dtype=float)
    K = HP.T @ precision
    kept = -(K @ H)
    add_diagonal(kept, slice(0, len(kept)), 1.0)
    return Innovation(H, residual, precision, K), kept @ P @ kept.T + (K * R) @ K.T


def add_diagonal(matrix: Array, block: slice, values: Array | float) -> None:
    """Add to the diagonal of some rows of a square matrix, in place."""
    step = len(matrix) + 1
    matrix.flat[block.start * step : block.stop * step : step] += values
