"""Fuses the detectors' verdicts into one alert."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.samples import NANOSECONDS

SUPPORTING = frozenset({"correlation"})
"""Detectors whose alarm alone is no proof: what they see has innocent causes."""
PUBLISHED = ("correlation", "date")
"""The detectors that policy `paper` asks: those of Feng 2018."""
KEEPING = frozenset({"kld"})
"""Detectors that keep their alarm until they are reset themselves."""


@dataclass(frozen=True)
class FusionParameters(Parameters):
    """Parameters of the fusion."""

    policy: str = param(
        "default",
        "`paper`: alert when correlation and DATE have both claimed a hijack (§5: 'when the "
        "results of all the methods are hijacked'); claims are kept for the flight. Use it with "
        "the faithful detectors. `any`: alert when any detector alarms. `default`: alert when "
        "DATE or KLD alarms, or when the correlation alarms and one of them comes close to it.",
        choices=("paper", "any", "default"),
    )
    together_s: float = param(
        5.0,
        "Policy `default`: the correlation's alarm and another margin this close together count "
        "as one event.",
        unit="s",
        low=0.0,
        high=600.0,
    )
    together_margin: float = param(
        0.8,
        "Policy `default`: with an alarm of the correlation this margin of DATE or KLD alerts. "
        "The correlation alone never does: a pilot who begins to fly sideways looks the same.",
        low=0.1,
        high=1.0,
    )
    patience_s: float = param(
        5.0,
        "How long to wait for a detector that has gone silent, on the stamps of the others: an "
        "alert comes this much later when a detector has just died. For replays faster than real "
        "time far larger.",
        unit="s",
        low=1.0,
        high=3600.0,
    )
    stale_s: float = param(
        3.0,
        "A detector whose newest verdict is this much older than the newest of all is STALE.",
        unit="s",
        low=0.1,
        high=600.0,
    )


@dataclass(frozen=True, slots=True)
class FusionResult:
    """What the monitor claims at one header stamp.

    `state` is the worst claim that can be made; it is NORMAL only if no expected detector is
    missing or stale and at least one can tell. `alert` is latched until `reset`. `confidence`
    is in [0, 1]: 0.5 for one detector at its threshold; it is not a calibrated probability.
    """

    stamp_ns: int
    state: State
    alert: bool
    alert_since_ns: int | None
    confidence: float
    reason: str
    detectors: Mapping[str, Verdict]
    lost: tuple[str, ...]
    causes: tuple[str, ...] = ()
    """Detectors that led to the alert."""


class Fusion:
    """Keeps every detector's last verdict and decides on header stamps."""

    NAME = "fusion"

    def __init__(self, parameters: FusionParameters, detectors: Sequence[str]) -> None:
        """Expect verdicts of the named detectors."""
        self._parameters = parameters
        self.inputs = dict.fromkeys(detectors, parameters.patience_s)
        self._together_ns = round(parameters.together_s * NANOSECONDS)
        self._stale_ns = round(parameters.stale_s * NANOSECONDS)
        paper = parameters.policy == "paper"
        self._voters = tuple(name for name in detectors if not paper or name in PUBLISHED)
        self._last: dict[str, Verdict] = {}
        self._first_ns: int | None = None
        self.reset()

    def reset(self) -> None:
        """Take the alert back and forget what led to it (service `~/reset`).

        A detector that keeps its alarm is heard again once it has taken the alarm back.
        """
        self._heard_out = {
            name
            for name, last in self._last.items()
            if name in KEEPING and last.state is State.ALARM
        }
        self._alarmed: dict[str, Verdict] = {}
        self._close: dict[str, Verdict] = {}
        self._alert_since_ns: int | None = None
        self._cause = ""
        self._causes: tuple[str, ...] = ()

    def inherit(self, before: Fusion) -> None:
        """Keep the alert of the fusion before: a clock that is set back takes no alert back."""
        self._alert_since_ns, self._heard_out = before._alert_since_ns, before._heard_out
        self._cause, self._causes = before._cause, before._causes

    def update(self, name: str, verdict: Verdict) -> FusionResult:
        """Take the next verdict in order of stamp."""
        self._last[name] = verdict
        if self._first_ns is None:
            self._first_ns = verdict.stamp_ns
        if verdict.state is not State.ALARM:
            self._heard_out.discard(name)
        if name not in self._voters or name in self._heard_out:
            return self._result(verdict.stamp_ns)
        if verdict.state is State.ALARM:
            self._alarmed[name] = verdict
        elif name not in SUPPORTING and verdict.margin >= self._parameters.together_margin:
            self._close[name] = verdict
        causes = self._decide(verdict)
        if causes and self._alert_since_ns is None:
            self._alert_since_ns, self._cause = verdict.stamp_ns, _told(causes)
            self._causes = tuple(dict.fromkeys(v.detector for v in causes))
        return self._result(verdict.stamp_ns)

    def _decide(self, verdict: Verdict) -> Sequence[Verdict]:
        """What the policy alerts on at this verdict, empty if it does not."""
        alarm = verdict.state is State.ALARM
        policy = self._parameters.policy
        if policy == "paper":
            claims = list(self._alarmed.values())
            return claims if len(claims) == len(self._voters) else ()
        if alarm and (policy == "any" or verdict.detector not in SUPPORTING):
            return (verdict,)
        if policy == "any":
            return ()
        near = [
            v
            for v in (*self._alarmed.values(), *self._close.values())
            if verdict.stamp_ns - v.stamp_ns <= self._together_ns
        ]
        supported = {v.detector in SUPPORTING for v in near} == {True, False}
        return near if supported else ()

    def _result(self, stamp_ns: int) -> FusionResult:
        verdicts = {name: self._seen(name, stamp_ns) for name in self.inputs}
        assert self._first_ns is not None
        late = stamp_ns - self._first_ns > self._stale_ns
        lost = tuple(
            name for name, v in verdicts.items() if (late if v is None else v.state is State.STALE)
        )
        known = {name: v for name, v in verdicts.items() if v is not None}
        state = self._state(known, lost)
        return FusionResult(
            stamp_ns,
            state,
            self._alert_since_ns is not None,
            self._alert_since_ns,
            self._confidence(known),
            self._cause or _told(list(known.values())),
            known,
            lost,
            self._causes,
        )

    def _seen(self, name: str, stamp_ns: int) -> Verdict | None:
        """A detector's last verdict, as STALE if it is too old."""
        verdict = self._last.get(name)
        if verdict is None or stamp_ns - verdict.stamp_ns <= self._stale_ns:
            return verdict
        age = (stamp_ns - verdict.stamp_ns) / NANOSECONDS
        return Verdict(
            name, verdict.stamp_ns, State.STALE, 0.0, verdict.threshold, f"silent for {age:.1f} s"
        )

    def _state(self, known: Mapping[str, Verdict], lost: Sequence[str]) -> State:
        states = [verdict.state for verdict in known.values()]
        if self._alert_since_ns is not None:
            return State.ALARM
        if State.ALARM in states or State.SUSPICIOUS in states:
            return State.SUSPICIOUS
        if lost:
            return State.STALE
        if len(known) < len(self.inputs):
            return State.NOT_READY
        for state in (State.NORMAL, State.NOT_OBSERVABLE):
            if state in states:
                return state
        return State.NOT_READY

    def _confidence(self, known: Mapping[str, Verdict]) -> float:
        if self._alert_since_ns is not None:
            return 1.0
        doubt = 1.0
        for name, verdict in known.items():
            if name in self._voters:
                doubt *= 1.0 / (1.0 + verdict.margin**2)
        return 1.0 - doubt


def _told(verdicts: Sequence[Verdict]) -> str:
    """Verdicts in words: detector, state, margin, reason."""
    return "; ".join(
        f"{v.detector} {v.state.value} margin {v.margin:.2f} ({v.reason})" for v in verdicts
    )
