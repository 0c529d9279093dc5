# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Quantities over time, as the figures draw them."""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hijack_detect.detectors.verdict import JUDGED, Verdict
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
        """Start empty, for rows of a fixed length."""
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


MOST_POINTS = 3000
"""Points of a curve: more than a screen has pixels."""


def thinned(curve: Curve, most: int = MOST_POINTS) -> Curve:
    """A curve with fewer points: of each bin its smallest and largest value, and one gap."""
    count = len(curve.time_s)
    if count <= most:
        return curve
    kept: list[int] = []
    for part in np.array_split(np.arange(count), most // 3):
        values = curve.value[part]
        gaps = np.isnan(values)
        chosen = {int(part[gaps][0])} if gaps.any() else set()
        if not gaps.all():
            chosen |= {int(part[np.nanargmin(values)]), int(part[np.nanargmax(values)])}
        kept += sorted(chosen)
    return Curve(curve.time_s[kept], curve.value[kept])


def lonely(curve: Curve) -> Curve:
    """The points between two gaps, which a line does not show."""
    gap = np.concatenate([[True], np.isnan(curve.value), [True]])
    alone = ~gap[1:-1] & gap[:-2] & gap[2:]
    return Curve(curve.time_s[alone], curve.value[alone])


def emptiest_direction(angles: Array) -> float:
    """Best cut of a circle: the middle of the widest arc without any angle, degrees.

    Args:
        angles: Degrees within [0, 360), NaN where unknown.
    """
    known = np.sort(angles[~np.isnan(angles)])
    if not len(known):
        return 360.0
    gaps = np.diff(known, append=known[0] + 360.0)
    widest = int(np.argmax(gaps))
    return float(known[widest] + gaps[widest] / 2.0) % 360.0 or 360.0


def cut_at(curve: Curve, cut: float) -> Curve:
    """Angles within [cut - 360, cut) degrees, with a gap wherever the curve crosses the cut."""
    value = (curve.value - cut) % 360.0 + cut - 360.0
    jumps = np.flatnonzero(np.abs(np.diff(value)) > 180.0) + 1
    return Curve(
        np.insert(curve.time_s, jumps, curve.time_s[jumps]), np.insert(value, jumps, np.nan)
    )


MARGIN, SCORE, THRESHOLD = "margin", "score", "threshold"
"""Numbers of every verdict, beside its values."""


class Trace:
    """Every number of each verdict, to seven digits: a verdict itself takes ten times as much."""

    def __init__(self) -> None:
        """Start empty."""
        self._stamps = array("q")
        self._columns: dict[str, array[float]] = {}

    def add(self, verdict: Verdict) -> None:
        """Take the next verdict; where it could not tell, its numbers are NaN."""
        judged = verdict.state in JUDGED
        numbers = {
            **verdict.values,
            MARGIN: verdict.margin,
            SCORE: verdict.score,
            THRESHOLD: verdict.threshold,
        }
        for name in numbers.keys() - self._columns.keys():
            self._columns[name] = array("f", [math.nan]) * len(self._stamps)
        for name, column in self._columns.items():
            column.append(numbers.get(name, math.nan) if judged else math.nan)
        self._stamps.append(verdict.stamp_ns)

    def curve(self, name: str, start_ns: int) -> Curve:
        """A number over time, from the start of the flight; NaN throughout if none has it."""
        time_s = (np.array(self._stamps, dtype=np.int64) - start_ns) / NANOSECONDS
        column = self._columns.get(name)
        return Curve(
            time_s,
            np.full(len(time_s), math.nan) if column is None else np.array(column, dtype=float),
        )
