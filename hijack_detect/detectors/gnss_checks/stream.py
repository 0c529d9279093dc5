# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A stream that repeats itself while the vehicle moves."""

from __future__ import annotations

import math
from collections import deque

from hijack_detect.detectors.gnss_checks.step import ZERO, Finding, Step, known, length, plus
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.receiver_clock import seconds_off
from hijack_detect.streams.samples import NANOSECONDS, Vector3

MIN_REPEATS = 3
"""Repeated positions that an alarm needs, also of a slow receiver. Chosen, not swept."""
MOVING = 0.5
"""m/s. A position in steps of 1 cm or less does not repeat at this speed, one sample a second
or faster. Chosen, not swept."""
STOPPED_FROM = 1.0
"""m/s. A receiver that holds its position does so only when it is slower than this.
Chosen, not swept."""


class FreezeCheck:
    """Bit-identical positions, where that is evidence.

    It is evidence while the velocity is not zero and repeats too (noise never does), while the
    reported speed is above MOVING, and when the velocity (or, from fixes alone, the motion)
    went from above STOPPED_FROM to exactly zero in one step. A receiver that stands and reports
    zero is none: many hold their position at rest.
    """

    name = "freeze"

    def __init__(self, alarm_s: float) -> None:
        """Alarm once it has lasted `alarm_s` seconds; SUSPICIOUS from half of that."""
        self._alarm_s = alarm_s
        self._since_ns: int | None = None
        self._repeats = 0
        self._speed_before = 0.0
        """Speed before the position stood still, m/s."""
        self._flown = 0.0

    def judge(self, step: Step) -> Finding:
        """See Check."""
        why = self._evidence(step) if step.still else None
        if not step.still:
            self._note_speed(step)
        if why is None:
            self._since_ns, self._repeats = None, 0
            return Finding()
        if self._since_ns is None:
            self._since_ns = step.previous.stamp_ns
        self._repeats += 1
        lasted_s = (step.stamp_ns - self._since_ns) / NANOSECONDS
        margin = min(lasted_s / self._alarm_s, self._repeats / MIN_REPEATS)
        state = State.NORMAL
        if margin >= 0.5 and self._repeats > 1:
            state = State.ALARM if margin >= 1.0 else State.SUSPICIOUS
        return Finding(margin, state, f"position repeats for {lasted_s:.1f} s, {why}")

    def _note_speed(self, step: Step) -> None:
        """Reported speed; from fixes alone the smaller of two steps, as one may be a jump."""
        flown = length(step.moved) / step.dt_s
        slower, self._flown = min(flown, self._flown), flown
        self._speed_before = slower if step.velocity is None else length(known(step.velocity))

    def _evidence(self, step: Step) -> str | None:
        velocity = None if step.velocity is None else known(step.velocity)
        before = None if step.before is None else known(step.before)
        if velocity is not None and velocity != ZERO:
            if length(velocity) >= MOVING:
                return f"speed {length(velocity):.1f} m/s"
            return "velocity repeats too" if velocity == before else None
        if self._speed_before >= STOPPED_FROM:
            return f"motion was {self._speed_before:.1f} m/s"
        return None


SUSPICIOUS_FROM = 2
"""Stamps that repeat or jump within `stamps_in_s`. Chosen: a single one is a hiccup."""
KEPT = 64
STEP_MARGIN = 0.5
"""Of a step of the receiver's time. A leap second, a week that rolls over or GPS time for UTC is no
attack, so it never alarms; a position that is carried off with it is for the others to find.
Chosen: any value below 1."""


class StampsCheck:
    """Refused stamps of fixes and velocities within the last seconds.

    A refused sample is noted with the stamp of the last good one of its topic and reported from the
    first fix after that, so that the report does not depend on when topics arrive. A copy of
    the last good sample (a bridge that publishes twice), one that was overtaken by the next (a
    radio link) and one that follows on a refused one (a clock that was set back) are SUSPICIOUS at
    most. So is a step of the receiver's time, which was taken off its stamps before they came here
    (`ReceiverClock`): it is reported as long as a refused stamp would be.
    """

    name = "time"

    def __init__(self, alarm_count: int, window_s: float) -> None:
        """Alarm at `alarm_count` refused within `window_s` seconds."""
        self._alarm_count = alarm_count
        self._window_ns = round(window_s * NANOSECONDS)
        self._refused: deque[tuple[int, bool]] = deque(maxlen=KEPT)
        self._offset_ns: int | None = None
        self._stepped: tuple[int, str] | None = None
        """When the receiver's time was found to be another, and the words for it."""

    def note(self, after_ns: int, *, harmless: bool) -> None:
        """Note a refused sample, whether it is harmless, and the last good stamp of its topic."""
        self._refused.append((after_ns, harmless))

    def judge(self, step: Step) -> Finding:
        """See Check."""
        now = step.stamp_ns
        self._note_time(step)
        recent = [
            harmless for after, harmless in self._refused if 0 < now - after <= self._window_ns
        ]
        broken = len(recent) - sum(recent)
        margin = max(broken / self._alarm_count, min(MOST, len(recent) / self._alarm_count))
        state = State.SUSPICIOUS if len(recent) >= SUSPICIOUS_FROM else State.NORMAL
        text = (
            f"{len(recent)} stamps repeat, run back or jump within "
            f"{self._window_ns / NANOSECONDS:g} s ({broken} of them neither copies, nor overtaken, "
            "nor of a clock set back)"
        )
        if self._stepped is not None and now - self._stepped[0] <= self._window_ns:
            if not recent:
                return Finding(STEP_MARGIN, State.SUSPICIOUS, self._stepped[1], innocent=True)
            text = f"{self._stepped[1]}; {text}"
            state, margin = State.SUSPICIOUS, max(margin, STEP_MARGIN)
        return Finding(margin, State.ALARM if margin >= 1.0 else state, text)

    def _note_time(self, step: Step) -> None:
        """Note how far the receiver's time is off, if that is new."""
        offset_ns, known_ns = step.fix.clock_offset_ns, self._offset_ns
        if known_ns is None:
            known_ns = step.previous.clock_offset_ns
            if known_ns:
                text = f"The receiver's stamps are {seconds_off(known_ns)} of the IMU's clock"
                self._stepped = (step.previous.stamp_ns, f"{text}, which is taken off them")
        if offset_ns != known_ns:
            by_s = (offset_ns - known_ns) / NANOSECONDS
            text = f"The receiver's time stepped by {by_s:+.1f} s"
            self._stepped = (step.stamp_ns, f"{text}, which is taken off its stamps")
        self._offset_ns = offset_ns


REVERSALS, REVERSAL_NS = 4, 3 * NANOSECONDS
PAIR_NS = 3 * NANOSECONDS // 2
"""This many steps within REVERSAL_NS, each taken back within PAIR_NS, are an alarm.
Chosen, not swept."""
APART_M = 2.0
"""Tracks nearer to each other than this are not distinguished. Chosen, not swept."""
LEFT = 0.4
"""A step is taken back if less than this part of the smaller of the two is left.
Chosen, not swept."""


class PublishersCheck:
    """Counts steps that are taken back by a following one, as between two publishers."""

    name = "publishers"

    def __init__(self) -> None:
        """Start without steps."""
        self._last: tuple[int, Vector3] = (0, ZERO)
        self._reversals: deque[int] = deque(maxlen=REVERSALS)

    def judge(self, step: Step) -> Finding:
        """See Check."""
        residual = step.residual
        if residual is not None and step.from_velocity and length(residual) > APART_M:
            stamp_ns, last = self._last
            back = length(plus(residual, last)) < LEFT * min(length(residual), length(last))
            if back and step.stamp_ns - stamp_ns <= PAIR_NS:
                self._reversals.append(step.stamp_ns)
            self._last = (step.stamp_ns, residual)
        recent = sum(step.stamp_ns - one <= REVERSAL_NS for one in self._reversals)
        margin = recent / REVERSALS
        state = State.SUSPICIOUS if recent >= REVERSALS // 2 else State.NORMAL
        text = f"position alternates between two tracks, {recent} times in 3 s"
        return Finding(margin, State.ALARM if margin >= 1.0 else state, text)


VARIATION_NS = 5 * NANOSECONDS
"""The 5 s of `satellites_in_5_s` and `covariance_in_5_s`, whose limits belong to it."""
MOST = 0.9
"""Margin of a figure that may only be SUSPICIOUS. Chosen, not swept."""


class _Variation:
    """Sum of the changes of a figure over the last 5 s."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._changes: deque[tuple[int, float]] = deque()
        self.total = 0.0
        self.change = 0.0

    def add(self, stamp_ns: int, value: float | None, most: float = math.inf) -> None:
        """Add a value; a change counts for `most` at most."""
        last, self._last = self._last, value
        self.change = 0.0 if last is None or value is None else abs(value - last)
        if self.change:
            self._changes.append((stamp_ns, min(self.change, most)))
        while self._changes and stamp_ns - self._changes[0][0] > VARIATION_NS:
            self._changes.popleft()
        self.total = math.fsum(change for _, change in self._changes)


def _only_suspicious(part: float, text: str) -> Finding:
    """Finding of evidence that is `part` of what is suspicious."""
    state = State.SUSPICIOUS if part >= 1.0 else State.NORMAL
    return Finding(min(0.5 * part, MOST), state, text)


class SatellitesCheck:
    """The number of satellites: one change, and the sum of all changes over 5 s."""

    name = "satellites"

    def __init__(self, at_once: float, in_5_s: float) -> None:
        """SUSPICIOUS from these numbers on."""
        self._at_once, self._in_5_s = at_once, in_5_s
        self._variation = _Variation()

    def judge(self, step: Step) -> Finding:
        """See Check."""
        seen = self._variation
        seen.add(step.stamp_ns, step.count)
        part = max(seen.change / self._at_once, seen.total / self._in_5_s)
        text = f"satellites change by {seen.change:.0f} at once, {seen.total:.0f} in 5 s"
        return _only_suspicious(part, text)


class CovarianceCheck:
    """The accuracy the receiver claims: sum of the changes of its logarithm over 5 s.

    One change counts for a factor e at most: a receiver that finds or loses its corrections
    changes it a hundredfold, once.
    """

    name = "covariance"

    def __init__(self, in_5_s: float) -> None:
        """SUSPICIOUS from this sum of changes of ln(accuracy) on."""
        self._in_5_s = in_5_s
        self._variation = _Variation()

    def judge(self, step: Step) -> Finding:
        """See Check."""
        accuracy = step.fix.accuracy_m
        self._variation.add(step.stamp_ns, None if accuracy is None else math.log(accuracy), 1.0)
        total = self._variation.total
        text = f"claimed accuracy changes by {total:.1f} in ln over 5 s (limit {self._in_5_s:g})"
        return _only_suspicious(total / self._in_5_s, text)
