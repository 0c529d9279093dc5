# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Fuses the detectors' verdicts into one alert; `Decision` decides when."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from hijack_detect.detectors.likelihood import (
    UNCALIBRATED,
    FusionParameters,
    RecentPeak,
    Weight,
    odds,
    probability,
    together,
)
from hijack_detect.detectors.verdict import JUDGED, RAISED, State, Verdict
from hijack_detect.estimation.lag_ekf import LATE, late_words
from hijack_detect.estimation.receiver_health import POOR, poor_words
from hijack_detect.streams.samples import NANOSECONDS

SILENT_S = 2.0
"""All inputs have stopped when no detector publishes for this long: one with a lost input does so
every second, after 1.5 s (see `input_watch`)."""


@dataclass(frozen=True, slots=True)
class Latched:
    """An alert that is kept: stamp (ns), what led to it, in words and by name, and confidence."""

    since_ns: int
    cause: str
    causes: tuple[str, ...]
    confidence: float


@dataclass(frozen=True, slots=True)
class FusionResult:
    """What the monitor claims at one header stamp.

    `state` is the worst claim that can be made; it is NORMAL only if no expected detector is
    missing, stale or overdue, and at least one can tell that could see a carry-off. After all
    inputs had stopped it is STALE until then. `alert` is latched until `reset`.
    `confidence` is in [0, 1]: the probability of an attack with policy `default`, and the largest
    that there was of an alert; with the others 0.5 for one detector at its threshold, 1 for an
    alert.
    """

    stamp_ns: int
    state: State
    alert: bool
    alert_since_ns: int | None
    confidence: float
    cause: str
    """What led to the alert, in words; empty without one."""
    detectors: Mapping[str, Verdict]
    lost: tuple[str, ...]
    """Detectors that are missing or stale."""
    causes: tuple[str, ...] = ()
    """Detectors that led to the alert."""
    overdue: tuple[str, ...] = ()
    """Detectors that have been getting ready for far too long."""
    silent_s: float | None = None
    """Seconds for which nothing has come, by the clock, where nothing else is known."""
    advisory: frozenset[str] = field(default=frozenset(), repr=False)
    """Detectors whose silence takes nothing from the monitor."""

    @property
    def degraded(self) -> tuple[str, ...]:
        """Detectors that the monitor has to do without, though it should not."""
        return self.lost + self.overdue

    @property
    def claim(self) -> float:
        """The value of `hijack_confidence`: NaN where nothing is known of the GPS.

        What is left of the confidence would read as if all were well; NaN is smaller than no limit,
        and larger than none.
        """
        return self.confidence if self.alert or self.state in JUDGED else math.nan

    def silent(self, seconds: float) -> FusionResult:
        """What remains of this when no detector has published for this long since.

        An alert stays, and none comes. The stamp stays too: nothing is known of any later one.
        """
        verdicts = {name: _silent(verdict, seconds) for name, verdict in self.detectors.items()}
        return replace(
            self,
            state=State.ALARM if self.alert else State.STALE,
            confidence=self.confidence if self.alert else math.nan,
            detectors=verdicts,
            lost=tuple(name for name in verdicts if name not in self.advisory),
            overdue=(),
            silent_s=seconds,
        )

    @property
    def reason(self) -> str:
        """What led to the alert, or the state of every detector, missing ones first."""
        if self.cause:
            return self.cause
        states = _states(list(self.detectors.values()))
        if self.state is State.STALE and not self.degraded:
            return f"all inputs had stopped, and nobody can tell again yet: {states}"
        return (
            f"DEGRADED, without {', '.join(self.degraded)}: {states}" if self.degraded else states
        )


class Fusion:
    """Keeps every detector's last verdict and decides on header stamps."""

    NAME = "fusion"

    PARAMETERS = FusionParameters

    def __init__(self, parameters: FusionParameters, weights: Mapping[str, Weight]) -> None:
        """Expect verdicts of the detectors that have a weight, by name."""
        self._parameters, self._weights = parameters, weights
        self.inputs = dict.fromkeys(weights, parameters.patience_s)
        self._advisory = frozenset(name for name, one in weights.items() if one.ratio is None)
        self._carry_off = frozenset(name for name, one in weights.items() if one.sees_carry_off)
        self._stale_ns = round(parameters.stale_s * NANOSECONDS)
        self._overdue_ns = round(parameters.overdue_s * NANOSECONDS)
        self._calibrated = parameters.policy == "default"
        self._last: dict[str, Verdict] = {}
        self._first_ns: int | None = None
        self._newest_ns = self._resumed_ns = 0
        """Stamps of the newest verdict, and of the first one after all inputs had stopped."""
        self._resuming = False
        """Whether nobody has been able to tell since then."""
        self._unready_since_ns: dict[str, int] = {}
        self.reset()

    def reset(self) -> None:
        """Take the alert back and forget what led to it (service `~/reset`).

        A detector that keeps its alarm counts again once it has taken the alarm back.
        """
        self._reset_alarms = {
            name
            for name, last in self._last.items()
            if self._weights[name].keeps_alarm and last.state is State.ALARM
        }
        self._decision = decision(self._parameters, self._weights)
        self._warned = False
        self._alert_since_ns: int | None = None
        self._confidence = 0.0
        self._cause = ""
        self._causes: tuple[str, ...] = ()

    @property
    def latched(self) -> Latched | None:
        """The alert that is kept, if there is one."""
        if self._alert_since_ns is None:
            return None
        return Latched(self._alert_since_ns, self._cause, self._causes, self._confidence)

    def keep(self, alert: Latched) -> None:
        """Go on with an alert of before this fusion was made."""
        self._alert_since_ns, self._confidence = alert.since_ns, alert.confidence
        self._cause, self._causes = alert.cause, alert.causes

    def inherit(self, before: Fusion) -> None:
        """Keep the alert of the fusion before: a clock that is set back takes no alert back."""
        self._reset_alarms = before._reset_alarms
        if before.latched is not None:
            self.keep(before.latched)

    def update(self, name: str, verdict: Verdict) -> FusionResult:
        """Take the next verdict in order of stamp."""
        self._last[name] = verdict
        if verdict.state is not State.NOT_READY:
            self._unready_since_ns.pop(name, None)
        else:
            self._unready_since_ns.setdefault(name, verdict.stamp_ns)
        if self._first_ns is None:
            self._first_ns = verdict.stamp_ns
        elif verdict.stamp_ns - self._newest_ns > SILENT_S * NANOSECONDS:
            self._resumed_ns, self._resuming = verdict.stamp_ns, True
        self._newest_ns = verdict.stamp_ns
        if verdict.state is not State.ALARM:
            self._reset_alarms.discard(name)
        if name not in self._reset_alarms:
            causes = self._decision.update(verdict)
            if causes and self._alert_since_ns is None:
                self._alert_since_ns = verdict.stamp_ns
                self._cause = self._doubted(_causes(causes), verdict.stamp_ns)
                self._causes = tuple(dict.fromkeys(v.detector for v in causes))
        self._judge(verdict.stamp_ns)
        return self._result(verdict.stamp_ns)

    def _doubted(self, causes: str, stamp_ns: int) -> str:
        """Causes, with what speaks for a fault instead of an attack: a poor or late receiver."""
        seen = [self._seen(name, stamp_ns) for name in self.inputs]
        values = [one.values for one in seen if one is not None]
        doubts = {
            what: next(filter(None, map(words, values)), "")
            for what, words in ((POOR, poor_words), (LATE, late_words))
        }
        if not any(doubts.values()):
            return causes
        named = (f"; {what} ({why})" for what, why in doubts.items() if why and what not in causes)
        return f"{causes}{''.join(named)}: this can be a fault of the receiver"

    def _judge(self, stamp_ns: int) -> None:
        """Set confidence, and whether it is high enough for a warning."""
        now = self._decision.confidence(stamp_ns)
        if self._alert_since_ns is None:
            self._confidence = now
        else:
            self._confidence = max(now, self._confidence) if self._calibrated else 1.0
        limit = self._parameters.warn_probability * (0.5 if self._warned else 1.0)
        self._warned = self._calibrated and now >= limit

    def _result(self, stamp_ns: int) -> FusionResult:
        verdicts = {name: self._seen(name, stamp_ns) for name in self.inputs}
        assert self._first_ns is not None
        late = stamp_ns - self._first_ns > self._stale_ns
        lost = tuple(
            name
            for name, v in verdicts.items()
            if name not in self._advisory and (late if v is None else v.state is State.STALE)
        )
        excused = self._advisory.union(lost)
        overdue = tuple(
            name
            for name, since_ns in self._unready_since_ns.items()
            if name not in excused and stamp_ns - since_ns > self._overdue_ns
        )
        known = {name: v for name, v in verdicts.items() if v is not None}
        state = self._state(known, lost, overdue)
        return FusionResult(
            stamp_ns,
            state,
            self._alert_since_ns is not None,
            self._alert_since_ns,
            self._confidence,
            self._cause,
            known,
            lost,
            self._causes,
            overdue,
            advisory=self._advisory,
        )

    def _seen(self, name: str, stamp_ns: int) -> Verdict | None:
        """A detector's last verdict, as STALE if it is too old, or of before all inputs stopped."""
        verdict = self._last.get(name)
        if verdict is None:
            return None
        age_ns = stamp_ns - verdict.stamp_ns
        if age_ns <= self._stale_ns and verdict.stamp_ns >= self._resumed_ns:
            return verdict
        return _silent(verdict, age_ns / NANOSECONDS)

    def _state(
        self, known: Mapping[str, Verdict], lost: Sequence[str], overdue: Sequence[str]
    ) -> State:
        if self._alert_since_ns is not None:
            return State.ALARM
        if self._warned or any(self._decision.suspects(one) for one in known.values()):
            return State.SUSPICIOUS
        if lost:
            return State.STALE
        if overdue or any(name not in known for name in self.inputs if name not in self._advisory):
            return State.NOT_READY
        watching = self._carry_off.intersection(known) or known.keys()
        states = {known[name].state for name in watching}
        if states & JUDGED:
            self._resuming = False
            return State.NORMAL
        if states == {State.NOT_OBSERVABLE}:
            self._resuming = False
        if self._resuming:
            return State.STALE
        return State.NOT_OBSERVABLE if State.NOT_OBSERVABLE in states else State.NOT_READY


def _silent(last: Verdict, seconds: float) -> Verdict:
    """The state of a detector that publishes nothing."""
    reason = f"silent for {seconds:.1f} s"
    return Verdict(last.detector, last.stamp_ns, State.STALE, 0.0, last.threshold, reason)


def _states(verdicts: Sequence[Verdict]) -> str:
    """Verdicts in words: detector, state, part of its limit, reason."""
    return "; ".join(
        f"{v.detector}: {v.state.value}, {100.0 * v.margin:.0f} % of its limit ({v.reason})"
        if v.state in JUDGED
        else f"{v.detector}: {v.state.value} ({v.reason})"
        for v in verdicts
    )


def _causes(verdicts: Sequence[Verdict]) -> str:
    """What happened, in the words of the detectors that are over their limits, strongest first."""
    return "; ".join(f"{v.reason} [{v.detector}, {v.margin:.1f} × its limit]" for v in verdicts)


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
