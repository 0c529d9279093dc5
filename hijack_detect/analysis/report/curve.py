# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Quantities over time, as the figures draw them."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hijack_detect.streams.samples import NANOSECONDS

Array: TypeAlias = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """One quantity over time: seconds from the bag's first message, NaN where it is unknown."""

    time_s: Array
    value: Array


class Rows:
    """Rows of numbers, each with a stamp, in plain memory: flights may be long."""

    def __init__(self, width: int) -> None:
        """Start empty, for rows of so many numbers."""
        self._width = width
        self._stamps = array("q")
        self._numbers = array("d")

    def add(self, stamp_ns: int, *numbers: float) -> None:
        """Add a row."""
        self._stamps.append(stamp_ns)
        self._numbers.extend(numbers)

    def table(self, start_ns: int) -> tuple[Array, Array]:
        """Seconds since a start, shape (n,), and the rows, shape (n, width)."""
        seconds: Array = (np.array(self._stamps, dtype=np.int64) - start_ns) / NANOSECONDS
        return seconds, np.array(self._numbers).reshape(-1, self._width)

    def curves(self, start_ns: int) -> list[Curve]:
        """Every column over the seconds since a start."""
        seconds, rows = self.table(start_ns)
        return [Curve(seconds, column) for column in rows.T]
