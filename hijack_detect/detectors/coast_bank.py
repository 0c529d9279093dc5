# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Onsets of an attack: the offset acceleration since each, and the score of a run of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from hijack_detect.detectors.onset_bank import OnsetBank
from hijack_detect.estimation.ekf import Source
from hijack_detect.estimation.lag_ekf import Measured, Propagated
from hijack_detect.estimation.rotation import Array

AXES = 2
"""East and North; the vertical is the altitude detector's."""
TINY = 1e-9
"""Keeps the information of an onset invertible before its first measurement."""
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
    """`OnsetBank` of a constant acceleration of the GPS.

    A spoofer who adds a constant acceleration a since an onset T ago adds ½T²a to the position
    and Ta to the velocity. States may have begun to change at the same time, as a wind does in a
    gust: by a step, and by a ramp. With the inverse of their prior variances added to C, a is what
    no such change explains.
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
        steps = [one.step for one in changes.values()]
        ramps = [one.ramp for one in changes.values()]
        self._prior = np.diag([TINY] * AXES + [sigma**-2 for sigma in steps + ramps])
        begun, growing = np.zeros((2, size, len(self._prior)))
        begun[list(changes), AXES : AXES + len(steps)] = np.eye(len(steps))
        growing[list(changes), AXES + len(steps) :] = np.eye(len(ramps))
        self._bank = OnsetBank(begun, growing)
        self._since_s = spacing_s

    def propagate(self, step: Propagated) -> None:
        """The filter moved on."""
        self._bank.propagate(step.dt_s, step.transition, self._oldest)
        self._since_s += step.dt_s
        if self._since_s >= self._spacing:
            self._since_s = 0.0
            self._bank.begin()

    def measure(self, step: Measured) -> None:
        """The filter used a measurement."""
        offset = None
        if step.horizontal and step.source in GROWTH:
            age = self._bank.age_s
            offset = np.zeros((len(step.innovation.residual), len(age), len(self._prior)))
            for axis in range(AXES):
                offset[axis, :, axis] = GROWTH[step.source](age)
        self._bank.measure(step.innovation, offset)

    def offsets(self, *, changed: bool = False) -> Offsets:
        """The most likely offsets now; `changed` lets the states change as they may."""
        bank = self._bank
        at, n = bank.age_s >= self._youngest, len(self._prior) if changed else AXES
        information = (bank.c[at] + self._prior)[:, :n, :n]
        joint = np.asarray(np.linalg.inv(information), dtype=float)
        acceleration = np.einsum("nij,nj->ni", joint, bank.d[at][:, :n])[:, :AXES]
        return Offsets(bank.age_s[at], acceleration, joint[:, :AXES, :AXES])


SLACK_S = 0.15
"""A run may fall short of its span by this much: onsets begin with a fix.
Chosen, not swept."""


@dataclass(frozen=True, slots=True)
class Sustained:
    """The score of a run of successive onsets.

    Attributes:
        score: The least within the run.
        best: Index of the onset in the run with the largest.
        deviation: The least deviation for which every onset of some run speaks: times a limit,
            the smallest offset that exceeds it.
    """

    score: float
    best: int
    deviation: float


def sustained(age_s: Array, score: Array, deviation: Array, span_s: float) -> Sustained | None:
    """The run of onsets over `span_s` whose least score is the largest.

    An attack is seen from every onset about its own. An error that is over fits one onset only,
    the one that begins with it, and is no attack however large it is.

    Args:
        age_s: Ages of the onsets, s, shape (n,).
        score: Their scores, shape (n,).
        deviation: The offset with a score of 1, shape (n,).
        span_s: Length of a run, s.

    Returns:
        None while the onsets do not span a run.
    """
    younger = age_s[:, None] - age_s[None, :]
    inside = (younger >= 0.0) & (younger <= span_s)
    whole = np.flatnonzero(age_s - span_s >= np.min(age_s, initial=np.inf) - SLACK_S)
    if len(whole) == 0:
        return None
    inside = inside[whole]
    least = np.min(np.where(inside, score, np.inf), axis=1)
    run = int(np.argmax(least))
    best = int(np.argmax(np.where(inside[run], score, -np.inf)))
    visible = np.max(np.where(inside, deviation, 0.0), axis=1)
    return Sustained(float(least[run]), best, float(np.min(visible)))
