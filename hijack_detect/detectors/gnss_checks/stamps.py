# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Stamps that repeat, run backwards or jump: what the merge refused before any check saw it."""

from __future__ import annotations

from collections import deque

from hijack_detect.detectors.gnss_checks.step import Finding, Step
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS

SUSPICIOUS_FROM = 2
KEPT = 64


class StampsCheck:
    """Refused stamps of fixes and velocities within the last seconds.

    A refused sample is noted with the stamp of the last good one of its topic and told from the
    first fix after that, so that what is said does not depend on when topics arrive. A copy of
    the last good sample (a bridge that publishes twice), one that was overtaken by the next (a
    radio link) and one that follows on a refused one (a clock that was set back) are SUSPICIOUS at
    most.
    """

    name = "time"

    def __init__(self, alarm_count: int, window_s: float) -> None:
        """Alarm at `alarm_count` refused within `window_s` seconds."""
        self._alarm_count = alarm_count
        self._window_ns = round(window_s * NANOSECONDS)
        self._refused: deque[tuple[int, bool]] = deque(maxlen=KEPT)

    def note(self, after_ns: int, *, harmless: bool) -> None:
        """Note a refused sample, whether it is harmless, and the last good stamp of its topic."""
        self._refused.append((after_ns, harmless))

    def judge(self, step: Step) -> Finding:
        """See Check."""
        now = step.stamp_ns
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
        return Finding(margin, State.ALARM if margin >= 1.0 else state, text)
