"""IMU samples kept until the filter, which runs behind by the GPS lag, has used them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from hijack_detect.estimation.ekf import ImuBlock
from hijack_detect.estimation.rotation import Array
from hijack_detect.streams.samples import NANOSECONDS, ImuSample, Vector3


class ImuBuffer:
    """IMU samples from just before the filter's time up to the newest."""

    def __init__(self) -> None:
        """Start empty."""
        self._samples: list[ImuSample] = []

    def append(self, sample: ImuSample) -> None:
        """Add the newest sample."""
        self._samples.append(sample)

    def __len__(self) -> int:
        return len(self._samples)

    @property
    def oldest_ns(self) -> int:
        """Stamp of the oldest sample, nanoseconds."""
        return self._samples[0].stamp_ns

    @property
    def newest_ns(self) -> int:
        """Stamp of the newest sample, nanoseconds."""
        return self._samples[-1].stamp_ns

    def mean_specific_force(self) -> Vector3:
        """Mean specific force of all samples held, m/s², FLU."""
        x, y, z = np.mean([s.specific_force for s in self._samples], axis=0).tolist()
        return x, y, z

    def steps(self, start_ns: int) -> Iterator[tuple[float, Vector3]]:
        """Length (s) and mean angular velocity (rad/s) of each interval after `start_ns`."""
        previous = None
        for sample in self._samples:
            if previous is not None and sample.stamp_ns > start_ns:
                begin = max(previous.stamp_ns, start_ns)
                yield (
                    (sample.stamp_ns - begin) / NANOSECONDS,
                    mean(previous.angular_velocity, sample.angular_velocity),
                )
            previous = sample

    def take(self, start_ns: int, end_ns: int) -> ImuBlock:
        """Readings over (start_ns, end_ns], linear between samples; drops what lies before.

        `end_ns` is at most the newest stamp.
        """
        stamps = np.array([s.stamp_ns for s in self._samples], dtype=np.int64)
        readings = np.array([(*s.angular_velocity, *s.specific_force) for s in self._samples])
        inside = (stamps > start_ns) & (stamps < end_ns)
        nodes = np.concatenate(([start_ns], stamps[inside], [end_ns]))
        ends = [_at(stamps, readings, start_ns), readings[inside], _at(stamps, readings, end_ns)]
        values = np.vstack(ends)
        means = 0.5 * (values[1:] + values[:-1])
        del self._samples[: max(0, int(np.searchsorted(stamps, end_ns, side="right")) - 1)]
        return ImuBlock(np.diff(nodes) / NANOSECONDS, means[:, :3], means[:, 3:])


def mean(a: Vector3, b: Vector3) -> Vector3:
    """Mean of two vectors."""
    return (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2]))


def _at(stamps: npt.NDArray[np.int64], readings: Array, stamp_ns: int) -> Array:
    """Readings at a stamp, linear between the two samples around it, shape (1, 6)."""
    after = min(max(int(np.searchsorted(stamps, stamp_ns)), 1), len(stamps) - 1)
    if after == 0:
        return readings[:1]
    before = after - 1
    span = int(stamps[after] - stamps[before])
    weight = min(max((stamp_ns - int(stamps[before])) / span, 0.0), 1.0)
    row: Array = (1.0 - weight) * readings[before] + weight * readings[after]
    return row[None, :]
