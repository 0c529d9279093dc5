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
    "drag": LikelihoodRatio(10.39, 0.77, -0.1, 2.7),
}
"""By detector, fitted on half of the recorded flights. Ratios fitted with each vehicle left out
(experiments/fusion_calibration.py) change no alert and have the same Brier score: these stay."""

CARRY_OFF = frozenset({"coast", "date", "drag"})
"""Detectors that could see a carry-off: only they count where a flight is said to be watched."""

ADVISORY = frozenset({"heading"})
"""Detectors that nobody could calibrate: shown, but neither their alarm nor their silence changes
what the monitor claims. No recorded flight with an attack and a compass moves `heading`."""

SHARED = (frozenset({"coast", "date", "drag"}), frozenset({"altitude", "kld"}))
"""Detectors that share a source of error, so the one that says most counts for all of its group:
velocity of the receiver and attitude; height of the receiver."""

SOFT = frozenset({"drag", "correlation"})
"""Detectors whose alarm may have an innocent cause, a gust or a vehicle that flies sideways: it
supports an alert and never makes one. On clean recorded flights `correlation` reaches 2.9."""


def together(nats: Mapping[str, float]) -> float:
    """What detectors say together, nats by name: the sum, but of each SHARED group the largest."""
    groups = [[said for name, said in nats.items() if name in group] for group in SHARED]
    alone = math.fsum(
        said for name, said in nats.items() if not any(name in group for group in SHARED)
    )
    return alone + math.fsum(max(group, default=0.0) for group in groups)


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
