# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Memory of a piece of the flight, no longer than a replay needs it."""

from __future__ import annotations

from collections import deque
from typing import Generic, TypeVar

from hijack_detect.spoofing.plane import TangentPlane, moved
from hijack_detect.streams.samples import FixSample, Vector3, VelocitySample

S = TypeVar("S", FixSample, VelocitySample)


class History(Generic[S]):
    """True samples from one time to another, in stamp order, forgotten once they were replayed.

    It holds at most the samples between the start of the piece and the onset of its replay, plus
    one on either side: the replay moves on as fast as the flight does.
    """

    def __init__(self, from_ns: int, until_ns: int | None) -> None:
        """Record the piece from `from_ns` until `until_ns` (None: to the flight's end)."""
        self._from_ns = from_ns
        self._until_ns = until_ns
        self._samples: deque[S] = deque()

    def __len__(self) -> int:
        """Return the number of samples held."""
        return len(self._samples)

    def add(self, sample: S) -> None:
        """Record the sample if the replay can need it."""
        held = self._samples
        if held and sample.stamp_ns < held[-1].stamp_ns:
            return
        if held and self._until_ns is not None and held[-1].stamp_ns >= self._until_ns:
            return
        held.append(sample)
        self._forget_before(self._from_ns)

    def around(self, stamp_ns: int) -> tuple[S, S, float] | None:
        """Return the two samples around a time and its place between them, 0 to 1.

        Outside the recorded piece the nearest sample stands for both. None when nothing was
        recorded. What lies before the time is forgotten: ask in order of time.
        """
        self._forget_before(stamp_ns)
        held = self._samples
        if not held:
            return None
        if len(held) == 1 or stamp_ns <= held[0].stamp_ns:
            return held[0], held[0], 0.0
        span = held[1].stamp_ns - held[0].stamp_ns
        return held[0], held[1], (stamp_ns - held[0].stamp_ns) / span

    def _forget_before(self, stamp_ns: int) -> None:
        """Keep one sample at or before the time."""
        while len(self._samples) > 1 and self._samples[1].stamp_ns <= stamp_ns:
            self._samples.popleft()


def fix_between(first: FixSample, last: FixSample, part: float) -> FixSample:
    """Interpolate position linearly in the tangent plane of the first fix; stamp of the first."""
    if part == 0.0:
        return first
    plane = TangentPlane(first)
    east, north, up = plane.enu(last)
    place = plane.geodetic((part * east, part * north, part * up))
    return moved(first, place, first.altitude_m + part * (last.altitude_m - first.altitude_m))


def velocity_between(first: VelocitySample, last: VelocitySample, part: float) -> Vector3:
    """Interpolate velocity linearly, m/s in ENU."""
    (e0, n0, u0), (e1, n1, u1) = first.velocity, last.velocity
    return (e0 + part * (e1 - e0), n0 + part * (n1 - n0), u0 + part * (u1 - u0))
