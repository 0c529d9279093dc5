# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The figures of a detector's verdicts over a flight, kept as plain numbers."""

from __future__ import annotations

import math
from array import array

import numpy as np

from hijack_detect.analysis.report.curve import Curve
from hijack_detect.detectors.verdict import JUDGED, Verdict
from hijack_detect.streams.samples import NANOSECONDS

MARGIN, SCORE, THRESHOLD = "margin", "score", "threshold"
"""What every verdict has, beside its values."""


class Trace:
    """Every number of each verdict, to seven digits: a verdict itself takes ten times as much."""

    def __init__(self) -> None:
        """Start empty."""
        self._stamps = array("q")
        self._columns: dict[str, array[float]] = {}

    def add(self, verdict: Verdict) -> None:
        """Take the next verdict; where it could not tell, its numbers are NaN."""
        told = verdict.state in JUDGED
        numbers = {
            **verdict.values,
            MARGIN: verdict.margin,
            SCORE: verdict.score,
            THRESHOLD: verdict.threshold,
        }
        for name in numbers.keys() - self._columns.keys():
            self._columns[name] = array("f", [math.nan]) * len(self._stamps)
        for name, column in self._columns.items():
            column.append(numbers.get(name, math.nan) if told else math.nan)
        self._stamps.append(verdict.stamp_ns)

    def curve(self, name: str, start_ns: int) -> Curve:
        """A number over time, from the start of the flight; NaN throughout if none has it."""
        time_s = (np.array(self._stamps, dtype=np.int64) - start_ns) / NANOSECONDS
        column = self._columns.get(name)
        return Curve(
            time_s,
            np.full(len(time_s), math.nan) if column is None else np.array(column, dtype=float),
        )
