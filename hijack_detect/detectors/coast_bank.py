# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Likelihood of a constant offset acceleration of the GPS since each of many onsets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.ekf import Source
from hijack_detect.estimation.lag_ekf import Measured, Propagated
from hijack_detect.estimation.rotation import Array

AXES = 2
"""East and North; the vertical is the altitude detector's."""
TINY = 1e-9
GROWTH: Mapping[Source, Callable[[Array], Array]] = {
    Source.POSITION: lambda age: 0.5 * age**2,
    Source.VELOCITY: lambda age: age,
}
"""What 1 m/s² since an onset adds to the measurements that a spoofed GPS is the source of."""


@dataclass(frozen=True, slots=True)
class Change:
    """How a state may change with an onset: standard deviations of a step and a ramp (1/s)."""

    step: float
    ramp: float


@dataclass(frozen=True, slots=True)
class Offsets:
    """The most likely offset acceleration since each onset, the oldest first.

    Attributes:
        age_s: Time since the assumed onset, s, shape (n,).
        acceleration: East and North, m/s², shape (n, 2).
        covariance: By the filter's own error model, (m/s²)², shape (n, 2, 2).
    """

    age_s: Array
    acceleration: Array
    covariance: Array

    @property
    def size(self) -> Array:
        """Length of the acceleration, m/s², shape (n,)."""
        return np.hypot(self.acceleration[:, 0], self.acceleration[:, 1])

    @property
    def sigma(self) -> Array:
        """Standard deviation of the acceleration, m/s², shape (n,)."""
        deviation: Array = np.sqrt(0.5 * np.trace(self.covariance, axis1=1, axis2=2))
        return deviation

    @property
    def whitened(self) -> Array:
        """Square of the acceleration in standard deviations, mean of the two axes, (n,)."""
        unit = np.linalg.solve(self.covariance, self.acceleration[:, :, None])[:, :, 0]
        mean: Array = 0.5 * np.einsum("ni,ni->n", unit, self.acceleration)
        return mean


class CoastBank:
    """Generalised likelihood ratio over onsets (Willsky and Jones 1976).

    A spoofer who adds a constant acceleration a since an onset T ago adds ½T²a to the position
    and Ta to the velocity. The filter is a victim: its error is then f a, with f⁺ = Φ(f + K g)
    and the innovation g a, where g = [½T²; T] − H f. With d = Σ gᵀS⁻¹r and C = Σ gᵀS⁻¹g the
    most likely a is C⁻¹d with covariance C⁻¹. What the filter has learnt from the spoof is in
    f, so the spoof cannot hide in it.

    States may have begun to change at the same time, as a wind does in a gust. A step is an error
    of the state from the onset on and a ramp one that grows, so each has a column of f of its
    own. With the inverse of their prior variances in C, a is what no such change explains.
    """

    def __init__(
        self,
        size: int,
        youngest_s: float,
        oldest_s: float,
        spacing_s: float,
        changes: Mapping[int, Change] | None = None,
    ) -> None:
        """Begin an onset every `spacing_s` and judge those between two ages.

        Args:
            size: Number of the filter's error states.
            youngest_s: An onset is judged from this age on, s.
            oldest_s: And until this one, s.
            spacing_s: Least time between two onsets, s.
            changes: How states may change with an onset.
        """
        self._youngest, self._oldest, self._spacing = youngest_s, oldest_s, spacing_s
        changes = changes or {}
        steps, ramps = (
            [one.step for one in changes.values()],
            [one.ramp for one in changes.values()],
        )
        self._prior = np.diag([TINY] * AXES + [sigma**-2 for sigma in steps + ramps])
        n = len(self._prior)
        states = list(changes)
        self._begun = np.zeros((size, 1, n))
        self._begun[states, 0, AXES : AXES + len(steps)] = np.eye(len(steps))
        self._growing = np.zeros((size, 1, n))
        self._growing[states, 0, AXES + len(steps) :] = np.eye(len(ramps))
        self._since_s = spacing_s
        self._age: Array = np.zeros(0)
        self._shift: Array = np.zeros((size, 0, n))
        """f of every onset: errors of the filter by columns of offsets."""
        self._d: Array = np.zeros((0, n))
        self._c: Array = np.zeros((0, n, n))

    def propagate(self, step: Propagated) -> None:
        """The filter moved on."""
        age = self._age + step.dt_s
        first = int(np.count_nonzero(age > self._oldest))
        self._age, self._d, self._c = age[first:], self._d[first:], self._c[first:]
        self._shift = _times(step.transition, self._shift[:, first:])
        self._shift += step.dt_s * self._growing
        self._since_s += step.dt_s
        if self._since_s >= self._spacing:
            self._since_s = 0.0
            self._age = np.append(self._age, 0.0)
            n = len(self._prior)
            self._shift = np.concatenate([self._shift, self._begun], axis=1)
            self._d = np.concatenate([self._d, np.zeros((1, n))])
            self._c = np.concatenate([self._c, np.zeros((1, n, n))])

    def measure(self, step: Measured) -> None:
        """The filter used a measurement."""
        said = step.innovation
        g = -_times(said.H, self._shift)
        if step.horizontal and step.source in GROWTH:
            grown = GROWTH[step.source](self._age)
            for axis in range(AXES):
                g[axis, :, axis] += grown
        weighted = _times(said.precision, g)
        self._d = self._d + _times(said.residual[None], weighted)[0]
        self._c = self._c + weighted.transpose(1, 2, 0) @ g.transpose(1, 0, 2)
        self._shift = self._shift + _times(said.K, g)

    def offsets(self, *, changed: bool = False) -> Offsets:
        """The most likely offsets now; `changed` lets the states change as they may."""
        at, n = self._age >= self._youngest, len(self._prior) if changed else AXES
        information = (self._c[at] + self._prior)[:, :n, :n]
        joint = np.asarray(np.linalg.inv(information), dtype=float)
        acceleration = np.einsum("nij,nj->ni", joint, self._d[at][:, :n])[:, :AXES]
        return Offsets(self._age[at], acceleration, joint[:, :AXES, :AXES])


def _times(matrix: Array, columns: Array) -> Array:
    """A matrix of shape (a, b) times all columns of shape (b, m, n), as one product."""
    rows, m, n = columns.shape
    product: Array = matrix @ columns.reshape(rows, m * n)
    return product.reshape(len(matrix), m, n)
