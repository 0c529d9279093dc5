# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The state of the vehicle at an attack's onset, from samples strictly before it.

Using only what came before makes the attack independent of whether the fix or the velocity of
one stamp is processed first.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from hijack_detect.estimation.geodesy import TangentPlane, moved
from hijack_detect.streams.samples import NANOSECONDS, FixSample, Vector3, VelocitySample

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


MIN_COURSE_SPEED = 0.5
"""m/s; below this a vehicle has no course, and counts as standing with its course North. Chosen:
several σ of a GPS velocity."""
MAX_CARRY_S = 1.0
"""Longest time over which the last fix is carried forward to the onset. Chosen: five fixes."""
_MIN_BASELINE_NS = NANOSECONDS // 100
"""Shortest time between two fixes for a velocity. Chosen: below the period of any receiver."""
_STILL: Vector3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Onset:
    """The state of the vehicle just before an attack.

    Attributes:
        fix: Last true fix before the onset, None if there was none.
        velocity_sample: Last true velocity before the onset, None if there was none.
        velocity: m/s in ENU, reported or from the last two fixes; zero when neither is known.
        carry: ENU metres from `fix` to where the vehicle was at the onset itself.
    """

    fix: FixSample | None
    velocity_sample: VelocitySample | None
    velocity: Vector3
    carry: Vector3

    @property
    def speed(self) -> float:
        """Ground speed, m/s; 0 below MIN_COURSE_SPEED."""
        speed = math.hypot(self.velocity[0], self.velocity[1])
        return speed if speed >= MIN_COURSE_SPEED else 0.0

    @property
    def course(self) -> float:
        """Direction of motion, radians clockwise from North; 0 below MIN_COURSE_SPEED."""
        return math.atan2(self.velocity[0], self.velocity[1]) if self.speed else 0.0


def onset_at(
    start_ns: int, fixes: Sequence[FixSample], velocities: Sequence[VelocitySample]
) -> Onset:
    """Estimate the state at `start_ns` from the samples before it, oldest first.

    The reported velocity is taken unless it is older than both of the last two fixes.
    """
    earlier = [fix for fix in fixes if fix.stamp_ns < start_ns]
    reported = last_before(start_ns, velocities)
    if not earlier:
        return Onset(None, reported, _known(reported.velocity) if reported else _STILL, _STILL)
    last = earlier[-1]
    base = last_before(last.stamp_ns - _MIN_BASELINE_NS + 1, earlier)
    if reported is not None and (base is None or reported.stamp_ns >= base.stamp_ns):
        velocity = _known(reported.velocity)
    else:
        velocity = _between(base, last) if base else _STILL
    delay = min((start_ns - last.stamp_ns) / NANOSECONDS, MAX_CARRY_S)
    carry = (velocity[0] * delay, velocity[1] * delay, velocity[2] * delay)
    return Onset(last, reported, velocity, carry)


def last_before(stamp_ns: int, samples: Sequence[S]) -> S | None:
    """Return the last sample with a stamp strictly before `stamp_ns`, None if there is none."""
    for sample in reversed(samples):
        if sample.stamp_ns < stamp_ns:
            return sample
    return None


def _between(first: FixSample, last: FixSample) -> Vector3:
    """Mean velocity (m/s, ENU) between two fixes."""
    seconds = (last.stamp_ns - first.stamp_ns) / NANOSECONDS
    east, north, up = TangentPlane(first).enu(last)
    return _known((east / seconds, north / seconds, up / seconds))


def _known(velocity: Vector3) -> Vector3:
    """A velocity that is level where the vertical component was not measured."""
    east, north, up = velocity
    return (east, north, 0.0 if math.isnan(up) else up)
