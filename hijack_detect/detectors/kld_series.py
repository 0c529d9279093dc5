# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Divergence between successive windows of one parameter."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple, Protocol

from hijack_detect.detectors.poisson import log_pmf, mixed_divergence


class Divergence(NamedTuple):
    """Kullback-Leibler divergences between the last window and the one before, nats.

    Attributes:
        forward: Of the last window from the one before (Eqs. 7-12), large when values fall.
        backward: Of the one before from the last (Eq. 13), large when values rise.
    """

    forward: float
    backward: float

    @property
    def total(self) -> float:
        """Their sum, which thresholds are for."""
        return self.forward + self.backward


class Series(Protocol):
    """Takes the counts of one parameter, one by one."""

    def add(self, count: float) -> Divergence | None:
        """Take the next count; None while there are too few."""
        ...


class RowSeries:
    """Eqs. 1-13 of Basan 2022: sums over the probabilities of the values, not normalised.

    P of each value is that of a Poisson distribution whose mean is that of the last n values.
    `forward = Σ P ln(P / P')` over the last n, with P' of the value n before; `backward = Σ P'
    ln(P' / P)`. As the probabilities of a window do not add up to 1, both can be negative (§2.1).
    """

    def __init__(self, length: int) -> None:
        """Start empty; n is `length`."""
        self._length = length
        self._values: deque[float] = deque(maxlen=length)
        self._logs: deque[float] = deque(maxlen=2 * length)

    def add(self, count: float) -> Divergence | None:
        """See Series."""
        self._values.append(count)
        if len(self._values) < self._length:
            return None
        self._logs.append(log_pmf(count, math.fsum(self._values) / self._length))
        if len(self._logs) < 2 * self._length:
            return None
        logs = list(self._logs)
        pairs = list(zip(logs[: self._length], logs[self._length :], strict=True))
        forward = math.fsum(math.exp(now) * (now - before) for before, now in pairs)
        backward = math.fsum(math.exp(before) * (before - now) for before, now in pairs)
        return Divergence(forward, backward)


class DistributionSeries:
    """Divergences of the whole distributions that the means of two windows stand for.

    They are true Kullback-Leibler divergences: never negative, 0 only for equal means. They ask by
    what factor a mean has changed and how much that weighs, so the noise of a bad receiver is
    normal as long as it stays. The distributions are negative binomial: sizes of noise scatter as
    widely as they are large, and under Poisson's law those of a noisy receiver would be changes.
    """

    def __init__(self, length: int, floor: float, shape: float) -> None:
        """Start empty.

        Args:
            length: Counts in a window.
            floor: What is added to every mean.
            shape: k of the negative binomial distributions.
        """
        self._length, self._floor, self._shape = length, floor, shape
        self._values: deque[float] = deque(maxlen=2 * length)

    def add(self, count: float) -> Divergence | None:
        """See Series."""
        self._values.append(count)
        if len(self._values) < 2 * self._length:
            return None
        values = list(self._values)
        before = self._floor + math.fsum(values[: self._length]) / self._length
        now = self._floor + math.fsum(values[self._length :]) / self._length
        return Divergence(
            mixed_divergence(now, before, self._shape), mixed_divergence(before, now, self._shape)
        )
