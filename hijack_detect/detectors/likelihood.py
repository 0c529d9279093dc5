# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From the margin of a detector to a likelihood ratio: attacked against clean."""

from __future__ import annotations

import math
from collections import defaultdict, deque
from collections.abc import Mapping
from dataclasses import astuple, dataclass, fields

from hijack_detect.detectors.verdict import Verdict

SMALLEST_MARGIN = 0.01
"""Keeps the logarithm finite; far below the margin where any ratio has its floor."""


@dataclass(frozen=True)
class LikelihoodRatio:
    """ln p(margin | attacked) / p(margin | clean), a logistic law of the margin's logarithm.

    Attributes:
        slope: Nats for each factor e of the margin.
        neutral: Margin without evidence.
        low: Smallest evidence, nats: how much a quiet detector speaks for the GPS.
        high: Largest evidence, nats: how rare such a margin can be claimed to be from
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


ADVISORY, SEES, SUPPORTS, KEEPS = "advisory", "carry_off", "supports", "keeps_alarm"
"""Words of a weight's text."""
SOURCES_OF_ERROR = ("velocity", "height")
"""What detectors can share: velocity of the receiver and attitude; height of the receiver."""


@dataclass(frozen=True)
class Weight:
    """What the verdicts of a detector count for.

    Attributes:
        ratio: None if nobody could calibrate it: it is shown, and neither its alarm nor its silence
            changes what the monitor claims.
        shares: One of SOURCES_OF_ERROR, empty for none. Of the detectors that share one only that
            which has most evidence counts.
        may_alert: With policy `default` its alarm makes an alert; otherwise it has innocent causes
            and only supports one.
        sees_carry_off: It could see a carry-off: only these count where a flight is called
            watched.
        keeps_alarm: It keeps its alarm until it is reset itself.
        published: Policy `paper` asks it.
    """

    ratio: LikelihoodRatio | None
    shares: str = ""
    may_alert: bool = True
    sees_carry_off: bool = False
    keeps_alarm: bool = False
    published: bool = False

    @property
    def text(self) -> str:
        """It as the parameter `further_weights` has it; see `from_text`."""
        ratio = None if self.ratio is None else astuple(self.ratio)
        numbers = [ADVISORY] if ratio is None else [repr(float(one)) for one in ratio]
        flags = ((self.sees_carry_off, SEES), (not self.may_alert, SUPPORTS),
                 (self.keeps_alarm, KEEPS), (self.shares, self.shares))  # fmt: skip
        return ",".join([*numbers, *(word for given, word in flags if given)])

    @classmethod
    def from_text(cls, text: str) -> Weight:
        """Read `SLOPE,NEUTRAL,LOW,HIGH` or `advisory`, and words, all with commas in between.

        Words are `carry_off` (see `sees_carry_off`), `supports` (not `may_alert`), `keeps_alarm`
        and those of SOURCES_OF_ERROR.

        Raises:
            ValueError: It is something else, or such a ratio would not grow with the margin.
        """
        first, *words = text.split(",")
        ratio = None
        if first != ADVISORY:
            numbers, words = [float(one) for one in (first, *words[:3])], words[3:]
            if len(numbers) < len(fields(LikelihoodRatio)) or not all(map(math.isfinite, numbers)):
                raise ValueError("it takes four numbers: SLOPE,NEUTRAL,LOW,HIGH")
            ratio = LikelihoodRatio(*numbers)
            if min(ratio.slope, ratio.neutral) <= 0.0 or not ratio.low <= 0.0 <= ratio.high:
                raise ValueError("SLOPE and NEUTRAL must be above 0, and 0 from LOW to HIGH")
        shared = [word for word in words if word in SOURCES_OF_ERROR]
        if unknown := {*words} - {SEES, SUPPORTS, KEEPS, *shared[:1]}:
            raise ValueError(f"what is '{min(unknown)}'?")
        alerts = ratio is not None and SUPPORTS not in words
        return cls(ratio, "".join(shared), alerts, SEES in words, KEEPS in words)


UNCALIBRATED = Weight(LikelihoodRatio(3.0, 0.7, -0.2, 3.0), may_alert=False)
"""Of a detector of which nothing is known: its alarm supports an alert and never makes one."""


def together(nats: Mapping[str, float], weights: Mapping[str, Weight]) -> float:
    """Evidence of detectors together, nats by name: the sum of the largest by source of error."""
    groups: dict[str, list[float]] = defaultdict(list)
    for name, one in nats.items():
        groups[weights.get(name, UNCALIBRATED).shares].append(one)
    return math.fsum(groups.pop("", ())) + math.fsum(map(max, groups.values()))


class RecentPeak:
    """The verdict with the largest margin of the last seconds, in O(1) a verdict.

    Attacks pass: an acceleration ends, a jump is over with the next fix.
    """

    def __init__(self, kept_ns: int) -> None:
        """Keep verdicts for this long."""
        self._kept_ns = kept_ns
        self._falling: deque[Verdict] = deque()

    def add(self, verdict: Verdict) -> None:
        """Take a verdict that judges the GPS."""
        while self._falling and self._falling[-1].margin <= verdict.margin:
            self._falling.pop()
        self._falling.append(verdict)

    def at(self, stamp_ns: int) -> Verdict | None:
        """The largest at a stamp; None if there was none within the time."""
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
