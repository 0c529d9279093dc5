# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From the margin of a detector to a likelihood ratio: attacked against clean."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

from hijack_detect.detectors.verdict import Verdict

SMALLEST_MARGIN = 0.01


@dataclass(frozen=True)
class LikelihoodRatio:
    """ln p(margin | attacked) / p(margin | clean), a logistic law of the margin's logarithm.

    Attributes:
        slope: Nats for each factor e of the margin.
        neutral: Margin that says nothing.
        low: The least that it can say, nats: how much a quiet detector speaks for the GPS.
        high: The most that it can say, nats: how rare such a margin can be claimed to be from
            the clean flights that there are.
    """

    slope: float
    neutral: float
    low: float
    high: float

    def __call__(self, margin: float) -> float:
        """Nats for a margin."""
        nats = self.slope * math.log(max(margin, SMALLEST_MARGIN) / self.neutral)
        return min(max(nats, self.low), self.high)


RATIOS: Mapping[str, LikelihoodRatio] = {
    "correlation": LikelihoodRatio(19.94, 0.9, -0.08, 2.1),
    "date": LikelihoodRatio(13.0, 0.69, -0.1, 4.88),
    "kld": LikelihoodRatio(6.64, 0.47, -0.1, 5.04),
    "coast": LikelihoodRatio(8.66, 0.54, -0.1, 5.29),
    "gnss": LikelihoodRatio(11.17, 0.6, -0.1, 5.65),
    "altitude": LikelihoodRatio(21.84, 0.79, -0.1, 5.11),
    "heading": LikelihoodRatio(0.0, 0.38, 0.0, 0.0),
    "drag": LikelihoodRatio(10.39, 0.77, -0.1, 2.7),
}
"""By detector. Fitted on half of the flights by benchmarks/fusion_calibration.py, which see."""

CARRY_OFF = frozenset({"coast", "date", "drag"})
"""Detectors that could see a carry-off: only they count where a flight is said to be watched."""

SHARED = frozenset({"coast", "drag"})
"""Detectors that both feel the drag of the air: the one that says most counts for both."""

SOFT = frozenset({"drag", "heading"})
"""Detectors whose alarm may have an innocent cause, a gust or a compass: it supports an
alert and never makes one."""


def together(nats: Mapping[str, float]) -> float:
    """What detectors say together, nats by name: the sum, but of SHARED ones the largest."""
    shared = [said for name, said in nats.items() if name in SHARED]
    alone = math.fsum(said for name, said in nats.items() if name not in SHARED)
    return alone + max(shared, default=0.0)


class RecentPeak:
    """The verdict with the largest margin of the last seconds, in O(1) a verdict.

    Attacks pass: an acceleration ends, a jump is over with the next fix.
    """

    def __init__(self, kept_ns: int) -> None:
        """Keep verdicts for this long."""
        self._kept_ns = kept_ns
        self._falling: deque[Verdict] = deque()

    def add(self, verdict: Verdict) -> None:
        """Take a verdict that says something of the GPS."""
        while self._falling and self._falling[-1].margin <= verdict.margin:
            self._falling.pop()
        self._falling.append(verdict)

    def at(self, stamp_ns: int) -> Verdict | None:
        """The largest at a stamp; None if nothing was said within the time."""
        while self._falling and stamp_ns - self._falling[0].stamp_ns > self._kept_ns:
            self._falling.popleft()
        return self._falling[0] if self._falling else None


def odds(probability: float) -> float:
    """Logarithm of the odds of a probability, nats."""
    return math.log(probability / (1.0 - probability))


def probability(log_odds: float) -> float:
    """Probability of a logarithm of odds."""
    if log_odds >= 0.0:
        return 1.0 / (1.0 + math.exp(-log_odds))
    small = math.exp(log_odds)
    return small / (1.0 + small)
