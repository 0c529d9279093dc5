# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How noisy the sensors of this vehicle are, learnt in flight in ways that are hard to mislead.

Nothing under test is learnt: a value waits until it is older than what the detector judges, and
what is under suspicion by then is dropped.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Generic, TypeVar

from hijack_detect.streams.samples import NANOSECONDS

T = TypeVar("T")

PRIOR = 1.0
"""Scale before anything is learnt: what the model says."""
MAX_STEP_S = 1.0
"""A gap between two samples counts as this at most. Chosen, not swept."""
KNOWN_S = 30.0
"""Time of values from which on the scale is known. Chosen, not swept."""


class Delayed(Generic[T]):
    """Values that wait until they are old enough to be learnt."""

    def __init__(self, delay_s: float) -> None:
        """Start without values.

        Args:
            delay_s: A value is learnt once it is older than this, s.
        """
        self._delay_ns = round(delay_s * NANOSECONDS)
        self._waiting: deque[tuple[int, T]] = deque()

    def add(self, stamp_ns: int, value: T) -> list[tuple[int, T]]:
        """Take a value; the stamps and values that are old enough by now, the oldest first."""
        self._waiting.append((stamp_ns, value))
        old = []
        while self._waiting and self._waiting[0][0] < stamp_ns - self._delay_ns:
            old.append(self._waiting.popleft())
        return old

    def hold(self) -> None:
        """Drop what is waiting: it is under suspicion."""
        self._waiting.clear()


class NoiseScale:
    """Root mean square of whitened errors over the flight's past, within bounds.

    Or the mean of another power, in which rare large errors count for more.
    What it learns is older than `delay_s`, so never what is under test; a single value counts
    as `clip` times the scale at most, `hold` keeps everything recent from being learnt, and once
    the scale is known it rises no faster than `rise_per_s`. An attacker can therefore raise it only
    slowly, and its value is published.
    """

    def __init__(
        self,
        low: float,
        high: float,
        *,
        delay_s: float,
        memory_s: float,
        prior_s: float,
        clip: float,
        prior: float = PRIOR,
        rise_per_s: float = math.inf,
        power: float = 2.0,
    ) -> None:
        """Start with the prior.

        Args:
            low: Smallest scale.
            high: Largest scale.
            delay_s: Age at which a value is learnt, s.
            memory_s: Time constant of forgetting, s.
            prior_s: The prior weighs as much as this time of values, s.
            clip: Largest value, in scales.
            prior: Scale before anything is learnt.
            rise_per_s: Largest relative rise after KNOWN_S of values, 1/s.
            power: Of the mean.
        """
        self._low, self._high = low, high
        self._delayed = Delayed[float](delay_s)
        self._memory_s, self._clip, self._rise_per_s = memory_s, clip, rise_per_s
        self._power = power
        self._known_s = 0.0
        self._sum, self._weight = prior_s * prior**power, prior_s
        self._learnt_ns: int | None = None
        self.value = prior
        """The scale."""

    def add(self, stamp_ns: int, mean_power: float) -> None:
        """Take the mean of the whitened errors' powers (squares) at a stamp."""
        for one in self._delayed.add(stamp_ns, mean_power):
            self._learn(*one)

    def hold(self) -> None:
        """Do not learn what is waiting: it is under suspicion."""
        self._delayed.hold()

    def _learn(self, stamp_ns: int, mean_power: float) -> None:
        since = self._learnt_ns
        self._learnt_ns = stamp_ns
        if since is None:
            return
        dt = min((stamp_ns - since) / NANOSECONDS, MAX_STEP_S)
        kept = math.exp(-dt / self._memory_s)
        clipped = min(mean_power, (self._clip * self.value) ** self._power)
        self._sum = self._sum * kept + clipped * dt
        self._weight = self._weight * kept + dt
        scale = float((self._sum / self._weight) ** (1.0 / self._power))
        self._known_s += dt
        if self._known_s > KNOWN_S:
            scale = min(scale, self.value * (1.0 + self._rise_per_s * dt))
        self.value = min(max(scale, self._low), self._high)


class Scatter:
    """Standard deviation of innovations over a usual one, from 1 to a largest.

    The variance follows the squares of the innovations, faster up than down. It starts with the
    worst that is distinguished.
    """

    def __init__(
        self, usual: float, largest: float, *, delay_s: float, rise_s: float, fall_s: float
    ) -> None:
        """Start with the largest scale.

        Args:
            usual: Standard deviation at scale 1, in the unit of the innovations.
            largest: Largest scale.
            delay_s: Age at which an innovation is learnt, s.
            rise_s: Time constant of a growing variance, s.
            fall_s: Time constant of one that shrinks, s.
        """
        self._usual, self._largest = usual, largest
        self._rise_s, self._fall_s = rise_s, fall_s
        self._variance = (largest * usual) ** 2
        self._delayed = Delayed[tuple[float, float]](delay_s)

    def add(self, stamp_ns: int, innovation: float, dt_s: float) -> None:
        """Take an innovation, and the time that it stands for."""
        for _, (old, dt) in self._delayed.add(stamp_ns, (innovation, dt_s)):
            clipped = min(abs(old), 2.0 * self._largest * self._usual)
            more = clipped * clipped - self._variance
            self._variance += min(1.0, dt / (self._rise_s if more > 0.0 else self._fall_s)) * more

    def hold(self) -> None:
        """Do not learn what is waiting: it is under suspicion."""
        self._delayed.hold()

    @property
    def scale(self) -> float:
        """Scatter over the usual one."""
        return min(self._largest, max(1.0, math.sqrt(self._variance) / self._usual))


LEVEL_DELAY_S = 20.0
"""Only levels this old are learned, the longest horizon of the check that uses them."""
START = 2.5
"""Part until the vehicle has moved or flown: a receiver that has just started settles, by 10 m in
10 s in one of the recorded flights."""
STARTED_NS = 10 * NANOSECONDS
"""Time in motion after which it counts as started. Chosen, not swept."""
NEEDED_NS = 30 * NANOSECONDS
"""Time in motion before the limits tighten. Chosen, not swept."""
RISE_PER_S = 0.005
"""The part grows no faster: from a tenth to the whole in three minutes. Chosen, not swept."""
QUICK_RISE_PER_S = 0.02
"""The part grows no faster towards what changes of both signs show: an error wanders to and fro,
an attacker who wants to be somewhere else goes one way and trains nothing by it.
Chosen, not swept."""
FALL_PER_S = 0.05
"""The part falls no faster. Chosen, not swept."""
FORGET_PER_S = 1.0 / 300.0
"""The largest level seen is forgotten at this relative rate, per second in motion.
Chosen, not swept."""


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
            gain: The part is this many times the largest level.
            ceiling: Largest part in flight, at least 1.
        """
        self._floor, self._gain = floor, gain
        self.ceiling = ceiling
        """Largest part in flight, at least 1."""
        self.part = START
        self._delayed = Delayed[tuple[float, float]](LEVEL_DELAY_S)
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
        passed_ns = min(stamp_ns - last_ns, round(MAX_STEP_S * NANOSECONDS))
        passed_s = passed_ns / NANOSECONDS
        self.moved_ns += passed_ns
        old = self._delayed.add(stamp_ns, (level, opposite))
        if self.moved_ns >= STARTED_NS:
            self.part = min(self.part, self.ceiling)
        kept = 1.0 - FORGET_PER_S * passed_s
        self._largest *= kept
        self._opposite *= kept
        for _, (one, other) in old:
            self._largest = max(self._largest, one)
            self._opposite = max(self._opposite, other)
        if self.moved_ns < STARTED_NS:
            return
        smaller, larger = sorted((self._largest, self._opposite))
        wanted = max(self._floor if self.moved_ns >= NEEDED_NS else 1.0, self._gain * larger)
        slow = min(wanted, self.part + RISE_PER_S * passed_s)
        quick = min(self._gain * smaller, self.part + QUICK_RISE_PER_S * passed_s)
        lowest = self.part - FALL_PER_S * passed_s
        self.part = max(lowest, min(self.ceiling, max(slow, quick)))
