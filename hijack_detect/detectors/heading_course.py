# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Course over ground against the nose, whose heading does not come from the GPS."""

from __future__ import annotations

import math
from collections import deque

from hijack_detect.detectors.follow import FollowsCourse
from hijack_detect.detectors.heading_parameters import HeadingParameters
from hijack_detect.detectors.window import Unwrap, WindowSums
from hijack_detect.estimation.motion import GpsMotion, Motion
from hijack_detect.streams.samples import NANOSECONDS, FixSample, VelocitySample

WINDOW_S, BEFORE_S = 2.0, 10.0
"""The course is judged over the former against the latter, the time before."""
FOLLOW_SIGMA_DEG, FOLLOW_OFFSET_DEG = 8.0, 45.0
"""What the nose may be off the course in that time: standard deviation and mean."""
KEPT_NS = 2 * NANOSECONDS
"""Noses older than this belong to no GPS sample that is still to come."""
NO_VELOCITY_S = MAX_GAP_S = 2.0
"""Without a GPS velocity for this long the course comes from the fixes, if no two of them are as
far apart."""


class NoseCourse:
    """How far the course has turned from the nose since the nose last followed it."""

    def __init__(self, parameters: HeadingParameters) -> None:
        """Start without history."""
        self._min_speed = parameters.min_speed
        self._lag_ns = round(parameters.gps_lag_s * NANOSECONDS)
        self._noses: deque[tuple[int, float]] = deque()
        self._follows = FollowsCourse(WINDOW_S, BEFORE_S, FOLLOW_SIGMA_DEG, FOLLOW_OFFSET_DEG)
        self._window = WindowSums(round(WINDOW_S * NANOSECONDS), 1)
        self._unwrap = Unwrap()
        self._gps = GpsMotion(NO_VELOCITY_S, MAX_GAP_S)
        self._newest_ns: int | None = None
        self.difference: float | None = None
        """Newest course minus nose, rad, wrapped; None while there is no course."""

    def turned(self, stamp_ns: int, nose: float) -> None:
        """Note the heading of the nose, rad."""
        self._noses.append((stamp_ns, nose))
        while self._noses[0][0] < stamp_ns - KEPT_NS:
            self._noses.popleft()

    def velocity(self, sample: VelocitySample) -> None:
        """Take a GPS velocity."""
        self._moved(sample.stamp_ns, self._gps.velocity(sample))

    def fix(self, fix: FixSample) -> None:
        """Take a fix; its course counts where there is no GPS velocity."""
        motion = self._gps.fix(fix)
        if not self._gps.measured(fix.stamp_ns):
            self._moved(fix.stamp_ns, motion)

    def _moved(self, stamp_ns: int, motion: Motion | None) -> None:
        nose = self._nose(stamp_ns - self._lag_ns)
        east, north = (0.0, 0.0) if motion is None else motion.velocity[:2].tolist()
        if nose is None or math.hypot(east, north) < self._min_speed:
            self.interrupt()
            return
        self._newest_ns = stamp_ns
        self.difference = math.remainder(math.atan2(north, east) - nose, math.tau)
        continuous = self._unwrap(self.difference)
        self._window.add(stamp_ns, (continuous,))
        self._follows.add(stamp_ns, continuous)

    def _nose(self, stamp_ns: int) -> float | None:
        found = None
        while self._noses and self._noses[0][0] <= stamp_ns:
            found = self._noses.popleft()
        if found is not None:
            self._noses.appendleft(found)
        return None if found is None else found[1]

    def interrupt(self) -> None:
        """The course was lost: begin afresh."""
        self._follows.interrupt()
        self._window.clear()
        self.difference = None

    def turn(self, stamp_ns: int) -> float:
        """Turn of the course from the nose, rad; 0 where the nose did not follow it."""
        if self._newest_ns is None or stamp_ns - self._newest_ns > NO_VELOCITY_S * NANOSECONDS:
            return 0.0
        if not len(self._window) or self._follows.problem():
            return 0.0
        return math.remainder(self._window.mean(0) - self._follows.offset, math.tau)
