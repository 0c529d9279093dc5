# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How good a receiver is, learned from its own clean past, in a way that is hard to mislead."""

from __future__ import annotations

from collections import deque

from hijack_detect.streams.samples import NANOSECONDS

DELAY_NS = 20 * NANOSECONDS
"""Only levels this old are learned, the longest horizon of the check that uses them."""
START = 2.5
"""Part until the vehicle has moved or flown: a receiver that has just started settles, by 10 m in
10 s in one of the recorded flights."""
STARTED_NS = 10 * NANOSECONDS
"""Time in motion after which it counts as started."""
NEEDED_NS = 30 * NANOSECONDS
"""Time in motion before the limits tighten."""
RISE_PER_S = 0.005
"""The part grows no faster: from a tenth to the whole in three minutes."""
QUICK_RISE_PER_S = 0.02
"""The part grows no faster towards what changes of both signs show: an error wanders to and fro,
an attacker who wants to be somewhere else goes one way and trains nothing by it."""
FALL_PER_S = 0.05
FORGET_PER_S = 1.0 / 300.0
"""The largest level seen is forgotten at this relative rate, per second in motion."""
MAX_STEP_NS = NANOSECONDS


class LearnedLevel:
    """Part of the full limits that applies now, between a floor and 1 in flight.

    It starts at START, and is at most `ceiling` (the worst receiver that is flown with) after
    STARTED_NS of motion. Then it falls towards `gain` times the largest level of the past, below 1
    after NEEDED_NS. It rises slowly and never above the ceiling, so whoever trains it up stays
    below limits which are safe in any case, needs minutes for it, and the part is published. What
    has a sign may give the levels of both: it then rises faster towards the smaller of them.
    """

    def __init__(self, floor: float, gain: float, ceiling: float = 1.0) -> None:
        """Nothing is learned yet.

        Args:
            floor: Least part, below 1.
            gain: The part is so many times the largest level.
            ceiling: Largest part in flight, at least 1.
        """
        self._floor, self._gain = floor, gain
        self.ceiling = ceiling
        """Largest part in flight, at least 1."""
        self.part = START
        self._waiting: deque[tuple[int, float, float]] = deque()
        self._largest = self._opposite = 0.0
        self.moved_ns = 0
        """Time in motion, nanoseconds."""
        self._last_ns: int | None = None

    def add(self, stamp_ns: int, level: float, *, moving: bool, opposite: float = 0.0) -> None:
        """Note a level: the check's largest figure in units of its full limit.

        Args:
            stamp_ns: Stamp of the level.
            level: The level.
            moving: Whether it may be learned: only in motion and below the limit in force.
            opposite: The level of the other sign, for figures that have one.
        """
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if not moving or last_ns is None:
            return
        passed_ns = min(stamp_ns - last_ns, MAX_STEP_NS)
        passed_s = passed_ns / NANOSECONDS
        self.moved_ns += passed_ns
        self._waiting.append((stamp_ns, level, opposite))
        if self.moved_ns >= STARTED_NS:
            self.part = min(self.part, self.ceiling)
        kept = 1.0 - FORGET_PER_S * passed_s
        self._largest *= kept
        self._opposite *= kept
        while self._waiting and stamp_ns - self._waiting[0][0] > DELAY_NS:
            _, level, opposite = self._waiting.popleft()
            self._largest = max(self._largest, level)
            self._opposite = max(self._opposite, opposite)
        if self.moved_ns < STARTED_NS:
            return
        smaller, larger = sorted((self._largest, self._opposite))
        wanted = max(self._floor if self.moved_ns >= NEEDED_NS else 1.0, self._gain * larger)
        slow = min(wanted, self.part + RISE_PER_S * passed_s)
        quick = min(self._gain * smaller, self.part + QUICK_RISE_PER_S * passed_s)
        lowest = self.part - FALL_PER_S * passed_s
        self.part = max(lowest, min(self.ceiling, max(slow, quick)))
