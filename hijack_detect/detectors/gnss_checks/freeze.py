# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A stream that repeats itself while the vehicle moves."""

from __future__ import annotations

from hijack_detect.detectors.gnss_checks.step import ZERO, Finding, Step, known, length
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS

MIN_REPEATS = 3
MOVING = 0.5
"""m/s. A position in steps of 1 cm or less does not repeat at this speed, one sample a second
or faster."""
STOPPED_FROM = 1.0
"""m/s. A receiver that holds its position does so only when it is slower than this."""


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
