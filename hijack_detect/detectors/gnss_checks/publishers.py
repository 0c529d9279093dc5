# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Two interleaved streams: positions that alternate between two tracks."""

from __future__ import annotations

from collections import deque

from hijack_detect.detectors.gnss_checks.step import ZERO, Finding, Step, length, plus
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS, Vector3

REVERSALS, WINDOW_NS = 4, 3 * NANOSECONDS
PAIR_NS = 3 * NANOSECONDS // 2
APART_M = 2.0
"""Tracks nearer to each other than this are not told apart."""


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
            back = length(plus(residual, last)) < 0.4 * min(length(residual), length(last))
            if back and step.stamp_ns - stamp_ns <= PAIR_NS:
                self._reversals.append(step.stamp_ns)
            self._last = (step.stamp_ns, residual)
        recent = sum(step.stamp_ns - one <= WINDOW_NS for one in self._reversals)
        margin = recent / REVERSALS
        state = State.SUSPICIOUS if recent >= REVERSALS // 2 else State.NORMAL
        text = f"position alternates between two tracks, {recent} times in 3 s"
        return Finding(margin, State.ALARM if margin >= 1.0 else state, text)
