# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Likelihood of an offset of the GPS height since each of many onsets (Willsky and Jones 1976)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.kalman import Innovation
from hijack_detect.estimation.rotation import Array

ACCELERATION, VELOCITY, RATE, STEP = range(4)
"""Offsets: an acceleration; a velocity; a height that moves without the velocity; a jump."""
SIGNATURES = 4
SPACING_S = 0.79
"""Onsets are this far apart; no whole number of fixes, so that they differ."""
YOUNGEST_S = 1.0
"""A younger onset is not judged: two fixes are no evidence."""
OLDEST_S = 21.0
FLOOR_ACCELERATION = 0.15
"""m/s²: error of scale and attitude that lasts."""
FLOOR_VELOCITY = 0.4
"""m/s: error of a GPS velocity that lasts."""
FLOOR_HEIGHT = 2.0
"""m: jump of a GPS height when the satellites in use change."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """The most likely offset of one signature: standard deviations, its size and its age."""

    score: float
    size: float
    age_s: float


class OnsetBank:
    """Generalised likelihood ratio of constant offsets, each since an assumed onset.

    An offset o(t) = [height, velocity] in the measurement shifts the filter's error by f and the
    innovation by g = o − H f; f follows the filter, f⁺ = F (f + K g). With d = Σ gᵀS⁻¹r and
    C = Σ gᵀS⁻¹g the size is d/C with variance 1/C. The floors are systematic errors that do not
    average out. What the filter itself has learnt from a false offset is in f.
    """

    def __init__(self) -> None:
        """Start without onsets."""
        self._onsets = np.zeros(0)
        self._shift = np.zeros((0, SIGNATURES, 4))
        self._d = np.zeros((0, SIGNATURES))
        self._c = np.zeros((0, SIGNATURES))
        self._next_s: float | None = None

    def update(self, t_s: float, f: Array, found: Innovation) -> None:
        """Account one measurement of height and velocity.

        Args:
            t_s: Its time, seconds.
            f: Transition to this time, shape (4, 4).
            found: What the filter made of it.
        """
        age = t_s - self._onsets
        offset = np.zeros((len(age), SIGNATURES, 2))
        offset[:, ACCELERATION, 0] = 0.5 * age * age
        offset[:, ACCELERATION, 1] = age
        offset[:, VELOCITY, 0] = age
        offset[:, VELOCITY, 1] = 1.0
        offset[:, RATE, 0] = age
        offset[:, STEP, 0] = 1.0
        shift = self._shift @ f.T
        g = offset - shift @ found.H.T
        weighted = g @ found.precision
        self._d += weighted @ found.residual
        self._c += np.sum(weighted * g, axis=2)
        self._shift = shift + g @ found.K.T
        self._renew(t_s)

    def _renew(self, t_s: float) -> None:
        """Forget old onsets and begin a new one."""
        if self._next_s is not None and t_s < self._next_s:
            return
        self._next_s = t_s + SPACING_S
        kept = t_s - self._onsets <= OLDEST_S
        self._onsets = np.append(self._onsets[kept], t_s)
        zeros = np.zeros((1, SIGNATURES))
        self._shift = np.concatenate([self._shift[kept], np.zeros((1, SIGNATURES, 4))])
        self._d = np.concatenate([self._d[kept], zeros])
        self._c = np.concatenate([self._c[kept], zeros])

    def evidence(self, t_s: float, wander: float = 1.0) -> list[Evidence]:
        """The strongest evidence for each signature, in their order.

        Args:
            t_s: The time, seconds.
            wander: Jumps of the height that do not count, over FLOOR_HEIGHT.
        """
        age = t_s - self._onsets
        judged = age >= YOUNGEST_S
        if not judged.any():
            return [Evidence(0.0, 0.0, 0.0)] * SIGNATURES
        age, d, c = age[judged], self._d[judged], np.maximum(self._c[judged], 1e-12)
        height = FLOOR_HEIGHT * wander
        slow = FLOOR_VELOCITY**2 + (height / age) ** 2
        floors = np.stack(
            [
                FLOOR_ACCELERATION**2 + (FLOOR_VELOCITY / age) ** 2,
                slow,
                slow,
                np.full(len(age), height**2),
            ],
            axis=1,
        )
        size = d / c
        score = np.abs(size) / np.sqrt(1.0 / c + floors)
        best = np.argmax(score, axis=0)
        return [
            Evidence(float(score[at, one]), float(size[at, one]), float(age[at]))
            for one, at in enumerate(best)
        ]
