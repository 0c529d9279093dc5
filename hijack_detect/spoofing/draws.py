# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Random numbers that depend on seed, place in time and stream only.

A dropped or repeated message therefore changes no other, and live and offline agree.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from hijack_detect.estimation.rotation import Array


def generator(seed: int, index: int, stream: int) -> np.random.Generator:
    """A generator for one place in time: a stamp in nanoseconds, or the number of a knot.

    Args:
        seed: The attack's seed, not negative.
        index: The place in time, of any sign.
        stream: Which of the attack's independent noises.
    """
    return np.random.Generator(np.random.PCG64([seed, abs(index), int(index < 0), stream]))


class Draws:
    """One noise of an attack: drawn for each stamp, or on straight lines between knots.

    At the knots, a multiple of the correlation time after onset, the values are independent draws
    with their full variance; half-way between two knots the variance is half of it.
    """

    def __init__(
        self,
        seed: int,
        stream: int,
        correlation_s: float,
        draw: Callable[[np.random.Generator], Array],
    ) -> None:
        """Describe the noise.

        Args:
            seed: The attack's seed.
            stream: Number of this noise; different numbers are independent.
            correlation_s: Seconds between knots, 0 for a draw for each stamp.
            draw: Draws the values of one place in time.
        """
        self._seed, self._stream = seed, stream
        self._correlation_s = correlation_s
        self._draw = draw

    def at(self, t_s: float, stamp_ns: int) -> list[float]:
        """Values at a stamp, `t_s` seconds after onset."""
        if not self._correlation_s:
            return _floats(self._values(stamp_ns))
        knots = t_s / self._correlation_s
        knot = math.floor(knots)
        before, after = self._values(knot), self._values(knot + 1)
        return _floats(before + (knots - knot) * (after - before))

    def _values(self, index: int) -> Array:
        return self._draw(generator(self._seed, index, self._stream))


def _floats(values: Array) -> list[float]:
    return [float(value) for value in values]
