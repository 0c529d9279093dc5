# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A condition must hold for a while before it is an alarm."""

from __future__ import annotations

from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS


class Persistence:
    """Turns a condition over time into NORMAL, SUSPICIOUS or ALARM, on header stamps."""

    def __init__(self, persist_s: float) -> None:
        """Alarm once the condition has held for `persist_s` seconds."""
        self._persist_ns = round(persist_s * NANOSECONDS)
        self._since_ns: int | None = None

    def reset(self) -> None:
        """The condition cannot be judged now: start over."""
        self._since_ns = None

    def state(self, stamp_ns: int, condition: bool) -> State:
        """State at a stamp."""
        if not condition:
            self._since_ns = None
            return State.NORMAL
        if self._since_ns is None:
            self._since_ns = stamp_ns
        held = stamp_ns - self._since_ns >= self._persist_ns
        return State.ALARM if held else State.SUSPICIOUS
