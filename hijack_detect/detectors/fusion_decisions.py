# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The policies of the fusion: when do the detectors' verdicts become an alert?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from hijack_detect.detectors.likelihood import (
    UNCALIBRATED,
    RecentPeak,
    Weight,
    odds,
    probability,
    together,
)
from hijack_detect.detectors.verdict import JUDGED, RAISED, State, Verdict
from hijack_detect.parameters import ParameterError, Parameters, param
from hijack_detect.streams.samples import NANOSECONDS


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
        source="measured: reliability of the probability (docs/detection-limits.md)",
        low=0.5,
        high=0.9999,
    )
    warn_probability: float = param(
        0.9,
        "Policy `default`: SUSPICIOUS from this probability on, whatever single detectors report, "
        "until it is below half of it.",
        source="chosen, not swept",
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


class Decision(Protocol):
    """One policy; it takes the verdicts in order of stamp."""

    def update(self, verdict: Verdict) -> Sequence[Verdict]:
        """Take a verdict; return those that an alert rests on, empty if there is none."""
        ...

    def suspects(self, verdict: Verdict) -> bool:
        """Whether this verdict alone makes the GPS suspicious."""
        ...

    def confidence(self, stamp_ns: int) -> float:
        """Confidence that the GPS is spoofed, 0 to 1."""
        ...


class _Odds:
    """Confidence of the policies that are not calibrated: 0.5 for one margin at its threshold."""

    def __init__(self) -> None:
        self._margins: dict[str, float] = {}

    def take(self, verdict: Verdict) -> None:
        self._margins[verdict.detector] = verdict.margin

    def suspects(self, verdict: Verdict) -> bool:
        """See Decision."""
        return verdict.state in RAISED

    def confidence(self, stamp_ns: int) -> float:
        """See Decision."""
        doubt = 1.0
        for margin in self._margins.values():
            doubt *= 1.0 / (1.0 + margin**2)
        return 1.0 - doubt


class AnyAlarm(_Odds):
    """An alert when any detector alarms."""

    def update(self, verdict: Verdict) -> Sequence[Verdict]:
        """See Decision."""
        self.take(verdict)
        return (verdict,) if verdict.state is State.ALARM else ()


class AllClaims(_Odds):
    """An alert when every voter has claimed a hijack at some time of the flight (Feng 2018, §5)."""

    def __init__(self, voters: Sequence[str]) -> None:
        """Ask these."""
        super().__init__()
        self._voters = voters
        self._claims: dict[str, Verdict] = {}

    def update(self, verdict: Verdict) -> Sequence[Verdict]:
        """See Decision."""
        if verdict.detector not in self._voters:
            return ()
        self.take(verdict)
        if verdict.state is State.ALARM:
            self._claims[verdict.detector] = verdict
        claims = list(self._claims.values())
        return claims if len(claims) == len(self._voters) else ()


class Calibrated:
    """An alert when the odds of all likelihood ratios together are high enough.

    ln odds = ln prior odds + Σ ratios, each of the largest margin of the last `together_s`. Of
    detectors that share a source of error only one counts, and one that cannot tell does not.
    They have to be for `debounce_s`, and an alert needs an ALARM within `together_s` too, of a
    detector that may make one.
    """

    def __init__(self, parameters: FusionParameters, weights: Mapping[str, Weight]) -> None:
        """Start without evidence."""
        self._parameters = p = parameters
        self._weights = weights
        self._kept_ns = round(p.together_s * NANOSECONDS)
        self._debounce_ns = round(p.debounce_s * NANOSECONDS)
        self._prior = odds(p.prior)
        self._peaks: dict[str, RecentPeak] = {}
        self._alarmed_ns: int | None = None
        self._since_ns: int | None = None
        self._weighed: tuple[int, float] | None = None
        """Stamp and probability since the last verdict."""

    def update(self, verdict: Verdict) -> Sequence[Verdict]:
        """See Decision."""
        self._weighed = None
        if verdict.state in JUDGED and self._weight(verdict.detector).ratio is not None:
            peak = self._peaks.setdefault(verdict.detector, RecentPeak(self._kept_ns))
            peak.add(verdict)
        if verdict.state is State.ALARM and self._weight(verdict.detector).may_alert:
            self._alarmed_ns = verdict.stamp_ns
        if self.confidence(verdict.stamp_ns) < self._parameters.alarm_probability:
            self._since_ns = None
            return ()
        if self._since_ns is None:
            self._since_ns = verdict.stamp_ns
        lasts = verdict.stamp_ns - self._since_ns >= self._debounce_ns
        if not (lasts and self._alarmed(verdict.stamp_ns)):
            return ()
        evidence = sorted(self._evidence(verdict.stamp_ns), key=lambda one: -one[1])
        return [one for one, _ in evidence if one.margin >= 1.0]

    def suspects(self, verdict: Verdict) -> bool:
        """See Decision: if its alarm alone would make an attack more probable than not."""
        ratio = self._weight(verdict.detector).ratio
        return ratio is not None and verdict.state in RAISED and self._prior + ratio.high >= 0.0

    def _alarmed(self, stamp_ns: int) -> bool:
        """Whether there is an alarm that may make an alert."""
        alarmed = self._alarmed_ns
        return alarmed is not None and stamp_ns - alarmed <= self._kept_ns

    def confidence(self, stamp_ns: int) -> float:
        """See Decision: the probability."""
        if self._weighed is None or self._weighed[0] != stamp_ns:
            nats_of = {verdict.detector: nats for verdict, nats in self._evidence(stamp_ns)}
            self._weighed = stamp_ns, probability(self._prior + together(nats_of, self._weights))
        return self._weighed[1]

    def _evidence(self, stamp_ns: int) -> list[tuple[Verdict, float]]:
        """The largest verdict of each detector, and its evidence in nats."""
        found = [
            (peak.at(stamp_ns), self._weight(name).ratio) for name, peak in self._peaks.items()
        ]
        return [
            (verdict, ratio(verdict.margin))
            for verdict, ratio in found
            if verdict is not None and ratio is not None
        ]

    def _weight(self, name: str) -> Weight:
        return self._weights.get(name, UNCALIBRATED)


def decision(parameters: FusionParameters, weights: Mapping[str, Weight]) -> Decision:
    """The policy that the parameters name."""
    if parameters.policy == "paper":
        return AllClaims([name for name, one in weights.items() if one.published])
    if parameters.policy == "any":
        return AnyAlarm()
    return Calibrated(parameters, weights)
