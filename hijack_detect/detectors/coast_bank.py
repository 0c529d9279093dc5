"""Likelihood of a constant offset acceleration of the GPS since each of many onsets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.ekf import POSITION
from hijack_detect.estimation.lag_ekf import SIZE, Measured, Propagated
from hijack_detect.estimation.rotation import Array

AXES = 2
"""East and North; the vertical is the altitude detector's."""
TINY = 1e-9


@dataclass(frozen=True, slots=True)
class Offsets:
    """The most likely offset acceleration for each age that was asked for.

    Attributes:
        age_s: Time since the assumed onset, s, shape (n,); ages not reached yet are left out.
        acceleration: East and North, m/s², shape (n, 2).
        sigma: Its standard deviation by the filter's own error model, m/s², shape (n,).
        whitened: Square of the acceleration in standard deviations, mean of the two axes, (n,).
    """

    age_s: Array
    acceleration: Array
    sigma: Array
    whitened: Array


class CoastBank:
    """Generalised likelihood ratio over onsets (Willsky and Jones 1976).

    A spoofer who adds a constant acceleration a since an onset T ago adds ½T²a to the position
    and Ta to the velocity. The filter is a victim: its error is then f a, with f⁺ = Φ(f + K g)
    and the innovation g a, where g = [½T²; T] − H f. With d = Σ gᵀS⁻¹r and C = Σ gᵀS⁻¹g the
    most likely a is C⁻¹d with covariance C⁻¹. What the filter has learnt from the spoof is in
    f, so the spoof cannot hide in it.
    """

    def __init__(self, ages_s: Sequence[float], spacing_s: float) -> None:
        """Begin an onset every `spacing_s`; ask for those nearest to `ages_s`."""
        self._ages = np.asarray(ages_s, dtype=float)
        self._spacing = spacing_s
        self._since_s = spacing_s
        self._age: Array = np.zeros(0)
        self._shift: Array = np.zeros((0, SIZE, AXES))
        self._d: Array = np.zeros((0, AXES))
        self._c: Array = np.zeros((0, AXES, AXES))

    def propagate(self, step: Propagated) -> None:
        """The filter moved on."""
        kept = self._age + step.dt_s <= self._ages[-1] + self._spacing
        self._age = self._age[kept] + step.dt_s
        self._shift = step.transition @ self._shift[kept]
        self._d, self._c = self._d[kept], self._c[kept]
        self._since_s += step.dt_s
        if self._since_s >= self._spacing:
            self._since_s = 0.0
            self._age = np.append(self._age, 0.0)
            self._shift = np.concatenate([self._shift, np.zeros((1, SIZE, AXES))])
            self._d = np.concatenate([self._d, np.zeros((1, AXES))])
            self._c = np.concatenate([self._c, np.zeros((1, AXES, AXES))])

    def measure(self, step: Measured) -> None:
        """The filter used a measurement."""
        g = -(step.h @ self._shift)
        if step.block is not None:
            power = 0.5 * self._age**2 if step.block is POSITION else self._age
            g[:, :AXES, :] += power[:, None, None] * np.eye(AXES)
        weighted = np.swapaxes(g, 1, 2) @ step.precision
        self._d = self._d + weighted @ step.innovation
        self._c = self._c + weighted @ g
        self._shift = self._shift + step.gain @ g

    def offsets(self) -> Offsets:
        """The most likely offsets now."""
        if len(self._age) == 0:
            return Offsets(np.zeros(0), np.zeros((0, AXES)), np.zeros(0), np.zeros(0))
        nearest = np.abs(self._age[None, :] - self._ages[:, None]).argmin(axis=1)
        reached = np.abs(self._age[nearest] - self._ages) <= 0.75 * self._spacing
        at = nearest[reached]
        covariance = np.linalg.inv(self._c[at] + TINY * np.eye(AXES))
        acceleration = np.einsum("nij,nj->ni", covariance, self._d[at])
        whitened = 0.5 * np.einsum("ni,ni->n", self._d[at], acceleration)
        sigma = np.sqrt(0.5 * np.trace(covariance, axis1=1, axis2=2))
        return Offsets(self._age[at], acceleration, sigma, whitened)
