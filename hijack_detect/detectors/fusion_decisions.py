# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The policies of the fusion: when do the detectors' verdicts become an alert?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from hijack_detect.detectors.fusion_parameters import FusionParameters
from hijack_detect.detectors.likelihood import (
    UNCALIBRATED,
    RecentPeak,
    Weight,
    odds,
    probability,
    together,
)
from hijack_detect.detectors.verdict import JUDGED, RAISED, State, Verdict
from hijack_detect.streams.samples import NANOSECONDS


class Decision(Protocol):
    """One policy; it hears the verdicts in order of stamp."""

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

    def hear(self, verdict: Verdict) -> None:
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
        self.hear(verdict)
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
        self.hear(verdict)
        if verdict.state is State.ALARM:
            self._claims[verdict.detector] = verdict
        claims = list(self._claims.values())
        return claims if len(claims) == len(self._voters) else ()


class Calibrated:
    """An alert when the odds of all likelihood ratios together are high enough.

    ln odds = ln prior odds + Σ ratios, each of the largest margin of the last `together_s`. Of
    detectors that share a source of error only one counts, and one that cannot tell says nothing.
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
        said = sorted(self._evidence(verdict.stamp_ns), key=lambda one: -one[1])
        return [one for one, _ in said if one.margin >= 1.0]

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
            said = {verdict.detector: nats for verdict, nats in self._evidence(stamp_ns)}
            self._weighed = stamp_ns, probability(self._prior + together(said, self._weights))
        return self._weighed[1]

    def _evidence(self, stamp_ns: int) -> list[tuple[Verdict, float]]:
        """The largest verdict of each detector, and what it says in nats."""
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
