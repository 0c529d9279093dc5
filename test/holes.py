# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Holes in a flight: a link that drops out, a receiver that hangs, an IMU that stops."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import outputs_of
from hijack_detect.streams.samples import NANOSECONDS, Sample

GPS = frozenset({"fix", "velocity", "satellites"})
"""What a receiver that hangs leaves out."""
IMU = frozenset({"imu"})
LOST = {
    "all": None,
    "gps": GPS,
    "imu": IMU,
}
"""What is lost, by the name of the kind of hole; None is every input."""

Flight = Sequence[tuple[str, Sample]]
"""Input name and sample, in order of arrival."""


@dataclass(frozen=True)
class Hole:
    """Samples of some inputs that never came.

    Attributes:
        start_s: Begin, seconds after the first sample of the flight.
        length_s: Seconds.
        lost: One of LOST.
    """

    start_s: float
    length_s: float
    lost: str = "all"

    def __str__(self) -> str:
        """Return all of it in one word, as the name of a test."""
        return f"{self.lost}-{self.start_s:g}+{self.length_s:g}"


def with_hole(flight: Flight, hole: Hole) -> Iterator[tuple[str, Sample]]:
    """The flight without the samples whose stamps lie in the hole."""
    start_ns = flight[0][1].stamp_ns + round(hole.start_s * NANOSECONDS)
    end_ns = start_ns + round(hole.length_s * NANOSECONDS)
    names = LOST[hole.lost]
    for name, sample in flight:
        inside = start_ns <= sample.stamp_ns < end_ns
        if not inside or (names is not None and name not in names):
            yield name, sample


def run_holes(
    flight: Flight,
    holes: Iterable[Hole],
    parameters: MonitorParameters,
    *,
    follow_s: float = 45.0,
) -> Iterator[tuple[Hole, list[tuple[str, Any]]]]:
    """Run every hole, at the cost of little more than what follows it.

    The monitor runs over the flight once, and is copied a second before a hole begins. The copy
    goes on with the holed flight until `follow_s` after the hole's end.

    Yields:
        Each hole, in order of its start, with part and output of all that was said from a second
        before it on.
    """
    start_ns = flight[0][1].stamp_ns
    monitor, at = Monitor(parameters), 0
    for hole in sorted(holes, key=lambda one: one.start_s):
        from_ns = start_ns + round((hole.start_s - 1.0) * NANOSECONDS)
        end_ns = start_ns + round((hole.start_s + hole.length_s + follow_s) * NANOSECONDS)
        before = at
        while at < len(flight) and flight[at][1].stamp_ns < from_ns:
            at += 1
        for _ in outputs_of(flight[before:at], monitor):
            pass
        rest = [one for one in flight[at:] if one[1].stamp_ns < end_ns]
        # The first sample is only there for `with_hole` to count from.
        holed = list(with_hole([flight[0], *rest], hole))[1:]
        yield hole, list(outputs_of(holed, copy.deepcopy(monitor)))
