# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How much worse than the model the sensors of this vehicle are, learnt in flight."""

from __future__ import annotations

import math
from collections import deque

from hijack_detect.streams.samples import NANOSECONDS

PRIOR = 1.0
"""Scale before anything is learnt."""
MAX_STEP_S = 1.0
"""A gap between two samples counts as this at most."""


KNOWN_S = 30.0
"""Time of values from which on the scale is known."""


class NoiseScale:
    """Root mean square of whitened errors over the flight's past, within bounds.

    Or the mean of another power, in which rare large errors count for more.
    What it learns is older than `delay_s`, so never what is under test; a single value counts
    as `clip` times the scale at most, `hold` keeps everything recent from being learnt, and once
    the scale is known it rises no faster than `rise_per_s`. An attacker can therefore raise it only
    slowly, and what it is is published.
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
        self._delay_ns = round(delay_s * NANOSECONDS)
        self._memory_s, self._clip, self._rise_per_s = memory_s, clip, rise_per_s
        self._power = power
        self._known_s = 0.0
        self._sum, self._weight = prior_s * prior**power, prior_s
        self._waiting: deque[tuple[int, float]] = deque()
        self._learnt_ns: int | None = None
        self.value = prior
        """The scale."""

    def add(self, stamp_ns: int, mean_power: float) -> None:
        """Take the mean of the whitened errors' powers (squares) at a stamp."""
        self._waiting.append((stamp_ns, mean_power))
        while self._waiting and self._waiting[0][0] < stamp_ns - self._delay_ns:
            self._learn(*self._waiting.popleft())

    def hold(self) -> None:
        """Do not learn what is waiting: it is under suspicion."""
        self._waiting.clear()

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
