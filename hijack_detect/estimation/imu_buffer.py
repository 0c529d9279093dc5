# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""IMU samples kept until the filter, which runs behind by the GPS lag, has used them."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from typing import TypeAlias

import numpy as np

from hijack_detect.estimation.ekf import ImuBlock
from hijack_detect.streams.samples import NANOSECONDS, ImuSample, Vector3

Reading: TypeAlias = tuple[float, float, float, float, float, float]
"""Angular velocity (rad/s) and specific force (m/s²), FLU."""


class ImuBuffer:
    """IMU samples from just before the filter's time up to the newest."""

    def __init__(self) -> None:
        """Start empty."""
        self._stamps: list[int] = []
        self._readings: list[Reading] = []

    def append(self, sample: ImuSample) -> None:
        """Add the newest sample."""
        self._stamps.append(sample.stamp_ns)
        self._readings.append((*sample.angular_velocity, *sample.specific_force))

    def __len__(self) -> int:
        return len(self._stamps)

    @property
    def oldest_ns(self) -> int:
        """Stamp of the oldest sample, nanoseconds."""
        return self._stamps[0]

    @property
    def newest_ns(self) -> int:
        """Stamp of the newest sample, nanoseconds."""
        return self._stamps[-1]

    def mean_specific_force(self) -> Vector3:
        """Mean specific force of all samples held, m/s², FLU."""
        x, y, z = np.mean([one[3:] for one in self._readings], axis=0).tolist()
        return x, y, z

    def steps(self, start_ns: int) -> Iterator[tuple[float, Vector3]]:
        """Length (s) and mean angular velocity (rad/s) of each interval after `start_ns`."""
        for k in range(max(1, bisect_right(self._stamps, start_ns)), len(self)):
            begin, end = self._stamps[k - 1], self._stamps[k]
            before, after = self._readings[k - 1], self._readings[k]
            seconds = (end - max(begin, start_ns)) / NANOSECONDS
            yield seconds, mean(before[:3], after[:3])

    def take(self, start_ns: int, end_ns: int) -> ImuBlock:
        """Readings over (start_ns, end_ns], linear between samples; drops what lies before.

        `end_ns` is at most the newest stamp.
        """
        inside = slice(bisect_right(self._stamps, start_ns), bisect_left(self._stamps, end_ns))
        nodes = np.array([start_ns, *self._stamps[inside], end_ns], dtype=np.int64)
        values = np.array([self._at(start_ns), *self._readings[inside], self._at(end_ns)])
        means = 0.5 * (values[1:] + values[:-1])
        used = max(0, bisect_right(self._stamps, end_ns) - 1)
        del self._stamps[:used], self._readings[:used]
        return ImuBlock(np.diff(nodes) / NANOSECONDS, means[:, :3], means[:, 3:])

    def _at(self, stamp_ns: int) -> tuple[float, ...]:
        """Reading at a stamp, linear between the two samples around it; the ends are held."""
        after = min(max(bisect_left(self._stamps, stamp_ns), 1), len(self) - 1)
        if after == 0:
            return self._readings[0]
        begin, end = self._stamps[after - 1], self._stamps[after]
        weight = min(max((stamp_ns - begin) / (end - begin), 0.0), 1.0)
        pairs = zip(self._readings[after - 1], self._readings[after], strict=True)
        return tuple((1.0 - weight) * one + weight * other for one, other in pairs)


def mean(a: Vector3, b: Vector3) -> Vector3:
    """Mean of two vectors."""
    return (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2]))
