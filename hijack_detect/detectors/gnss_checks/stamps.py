# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Stamps that repeat, run backwards or jump, and steps of the time that the receiver has."""

from __future__ import annotations

from collections import deque

from hijack_detect.detectors.gnss_checks.step import Finding, Step
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.receiver_clock import seconds_off
from hijack_detect.streams.samples import NANOSECONDS

SUSPICIOUS_FROM = 2
KEPT = 64
STEP_MARGIN = 0.5
"""Of a step of the receiver's time. A leap second, a week that rolls over or GPS time for UTC is no
attack, so it never alarms; a position that is carried off with it is for the others to find."""


class StampsCheck:
    """Refused stamps of fixes and velocities within the last seconds.

    A refused sample is noted with the stamp of the last good one of its topic and told from the
    first fix after that, so that what is said does not depend on when topics arrive. A copy of
    the last good sample (a bridge that publishes twice), one that was overtaken by the next (a
    radio link) and one that follows on a refused one (a clock that was set back) are SUSPICIOUS at
    most. So is a step of the receiver's time, which was taken off its stamps before they came here
    (`ReceiverClock`): it is named for as long as a refused stamp would be.
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
        margin = max(broken / self._alarm_count, min(0.9, len(recent) / self._alarm_count))
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
