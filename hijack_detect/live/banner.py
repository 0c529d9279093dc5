# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The one word that the page shows largest, and the sentence beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hijack_detect.detectors.verdict import JUDGED, RAISED, State, Verdict
from hijack_detect.monitor.verdict_messages import FusionStatus
from hijack_detect.promise import SILENT_S


@dataclass(frozen=True, slots=True)
class Heard:
    """The newest of all that decides about the banner.

    `silent_s` is the time since hijack_alert on a clock that nobody sets, None before the first;
    `stale` is what the fusion says on /diagnostics while it can say nothing.
    """

    silent_s: float | None
    alert: bool
    fused: FusionStatus | None
    stale: str
    verdicts: Mapping[str, Verdict]


def word(heard: Heard) -> str:
    """One of silent, alarm, suspicious, degraded, not_observable, not_ready, normal."""
    if heard.silent_s is None or heard.silent_s > SILENT_S:
        return "silent"
    return said(heard)


def said(heard: Heard) -> str:
    """What the monitor said last, be it silent since then or not."""
    fused = heard.fused
    if heard.alert or (fused is not None and fused.alert):
        return State.ALARM.value
    if heard.stale:
        return "degraded"
    if fused is None:
        return State.NOT_READY.value
    if fused.state in RAISED:
        return State.SUSPICIOUS.value
    if fused.degraded or fused.state is State.STALE:
        return "degraded"
    return str(fused.state.value)


def sentence(heard: Heard) -> str:
    """Why the monitor says that, in words."""
    what, fused = said(heard), heard.fused
    if what == "degraded" and heard.stale:
        return heard.stale
    if fused is None:
        return "no fusion/verdict was heard yet"
    if what == State.ALARM.value:
        return fused.reason if fused.alert else "hijack_alert is true"
    if what == State.SUSPICIOUS.value:
        raised = [one for one in heard.verdicts.values() if one.state in RAISED]
        return "; ".join(f"{one.detector}: {one.reason}" for one in raised) or fused.reason
    if what == "degraded":
        if not fused.degraded:
            return fused.reason
        return f"without {', '.join(fused.degraded)}: stopped, or never ready"
    if what == State.NOT_OBSERVABLE.value:
        return "no detector can tell in this phase of flight; the table has the reasons"
    if what == State.NOT_READY.value:
        return "the detectors are getting ready; the table has the reasons"
    return _closest(heard.verdicts)


def _closest(verdicts: Mapping[str, Verdict]) -> str:
    judging = {name: one.margin for name, one in verdicts.items() if one.state in JUDGED}
    if not judging:
        return ""
    name = max(judging, key=judging.__getitem__)
    return f"nearest to its limit is {name}, at {judging[name]:.2f} of it"
