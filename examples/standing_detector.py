# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A user's detector in one file: does the GPS move while the vehicle stands?

    hijack-detect analyze FLIGHT --detector examples/standing_detector.py:StandingDetector
    python examples/standing_detector.py
    ros2 run hijack_detect all --ros-args -p fusion:further_detectors:=standing

The same class runs offline in `analyze`, without ROS, and in a node.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import ClassVar

from hijack_detect.detectors.persistence import Persistence
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.samples import NANOSECONDS, FixSample, ImuSample


@dataclass(frozen=True)
class StandingParameters(Parameters):
    """Parameters of the detector: each is a ROS parameter with its unit, bounds and meaning."""

    moved_m: float = param(
        15.0,
        "ALARM from this distance to where it came to rest.",
        source="chosen, not swept: beyond the wander of a receiver that stands",
        unit="m",
        low=1.0,
        high=1000.0,
    )
    quiet: float = param(
        0.3,
        "It stands if the specific force has varied by less than this; motors vary it by more.",
        source="chosen, not swept",
        unit="m/s²",
        low=0.01,
        high=10.0,
    )
    settle_s: float = param(
        5.0,
        "It stands once it has been quiet for this long.",
        source="chosen, not swept",
        unit="s",
        low=1.0,
        high=60.0,
    )
    persist_s: float = param(
        1.0,
        "ALARM once it has been that far for this long.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=60.0,
    )


class StandingDetector:
    """Distance from the point of rest, against the hypothesis that the GPS moves by itself."""

    NAME = "standing"
    PARAMETERS = StandingParameters
    ASKS = "does the GPS move while the vehicle stands?"
    FIGURES: ClassVar = {"distance": "from where it came to rest, m"}

    def __init__(self, parameters: StandingParameters) -> None:
        """Begin without samples."""
        self._parameters = parameters
        # Samples come in order of stamp; how long to wait for a silent input, s.
        self.inputs = {"imu": 3.0, "fix": 3.0}
        self._forces: deque[tuple[int, float]] = deque()
        self._rest: LocalFrame | None = None
        self._far = Persistence(parameters.persist_s)

    def update(self, name: str, sample: ImuSample | FixSample) -> Verdict | None:
        """Take the next sample in order of stamp; a verdict at each fix, and none in between."""
        if isinstance(sample, ImuSample):
            self._forces.append((sample.stamp_ns, math.hypot(*sample.specific_force)))
            while sample.stamp_ns - self._forces[0][0] > self._parameters.settle_s * NANOSECONDS:
                self._forces.popleft()
            return None
        return self._judge(sample)

    def _judge(self, fix: FixSample) -> Verdict:
        if not self._forces or not fix.has_fix:
            what = "no IMU yet" if not self._forces else "the receiver has no fix"
            return self._verdict(fix, State.NOT_READY, 0.0, what)
        forces = [force for _, force in self._forces]
        seconds = (fix.stamp_ns - self._forces[0][0]) / NANOSECONDS
        varied = max(forces) - min(forces)
        if varied > self._parameters.quiet or seconds < 0.9 * self._parameters.settle_s:
            self._rest = None
            self._far.reset()
            why = f"it does not stand: the specific force varied by {varied:.2f} m/s²"
            return self._verdict(fix, State.NOT_OBSERVABLE, 0.0, why)
        if self._rest is None:
            self._rest = LocalFrame(fix)
        moved_m = math.hypot(*self._rest.enu(fix)[:2])
        state = self._far.state(fix.stamp_ns, moved_m >= self._parameters.moved_m)
        return self._verdict(fix, state, moved_m, f"standing, the GPS is {moved_m:.1f} m off")

    def _verdict(self, fix: FixSample, state: State, moved_m: float, reason: str) -> Verdict:
        limit = self._parameters.moved_m
        return Verdict(
            self.NAME, fix.stamp_ns, state, moved_m, limit, reason, {"distance": moved_m}
        )


if __name__ == "__main__":
    # Imported here, since an analysis does without ROS.
    from hijack_detect.nodes.detector_node import run_detector

    run_detector(StandingDetector)
