# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Outcome of a gate: when it rejected, for how long, how far the report was off by then."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

from experiments.autopilot_gates.gate_filter import Judged
from hijack_detect.streams.samples import NANOSECONDS

LASTING_S = 1.0
"""Rejections in a row that are reported to a user: ArduCopter's EKF check, EKF_CHECK_ITERATIONS_MAX
(ArduCopter/ekf_check.cpp), though it asks more: position and velocity, not one of them."""


@dataclass(frozen=True)
class Alarm:
    """When a gate first rejected.

    Attributes:
        after_s: Seconds after the onset.
        off_m: Metres between true and reported position then.
        by: The measurements that were rejected.
    """

    after_s: float
    off_m: float
    by: list[str]


@dataclass(frozen=True)
class Outcome:
    """One attack under one gate.

    Attributes:
        flight: The flight.
        attack: Name of the attack.
        autopilot: Whose gate.
        onset_s: Seconds after the flight's first message.
        first: The first rejection before any reset, None if there was none.
        lasting: The end of the first LASTING_S of rejections in a row before any reset.
        worst_before: Largest test ratio before the onset, once settled.
        worst_after: Largest test ratio during the attack.
        resets_s: Seconds after the onset of every reset onto the GPS or the barometer.
    """

    flight: str
    attack: str
    autopilot: str
    onset_s: float
    first: Alarm | None
    lasting: Alarm | None
    worst_before: float
    worst_after: float
    resets_s: list[float]


@dataclass(frozen=True)
class Clean:
    """A flight without attack, or the part before one, under one gate.

    Attributes:
        flight: The flight.
        autopilot: Whose gate.
        hours: Time that was judged.
        rejections: Runs of rejected epochs.
        lasting: Those of at least LASTING_S.
        resets: Resets after a time-out.
        worst: Largest test ratio.
    """

    flight: str
    autopilot: str
    hours: float
    rejections: int
    lasting: int
    resets: int
    worst: float


def runs(judged: Sequence[Judged]) -> list[list[Judged]]:
    """The runs of consecutive epochs in which something was rejected."""
    found: list[list[Judged]] = []
    before = False
    for one in judged:
        if one.rejected:
            if not before:
                found.append([])
            found[-1].append(one)
        before = bool(one.rejected)
    return found


def lasting_end(run: Sequence[Judged]) -> Judged | None:
    """The epoch at which a run has lasted LASTING_S, None if it did not."""
    needed = run[0].stamp_ns + round(LASTING_S * NANOSECONDS)
    return next((one for one in run if one.stamp_ns >= needed), None)


def alarms(
    judged: Sequence[Judged], offsets_m: Sequence[float], onset_ns: int
) -> tuple[Alarm | None, Alarm | None]:
    """The first and the lasting rejection of an attack, before any reset.

    Args:
        judged: Every epoch of the attack from the onset on.
        offsets_m: Metres between true and reported position at each.
        onset_ns: Stamp of the onset.
    """
    reset = next((k for k, one in enumerate(judged) if one.resets), len(judged))
    off = {one.stamp_ns: offset for one, offset in zip(judged, offsets_m, strict=True)}
    found = runs(judged[:reset])

    def alarm(one: Judged | None, by: Judged) -> Alarm | None:
        if one is None:
            return None
        after = (one.stamp_ns - onset_ns) / NANOSECONDS
        return Alarm(round(after, 2), round(off[one.stamp_ns], 1), by.rejected)

    if not found:
        return None, None
    lasting = next(((end, run) for run in found if (end := lasting_end(run))), None)
    return (
        alarm(found[0][0], found[0][0]),
        None if lasting is None else alarm(lasting[0], lasting[1][0]),
    )


def clean(flight: str, autopilot: str, judged: Sequence[Judged]) -> Clean:
    """Judge a flight, or a part of one, that was not attacked."""
    settled = [one for one in judged if one.settled]
    steps = [
        min(b.stamp_ns - a.stamp_ns, NANOSECONDS)
        for a, b in itertools.pairwise(judged)
        if a.settled
    ]
    found = runs(settled)
    return Clean(
        flight,
        autopilot,
        sum(steps) / NANOSECONDS / 3600.0,
        len(found),
        sum(lasting_end(run) is not None for run in found),
        sum(len(one.resets) > 0 for one in settled),
        max((one.worst for one in settled), default=0.0),
    )
