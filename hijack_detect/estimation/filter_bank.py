# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Several filters that differ in heading, until the motion shows which one is right."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable

import numpy as np

from hijack_detect.estimation.ekf import Ekf, Observation
from hijack_detect.estimation.rotation import heading

HEADINGS = 8
"""Filters that a bank starts with, 45° apart: each finds its way from ±30° of the truth."""
PRUNE_NATS = 12.0
"""A filter this much less likely than the best is dropped (a ratio of 160,000).
Chosen, not swept."""
SAME_RAD = math.radians(15.0)
"""Filters whose headings have come this close follow the same motion: the likelier is kept.
Chosen, not swept."""


class FilterBank:
    """Filters with different headings, weighted by the likelihood of their innovations.

    A first course is only a guess of the heading: a multirotor may fly sideways. Accelerations
    measured by GPS and accelerometer agree for one heading only.

    Attributes:
        best: The most likely filter.
    """

    def __init__(self, ekf: Ekf) -> None:
        """Start with one filter."""
        self._filters = [ekf]
        self._scores = [0.0]
        self.best = ekf

    @property
    def decided(self) -> bool:
        """Whether one heading is left."""
        return len(self._filters) == 1

    def split(self, sigma: float) -> None:
        """Replace the best filter with filters in all directions, its own among them.

        Args:
            sigma: Standard deviation of the heading of each, rad.
        """
        origin = self.best
        self._filters = []
        for k in range(HEADINGS):
            turned = copy.deepcopy(origin)
            turned.turn(k * math.tau / HEADINGS, sigma)
            self._filters.append(turned)
        self._scores = [0.0] * HEADINGS
        self.best = self._filters[0]

    def apply(self, action: Callable[[Ekf], None]) -> None:
        """Do something to every filter."""
        for ekf in self._filters:
            action(ekf)

    def measure(self, observe: Callable[[Ekf], Observation]) -> None:
        """Update every filter with a measurement and drop those that it makes unlikely.

        Args:
            observe: The measurement as a filter takes it.
        """
        if self.decided:
            self.best.update(observe(self.best))
            return
        for k, ekf in enumerate(self._filters):
            self._scores[k] += ekf.update(observe(ekf)).log_likelihood()
        self._prune()

    def _prune(self) -> None:
        order = np.argsort(self._scores)[::-1].tolist()
        top = self._scores[order[0]]
        kept: list[int] = []
        for k in order:
            near = any(self._apart(k, other) < SAME_RAD for other in kept)
            if not near and top - self._scores[k] < PRUNE_NATS:
                kept.append(k)
        self._filters = [self._filters[k] for k in kept]
        self._scores = [self._scores[k] for k in kept]
        self.best = self._filters[0]

    def _apart(self, a: int, b: int) -> float:
        one, other = (heading(self._filters[k].attitude) for k in (a, b))
        return abs(math.remainder(one - other, math.tau))
