# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attitudes that wait for the interval between two GPS velocities to which they belong."""

from __future__ import annotations

from collections import deque
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hijack_detect.estimation.rotation import Array, matrices
from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample

Stamps: TypeAlias = npt.NDArray[np.int64]
Known: TypeAlias = npt.NDArray[np.bool_]

HOLE_NS = 3 * NANOSECONDS // 10
"""Longest time between two attitudes of an interval whose mean force means something: six samples
of the slowest usable IMU."""


class AttitudeWindow:
    """The attitudes of the last seconds, given out interval by interval."""

    def __init__(self, kept_s: float) -> None:
        """Start empty.

        Args:
            kept_s: Attitudes older than this have no GPS velocity left to belong to, seconds.
        """
        self._kept_ns = round(kept_s * NANOSECONDS)
        self._attitudes: deque[AttitudeSample] = deque()

    def add(self, sample: AttitudeSample) -> None:
        """Take an attitude, in order of stamp."""
        self._attitudes.append(sample)
        while self._attitudes[0].stamp_ns < sample.stamp_ns - self._kept_ns:
            self._attitudes.popleft()

    def take(self, start_ns: int, end_ns: int) -> list[AttitudeSample]:
        """Attitudes over (start, end], forgetting them and older ones; empty if there is a hole."""
        taken = []
        while self._attitudes and self._attitudes[0].stamp_ns <= end_ns:
            sample = self._attitudes.popleft()
            if sample.stamp_ns > start_ns:
                taken.append(sample)
        stamps = [start_ns, *(sample.stamp_ns for sample in taken), end_ns]
        holes = any(after - before > HOLE_NS for before, after in pairwise(stamps))
        return [] if holes else taken


class AttitudeMeans:
    """Means over intervals of the last seconds, many of which may overlap."""

    def __init__(self, kept_s: float) -> None:
        """Start empty.

        Args:
            kept_s: Attitudes older than this are forgotten, seconds.
        """
        self._kept_ns = round(kept_s * NANOSECONDS)
        self._waiting: deque[AttitudeSample] = deque()
        self._stamps = np.empty(0, dtype=np.int64)
        self._rows = np.empty((0, 13))
        """Specific force, rotation matrix (zero where it is unknown), and whether it is known."""

    def __len__(self) -> int:
        """Number of attitudes that are kept."""
        return len(self._stamps) + len(self._waiting)

    def add(self, sample: AttitudeSample) -> None:
        """Take an attitude, in order of stamp."""
        self._waiting.append(sample)
        while self._waiting[0].stamp_ns < sample.stamp_ns - self._kept_ns:
            self._waiting.popleft()

    def _gather(self) -> None:
        if not self._waiting:
            return
        waiting, self._waiting = self._waiting, deque()
        none = (0.0, 0.0, 0.0, 0.0)
        known = np.array([[one.orientation is not None] for one in waiting], dtype=np.float64)
        turns = matrices(np.array([one.orientation or none for one in waiting])).reshape(-1, 9)
        forces = np.array([one.specific_force for one in waiting])
        stamps = np.array([one.stamp_ns for one in waiting], dtype=np.int64)
        oldest = int(np.searchsorted(self._stamps, stamps[-1] - self._kept_ns))
        self._stamps = np.concatenate([self._stamps[oldest:], stamps])
        self._rows = np.concatenate(
            [self._rows[oldest:], np.concatenate([forces, turns * known, known], axis=1)]
        )

    def over(self, start_ns: int, end_ns: int, back_ns: Stamps) -> tuple[Array, Array, Known]:
        """Means over (start, end], and over the same interval earlier.

        Args:
            start_ns: Start of the interval.
            end_ns: Its end.
            back_ns: How much earlier each interval is, whole numbers of shape (n,).

        Returns:
            Rotation from FLU to ENU, shape (n, 3, 3); specific force, FLU, m/s², shape (n, 3); and
            whether there is an orientation and no hole of more than HOLE_NS, shape (n,).
        """
        self._gather()
        starts, ends = start_ns - back_ns, end_ns - back_ns
        stamps = self._stamps
        first, after = (np.searchsorted(stamps, one, "right") for one in (starts, ends))
        whole: Known = after > first
        if not whole.any():
            return np.zeros((len(whole), 3, 3)), np.zeros((len(whole), 3)), whole
        holes = np.concatenate([[0], np.cumsum(np.diff(stamps) > HOLE_NS)])
        within = np.where(whole, first, 0), np.where(whole, after - 1, 0)
        whole &= holes[within[0]] == holes[within[1]]
        whole &= (stamps[within[0]] - starts <= HOLE_NS) & (ends - stamps[within[1]] <= HOLE_NS)
        # One by one: np.add.reduceat adds in another order, and Feng's method is kept to the bit.
        bounds = zip(first.tolist(), after.tolist(), strict=True)
        sums = np.array([self._rows[one:end].sum(axis=0) for one, end in bounds])
        whole &= sums[:, 12] > 0.0
        known = np.where(whole, sums[:, 12], 1.0)
        turns: Array = sums[:, 3:12] / known[:, None]
        forces: Array = sums[:, :3] / np.maximum(after - first, 1)[:, None]
        return turns.reshape(-1, 3, 3), forces, whole
