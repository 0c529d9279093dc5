# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Likelihood of offsets of a measurement since each of many onsets."""

from __future__ import annotations

import math

import numpy as np

from hijack_detect.estimation.kalman import Innovation
from hijack_detect.estimation.rotation import Array


class OnsetBank:
    """Generalised likelihood ratio over onsets (Willsky and Jones 1976).

    An offset in the measurements since an onset, o per unit of its size, makes an error of f in
    the filter that follows them, and shows g in its innovations:

        g = o − H f,   f⁺ = f + K g,   f⁻ = Φ f⁺

    With d = Σ gᵀS⁻¹r and C = Σ gᵀS⁻¹g the most likely sizes are C⁻¹d with covariance C⁻¹. What the
    filter has learnt from the offset is in f, so the offset cannot hide in it.

    Offsets of a state instead are an error f from the onset on (`begun`), or one that grows
    (`growing`), and no o.

    Attributes:
        age_s: Time since each onset, the oldest first, s, shape (onsets,).
        d: Shape (onsets, offsets).
        c: Shape (onsets, offsets, offsets).
    """

    def __init__(self, begun: Array, growing: Array) -> None:
        """Start without onsets.

        Args:
            begun: f with which an onset begins, shape (states, offsets).
            growing: What each second adds to f, shape (states, offsets).
        """
        states, n = begun.shape
        self._begun, self._growing = begun[:, None], growing[:, None]
        self.age_s: Array = np.zeros(0)
        self._f: Array = np.zeros((states, 0, n))
        self.d: Array = np.zeros((0, n))
        self.c: Array = np.zeros((0, n, n))

    def propagate(self, dt_s: float, phi: Array, oldest_s: float = math.inf) -> None:
        """The filter moved on.

        Args:
            dt_s: By this, s.
            phi: Φ, shape (states, states).
            oldest_s: Onsets that are then older are dropped, s.
        """
        self.age_s = self.age_s + dt_s
        self.forget(oldest_s)
        self._f = _times(phi, self._f)
        self._f += dt_s * self._growing

    def forget(self, oldest_s: float) -> None:
        """Drop the onsets beyond an age, s."""
        first = int(np.count_nonzero(self.age_s > oldest_s))
        self.age_s, self.d, self.c = self.age_s[first:], self.d[first:], self.c[first:]
        self._f = self._f[:, first:]

    def begin(self) -> None:
        """Begin an onset now."""
        n = self.d.shape[1]
        self.age_s = np.append(self.age_s, 0.0)
        self._f = np.concatenate([self._f, self._begun], axis=1)
        self.d = np.concatenate([self.d, np.zeros((1, n))])
        self.c = np.concatenate([self.c, np.zeros((1, n, n))])

    def measure(self, found: Innovation, offset: Array | None = None) -> None:
        """The filter used a measurement.

        Args:
            found: Its innovation of m components.
            offset: o since each onset, shape (m, onsets, offsets); None for a measurement that no
                offset is in.
        """
        g = -_times(found.H, self._f)
        if offset is not None:
            g += offset
        weighted = _times(found.precision, g)
        self.d = self.d + _times(found.residual[None], weighted)[0]
        self.c = self.c + weighted.transpose(1, 2, 0) @ g.transpose(1, 0, 2)
        self._f = self._f + _times(found.K, g)


def _times(matrix: Array, columns: Array) -> Array:
    """A matrix of shape (a, b) times all columns of shape (b, m, n), as one product."""
    rows, m, n = columns.shape
    product: Array = matrix @ columns.reshape(rows, m * n)
    return product.reshape(len(matrix), m, n)
