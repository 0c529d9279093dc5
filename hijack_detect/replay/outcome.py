# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a monitor achieved on one flight: alarms before the attack, time to detect."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from hijack_detect.detectors.verdict import State, Verdict


@dataclass(frozen=True)
class Attack:
    """An attack's stamps: onset (first spoofed stamp) and end, nanoseconds."""

    onset_ns: int
    end_ns: int | None


@dataclass(frozen=True)
class DetectorOutcome:
    """What one detector did, stamps in nanoseconds."""

    false_alarms: int
    """Times it went into ALARM before the onset (or at all, without an attack)."""
    first_alarm_ns: int | None
    """First ALARM verdict at or after the onset."""


def detector_outcome(verdicts: Iterable[Verdict], attack: Attack | None) -> DetectorOutcome:
    """Judge one detector's verdicts against the attack."""
    false_alarms, first, before = 0, None, State.NOT_READY
    for verdict in verdicts:
        alarm = verdict.state is State.ALARM
        if attack is None or verdict.stamp_ns < attack.onset_ns:
            false_alarms += alarm and before is not State.ALARM
        elif alarm and first is None:
            first = verdict.stamp_ns
        before = verdict.state
    return DetectorOutcome(false_alarms, first)


def alert_is_right(alert_ns: int | None, attack: Attack | None) -> bool:
    """True if the alert came inside the attack, or stayed away where there was none."""
    if attack is None or alert_ns is None:
        return attack is None and alert_ns is None
    return alert_ns >= attack.onset_ns and (attack.end_ns is None or alert_ns < attack.end_ns)


def changes(verdicts: Sequence[Verdict]) -> list[tuple[int, State]]:
    """Stamp and new state of every change of state, the first verdict included."""
    found: list[tuple[int, State]] = []
    for verdict in verdicts:
        if not found or found[-1][1] is not verdict.state:
            found.append((verdict.stamp_ns, verdict.state))
    return found
