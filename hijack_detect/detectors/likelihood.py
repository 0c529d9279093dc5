# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How the fusion weighs a margin: its likelihood ratio, attacked against clean, and parameters."""

from __future__ import annotations

import math
from collections import defaultdict, deque
from collections.abc import Mapping
from dataclasses import astuple, dataclass, fields

from hijack_detect.detectors.verdict import Verdict
from hijack_detect.parameters import ParameterError, Parameters, param

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
"""Of a detector of which nothing is known: its alarm supports an alert and never makes one.
Chosen, not swept."""


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


@dataclass(frozen=True)
class FusionParameters(Parameters):
    """Parameters of the fusion."""

    policy: str = param(
        "default",
        "`paper`: alert when correlation and DATE have both claimed a hijack (§5: 'when the "
        "results of all the methods are hijacked'); claims are kept for the flight. Use it with "
        "the faithful detectors. `any`: alert when any detector alarms. `default`: alert when the "
        "likelihood ratios of all detectors together make an attack probable enough.",
        source="Feng 2018, §5, for `paper`",
        basic=True,
        choices=("paper", "any", "default"),
    )
    further_detectors: str = param(
        "",
        "Detectors of your own to subscribe to: names with spaces between them, each of which "
        "publishes NAME/verdict. One that is missing makes the monitor degraded. With policy "
        "`default` they support an alert and never give one, unless `further_weights` allows it; "
        "with `any` their alarm is an alert; `paper` does not ask them.",
        source="docs/own-detector.md",
        basic=True,
    )
    further_weights: str = param(
        "",
        "Policy `default`: what detectors of your own count for, NAME=SLOPE,NEUTRAL,LOW,HIGH with "
        "spaces between them: the likelihood ratio SLOPE · ln(margin / NEUTRAL), from LOW to HIGH "
        "nats, and their alarm makes an alert. Words can follow, with commas: `supports`, the "
        "alarm alone makes none; `carry_off`, it could see a carry-off; `keeps_alarm`, until it is "
        "reset itself; `velocity` or `height` of the receiver, a source of error of others too, of "
        "which only one counts. `advisory` instead of numbers: it is only shown.",
        source="docs/own-detector.md",
    )
    prior: float = param(
        0.1,
        "Policy `default`: probability of an attack before the first verdict. Only the ratio of "
        "this to `alarm_probability` decides.",
        source="chosen, not swept: only its ratio to alarm_probability decides",
        low=1e-6,
        high=0.5,
    )
    alarm_probability: float = param(
        0.65,
        "Policy `default`: ALARM from this probability on, if a detector alarms. Lower it where a "
        "missed attack costs more than a false alarm.",
        source="chosen, not swept: takes 3.5 nats beside quiet detectors, and one that may "
        "alert gives at least 4.3 at its limit (docs/detection-limits.md, Ratios of "
        "the fusion)",
        low=0.5,
        high=0.9999,
    )
    warn_probability: float = param(
        0.9,
        "Policy `default`: SUSPICIOUS from this probability on, whatever single detectors report, "
        "until it is below half of it.",
        source="chosen; with 0.3 a lone alarm of correlation made clean flights suspicious",
        low=0.01,
        high=0.9999,
    )
    together_s: float = param(
        5.0,
        "Policy `default`: margins this close together count as one event; a margin speaks for "
        "this long.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=600.0,
    )
    debounce_s: float = param(
        0.2,
        "Policy `default`: the probability must be high for this long.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=60.0,
    )
    patience_s: float = param(
        5.0,
        "How long to wait for a detector that has gone silent, on the stamps of the others: an "
        "alert comes this much later when a detector has just died. For replays faster than real "
        "time far larger.",
        source="chosen: longer than a sensor is waited for (3 s), and its skew",
        unit="s",
        low=1.0,
        high=3600.0,
    )
    stale_s: float = param(
        3.0,
        "A detector whose newest verdict is this much older than the newest of all is STALE.",
        source="chosen: what a sensor is waited for",
        unit="s",
        low=0.1,
        high=600.0,
    )
    overdue_s: float = param(
        120.0,
        "A detector that has been NOT_READY for this long is overdue, and the monitor degraded. On "
        "the ground, where no heading can be known, that is true as well.",
        source="chosen, not swept",
        unit="s",
        low=1.0,
        high=36000.0,
    )
    survive_s: float = param(
        20.0,
        "An alert outlives the node when it is started again within this time, as launch does "
        "after a crash; not when the node was asked to end. 0 lets none survive.",
        source="chosen: longer than launch takes to start a node again",
        basic=True,
        unit="s",
        low=0.0,
        high=3600.0,
    )

    def __post_init__(self) -> None:
        """See Parameters; names of detectors must be part of a topic's name."""
        super().__post_init__()
        names = self.further_detectors.split()
        for name in names:
            if not name.isidentifier() or names.count(name) > 1:
                raise ParameterError(
                    "parameter 'further_detectors' must be different names of letters, digits and "
                    f"underscores with spaces between them, got '{name}'"
                )
        for one in self.further_weights.split():
            name, _, text = one.partition("=")
            try:
                Weight.from_text(text)
            except (TypeError, ValueError) as error:
                raise ParameterError(f"parameter 'further_weights', '{one}': {error}") from error
            if name not in names:
                raise ParameterError(
                    f"parameter 'further_weights' has '{name}', which 'further_detectors' has not"
                )

    @property
    def further(self) -> Mapping[str, Weight]:
        """The detectors in `further_detectors`, and what they count for."""
        given = dict(one.split("=", 1) for one in self.further_weights.split())
        return {
            name: Weight.from_text(given[name]) if name in given else UNCALIBRATED
            for name in self.further_detectors.split()
        }
