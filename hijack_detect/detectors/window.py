# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Sums over a sliding window in time that cost O(1) a sample and never drift."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

FULL = 0.9
"""Share of its length from which on a window is full. Samples do not lie on its ends: at 5 Hz one
of 2 s spans 1.8 s."""
SCALE = 1 << 40
"""Fixed-point units per unit: a resolution of 1e-12."""


class WindowSums:
    """Sums of values and of products of pairs of values over the last seconds.

    Values are held as integers in fixed point. Adding and removing integers is exact, so the
    sums equal those of all values computed at once, after hours, whatever the window length.
    """

    def __init__(self, length_ns: int, channels: int, products: Sequence[tuple[int, int]] = ()):
        """Make an empty window.

        Args:
            length_ns: Length of the window; a sample leaves when it is this old.
            channels: Number of values a sample has.
            products: Pairs of channels whose products are summed too.
        """
        self._length_ns = length_ns
        self._products = tuple(products)
        self._samples: deque[tuple[int, tuple[int, ...]]] = deque()
        self._sums = [0] * channels
        self._product_sums = [0] * len(self._products)

    def __len__(self) -> int:
        """Number of samples in the window."""
        return len(self._samples)

    def clear(self) -> None:
        """Empty the window."""
        self._samples.clear()
        self._sums = [0] * len(self._sums)
        self._product_sums = [0] * len(self._products)

    def add(self, stamp_ns: int, values: Sequence[float]) -> None:
        """Add a sample and drop those that are `length_ns` older or more."""
        fixed = tuple([round(value * SCALE) for value in values])
        self._samples.append((stamp_ns, fixed))
        self._account(fixed, 1)
        self.drop_before(stamp_ns - self._length_ns)

    def drop_before(self, stamp_ns: int) -> None:
        """Drop the samples at or before a stamp."""
        while self._samples and self._samples[0][0] <= stamp_ns:
            self._account(self._samples.popleft()[1], -1)

    def _account(self, values: tuple[int, ...], sign: int) -> None:
        for channel, value in enumerate(values):
            self._sums[channel] += sign * value
        for index, (a, b) in enumerate(self._products):
            self._product_sums[index] += sign * values[a] * values[b]

    @property
    def span_ns(self) -> int:
        """Time from the oldest to the newest sample."""
        return self._samples[-1][0] - self._samples[0][0] if self._samples else 0

    def mean(self, channel: int) -> float:
        """Mean of a channel; the window must not be empty."""
        return self._sums[channel] / (len(self._samples) * SCALE)

    def means(self) -> list[float]:
        """Means of all channels; the window must not be empty."""
        count = len(self._samples) * SCALE
        return [one / count for one in self._sums]

    def covariance(self, product: int) -> float:
        """Population covariance of the pair of channels with this index in `products`."""
        a, b = self._products[product]
        n = len(self._samples)
        centred = n * self._product_sums[product] - self._sums[a] * self._sums[b]
        return centred / (n * n * SCALE * SCALE)


class Unwrap:
    """Makes a sequence of angles continuous by adding whole turns."""

    def __init__(self) -> None:
        """Start without a previous angle."""
        self._last: float | None = None

    def __call__(self, angle: float) -> float:
        """The angle, in radians, at most half a turn from the previous result."""
        if self._last is not None:
            angle = self._last + math.remainder(angle - self._last, math.tau)
        self._last = angle
        return angle
