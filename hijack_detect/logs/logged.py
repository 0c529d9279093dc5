# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a log is read into."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from hijack_detect.streams.messages import claimed
from hijack_detect.streams.samples import FixSample, Quaternion, Sample

ATTITUDE = "/autopilot/attitude"
"""Topic of the autopilot's own estimate: to compare with, never an input."""


class Logged(NamedTuple):
    """One reading: an input and its sample, or ATTITUDE and a rotation from FLU to ENU."""

    name: str
    stamp_ns: int
    value: Sample | Quaternion


def fix_sample(
    stamp_ns: int,
    place: Iterable[float],
    accuracy_m: float,
    *,
    has_fix: bool,
    vertical_accuracy_m: float = math.nan,
) -> FixSample:
    """A fix at latitude, longitude (degrees) and height (m); its accuracies where they are any."""
    if not has_fix:
        return FixSample(stamp_ns, 0.0, 0.0, 0.0, has_fix=False)
    latitude, longitude, height = map(float, place)
    return FixSample(
        stamp_ns,
        latitude,
        longitude,
        height,
        accuracy_m=claimed(accuracy_m),
        vertical_accuracy_m=claimed(vertical_accuracy_m),
    )


@dataclass(frozen=True)
class Selection:
    """Which of several sensors of a kind to take, counted from 0.

    Attributes:
        imu: Number of the IMU.
        gps: Number of the GPS.
        namespace: Of a bag, only topics in this namespace; empty for all.
    """

    imu: int = 0
    gps: int = 0
    namespace: str = ""


@dataclass
class Notes:
    """Remarks on an import, and counts of what it skipped.

    Attributes:
        remarks: One sentence each.
        skipped: Number of readings left out, by reason.
    """

    remarks: list[str] = field(default_factory=list)
    skipped: Counter[str] = field(default_factory=Counter)

    def lines(self) -> list[str]:
        """All of it, a line each."""
        return [*self.remarks, *(f"{what} ({count})" for what, count in self.skipped.items())]


Read = Callable[[Path, Selection, Notes], Iterator[Logged]]
"""Reads a log. Stamps are nanoseconds of UTC where the log knows it, else since it began.

Raises BagError if the log cannot be read or lacks what every flight needs.
"""
