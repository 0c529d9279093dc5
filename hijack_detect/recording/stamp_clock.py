# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The time of a recording, from header stamps."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.streams.samples import NANOSECONDS

LEAP_S = 2.0
"""A stamp further than this from those before is doubted until the next one confirms it. Chosen,
not swept; above the period of any input (1 s), below an outage."""
BEHIND_S = 30.0
"""Largest lag of the first stamp of an input behind the others, as in a fast replay. Chosen, not
swept."""


@dataclass
class _Input:
    latest_ns: int | None = None
    doubted_ns: int | None = None


class StampClock:
    """The newest stamp that is confirmed.

    A stamp is accepted if it lies within `LEAP_S` of the clock, or of the one before of the same
    input: inputs may have clocks of their own. The first of an input may be `BEHIND_S` late. Any
    other is doubted until the next of the same input follows on it, so one broken stamp changes
    nothing. A leap backwards that is confirmed (a looped bag, a clock that was set) begins a new
    recording.

    Attributes:
        now_ns: Newest stamp accepted in this recording, nanoseconds; None before the first.
        restarted: Whether the last `push` began a new recording.
    """

    def __init__(self) -> None:
        self._leap_ns = round(LEAP_S * NANOSECONDS)
        self._behind_ns = round(BEHIND_S * NANOSECONDS)
        self._inputs: dict[str, _Input] = {}
        self.now_ns: int | None = None
        self.restarted = False

    def push(self, name: str, stamp_ns: int) -> bool:
        """Take a stamp of an input; return whether it is accepted."""
        self.restarted = False
        source = self._inputs.setdefault(name, _Input())
        if not self._follows(source, stamp_ns):
            doubted = source.doubted_ns
            if doubted is None or abs(stamp_ns - doubted) > self._leap_ns:
                source.doubted_ns = stamp_ns
                return False
            if source.latest_ns is not None and stamp_ns < source.latest_ns:
                self._restart()
                source = self._inputs.setdefault(name, _Input())
        source.doubted_ns = None
        source.latest_ns = stamp_ns
        self.now_ns = stamp_ns if self.now_ns is None else max(self.now_ns, stamp_ns)
        return True

    def _follows(self, source: _Input, stamp_ns: int) -> bool:
        """Whether the stamp is near to the clock or to the input's last one."""
        if self.now_ns is None:
            return True
        if source.latest_ns is None:
            return -self._behind_ns <= stamp_ns - self.now_ns <= self._leap_ns
        return any(abs(stamp_ns - one) <= self._leap_ns for one in (self.now_ns, source.latest_ns))

    def _restart(self) -> None:
        self._inputs.clear()
        self.now_ns = None
        self.restarted = True
