# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Worth of a clean result: the pulls that would have been seen, for how long, or why none."""

from __future__ import annotations

import bisect
import itertools
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from hijack_detect.analysis.account import Account, Complaint, Watched
from hijack_detect.analysis.alarms import NO_VERDICT, Span, Times
from hijack_detect.analysis.analysis import Visible
from hijack_detect.detectors.verdict import JUDGED
from hijack_detect.estimation.clock_rate import clock_words
from hijack_detect.estimation.lag_ekf import LATE
from hijack_detect.estimation.receiver_health import POOR
from hijack_detect.streams.samples import NANOSECONDS

STEPS = (0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0)
"""m/s²: the pulls that `visible_steps` counts. Chosen, not swept."""
MOST = 0.9
"""Share of the time in which `coast` could tell that the sentence claims: the tenth in which it
was blindest would make the claimed size large and the claimed time hardly longer. Chosen, not
swept."""
LEAST = 0.005
"""Share of the time in the air below which nothing was judged: it is displayed as 0 %."""
LEAST_POOR_S = 5.0
"""Seconds for which a receiver has to be poor or late to be named. Chosen, not swept."""
FAULTY = 0.1
"""Share of the flight for which an IMU has to be faulty to be named. Chosen, not swept."""
UNCORRECTED = "the flight has no time of the receiver to correct it, so the IMU fits the GPS less"
MOST_STEPS = 8
"""Steps of the receiver's time that are named one by one."""


def visible(watched: Watched) -> Visible | None:
    """The pull that `coast` would have seen in nine tenths of the time in which it could tell.

    It is rounded up to 0.1 m/s², and its time is that in which `coast` claimed to see it, so that
    the sentence is true of each moment that it counts.
    """
    weighed = sorted(
        (least, (watched.in_air & Times([(start, end)])).seconds)
        for start, end, least in watched.visible
    )
    seconds_up_to = list(itertools.accumulate(seconds for _, seconds in weighed))
    if not seconds_up_to or seconds_up_to[-1] <= 0.0:
        return None
    least = weighed[bisect.bisect_left(seconds_up_to, MOST * seconds_up_to[-1])][0]
    size = max(math.ceil(10.0 * least - 1e-9), 1) / 10.0
    return Visible(acceleration=size, time_s=watched.seen(size).seconds)


def visible_steps(watched: Watched) -> Iterator[Visible]:
    """The time in which each of some pulls would have been seen."""
    for size in STEPS:
        yield Visible(acceleration=size, time_s=watched.seen(size).seconds)


def not_judged(account: Account, watched: Watched, spans: Mapping[str, list[Span]]) -> str | None:
    """Reason why nothing could have seen a carry-off, the first cause; None if something could."""
    in_air_s = watched.in_air.seconds
    if (watched.in_air & watched.carry_off).seconds > LEAST * in_air_s:
        return None
    unusable = account.inputs.unusable()
    if unusable:
        return unusable
    if in_air_s <= 0.0:
        return _on_the_ground(account)
    least_ns = FAULTY * in_air_s * NANOSECONDS
    faults = {words: ns for words, ns in account.imu_faults.values() if ns > least_ns}
    if faults:
        return f"the IMU cannot be used: {_of_it(max(faults, key=lambda one: faults[one]))}"
    seeing = sorted(n for n, one in account.weights.items() if one.sees_carry_off and n in spans)
    reasons = {name: _main_reason(spans[name], watched.in_air) for name in seeing}
    given = [f"{name}: {why}" for name, why in reasons.items() if why != NO_VERDICT]
    causes = "; ".join(given) or "none gave a verdict"
    why = f"no detector that could see a carry-off could tell ({causes})"
    others = sorted(
        name
        for name, judged in watched.judged.items()
        if name not in seeing and (judged & watched.in_air).seconds > LEAST * in_air_s
    )
    return f"{why}; only {', '.join(others)} could, and see other attacks" if others else why


def _on_the_ground(account: Account) -> str:
    """Phase in which the vehicle was instead of flying."""
    if not account.phases:
        return "the IMU gives no phase of flight"
    phase, reason = max(account.phases, key=lambda key: account.phases[key])
    return f"the vehicle was never in the air ({phase}{': ' if reason else ''}{reason})"


def _main_reason(spans: Sequence[Span], in_air: Times) -> str:
    """Most lasting reason why a detector could not tell in the air."""
    lasted: Counter[str] = Counter()
    for span in spans:
        if span.state not in JUDGED:
            overlap = in_air & Times([(span.start_ns, span.end_ns)])
            if overlap.intervals:
                lasted[span.reason] += round(overlap.seconds * 1e6)
    return max(
        lasted, key=lambda reason: (reason != NO_VERDICT, lasted[reason]), default=NO_VERDICT
    )


def sensor_notes(account: Account, duration_s: float) -> Iterator[str]:
    """Notes on the sensors and their clocks."""
    yield from account.inputs.notes(duration_s)
    if account.clock_rate is not None:
        yield f"{clock_words(account.clock_rate).capitalize()}: {UNCORRECTED}."
    for what, complaint in ((POOR, account.poor), (LATE, account.late)):
        if words := lasting(complaint):
            lasted_s = complaint.lasted_ns / NANOSECONDS
            share = min(100.0 * lasted_s / duration_s, 100.0) if duration_s > 0.0 else 100.0
            yield f"{what[0].upper()}{what[1:]} for {lasted_s:.0f} s ({share:.0f} %): {words}."
    for words, lasted_ns in account.imu_faults.values():
        if lasted_ns / NANOSECONDS > FAULTY * duration_s:
            yield f"The IMU could not be used for {lasted_ns / NANOSECONDS:.0f} s: {_of_it(words)}."


def lasting(complaint: Complaint) -> str:
    """In what the receiver was poor or late, empty if it was for a few seconds at most."""
    return complaint.words if complaint.lasted_ns >= LEAST_POOR_S * NANOSECONDS else ""


def clock_notes(found: Sequence[str]) -> Iterator[str]:
    """Corrections of the receiver's stamps by `ReceiverClock`, a sentence each."""
    for what in found[:MOST_STEPS]:
        yield f"Clock of the receiver, {what}."
    if len(found) > MOST_STEPS:
        yield f"Clock of the receiver: {len(found) - MOST_STEPS} steps more."


def _of_it(words: str) -> str:
    """Fault of an IMU that the sentence has named already."""
    return re.sub("^the IMU ", "it ", words)
