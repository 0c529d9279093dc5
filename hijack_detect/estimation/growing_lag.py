# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Lags of the GPS velocities that explain the differences, where the latency may grow in flight."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hijack_detect.estimation.lag_ekf import GROWTH
from hijack_detect.estimation.rotation import Array

Lags: TypeAlias = npt.NDArray[np.bool_]
"""One of each lag of the grid, shape (n,)."""

STEP_S = 0.1
"""Between two lags of the grid, s: at 5 m/s², the hardest turn of the recorded flights, a lag that
is wrong by half of it is an error of 0.1 m/s² in a mean over 2 s."""
EARLIER = 1
"""Lags of the grid below the usual one: recorded receivers have 0.02 to 0.28 s, and 0.15 s is
usual."""
REFUTED = 9.0
"""A lag is refuted if its cost is larger than the least one by this: 3 standard deviations."""
DOUBTED = 2.0
"""A lag in use is given up if its cost is larger than the least one by this: far less than what
refutes it, since the differences of a wrong lag would be learnt as noise, in which no lag can be
refuted. With 9, a latency that grew to 1 s is named as 0.45 s, and the limit is three times as
high."""
JUMP = 18.0
"""Cost of a latency that jumps: it must be refuted at any lag it can have got to, and once more."""


class GrowingLag:
    """The cost of each lag: what the differences seen so far cost against its best history.

    A history of the lag is a walk over the grid, no faster than GROWTH; its cost is the sum of the
    squares of the differences that were seen at its lags, in units of their usual variance. The
    least cost of all walks that end at a lag follows from those a step before (Viterbi 1967). Where
    nothing is felt, all lags have the same difference: no cost changes, and costs spread over the
    lags that can be reached. An acceleration that only the GPS has is no argument for any lag.
    """

    def __init__(self, usual_s: float, largest_s: float) -> None:
        """Start with the usual lag.

        Args:
            usual_s: Lag of most receivers, s.
            largest_s: Largest lag of the grid, s; none but the usual one if it is not larger.
        """
        more = max(0, round((largest_s - usual_s) / STEP_S))
        self.usual = min(EARLIER, int(usual_s / STEP_S)) if more else 0
        """Index of the usual lag."""
        self.lags_s: Array = usual_s + STEP_S * np.arange(-self.usual, more + 1, dtype=np.float64)
        """The grid, s, shape (n,)."""
        self._cost: Array = np.full(len(self.lags_s), JUMP)
        self._cost[: 2 * self.usual + 1] = 0.0
        self._moved_s = 0.0
        self.held = self.usual
        """Index of the lag in use: it changes only where it is doubted, to the nearest one."""

    @property
    def grows(self) -> bool:
        """Whether there is any lag but the usual one."""
        return len(self._cost) > 1

    @property
    def possible(self) -> Lags:
        """Lags that are not refuted."""
        found: Lags = self._cost <= REFUTED
        return found

    @property
    def judged(self) -> Lags:
        """Lags that are not refuted, and the usual one: a receiver that recovers has it at once."""
        found = self.possible
        found[self.usual] = True
        return found

    @property
    def least_s(self) -> float:
        """The least lag that is not refuted, s."""
        return float(self.lags_s[int(np.argmax(self.possible))])

    def update(self, seconds: float, squares: Array) -> None:
        """Take differences.

        Args:
            seconds: Time since the last ones.
            squares: Of the difference at each lag in units of the usual variance, times the part
                of an independent observation that it is, shape (n,).
        """
        cost = self._cost + squares
        self._moved_s = min(self._moved_s + GROWTH * seconds, len(cost) * STEP_S)
        while self._moved_s >= STEP_S:
            self._moved_s -= STEP_S
            nearby = cost.copy()
            np.minimum(nearby[1:], cost[:-1], out=nearby[1:])
            np.minimum(nearby[:-1], cost[1:], out=nearby[:-1])
            cost = nearby
        self._cost = np.minimum(cost - cost.min(), JUMP)
        fitting = np.flatnonzero(self._cost <= DOUBTED)
        self.held = int(fitting[np.argmin(np.abs(fitting - self.held))])
