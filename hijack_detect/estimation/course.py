# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""GPS angle: the direction of motion over ground from successive fixes (Feng 2018, Eq. 1)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.samples import NANOSECONDS, CourseSample, FixSample, Vector3
from hijack_detect.streams.silence import SENSOR_PATIENCE_S


@dataclass(frozen=True)
class CourseParameters(Parameters):
    """Parameters of the GPS angle."""

    min_speed: float = param(
        2.0,
        "Below this speed over ground the course is not observable: position noise of "
        "5 cm over 0.2 s is 0.35 m/s across the track. Raise for noisy receivers.",
        source="physics: 0.35 m/s across 2 m/s is 10°",
        basic=True,
        unit="m/s",
        low=0.0,
        high=50.0,
    )
    max_gap_s: float = param(
        2.0,
        "Two fixes further apart than this give no course. Raise for receivers slower than 1 Hz.",
        source="chosen: the silence that counts as an outage of an input (2 s)",
        unit="s",
        low=0.1,
        high=60.0,
    )


class CourseEstimator:
    """Course over ground at every fix.

    Eq. 1 of the paper is `atan2(ΔP_x, ΔP_y)`, clockwise from North; the published case table
    loses South and West. Here x is East and y is North in a tangent plane at the previous fix,
    and the result is counter-clockwise from East (REP-103); `gps_angle` is the paper's sense.
    """

    inputs: Mapping[str, float] = {"fix": SENSOR_PATIENCE_S}

    PARAMETERS = CourseParameters

    def __init__(self, parameters: CourseParameters) -> None:
        """Start without a previous fix."""
        self._parameters = parameters
        self._previous: FixSample | None = None
        self.speed = 0.0
        """Speed over ground between the last two fixes, m/s."""

    def update(self, name: str, fix: FixSample) -> CourseSample:
        """Course from the previous fix to this one; not observable when slow or repeated."""
        previous, self._previous = self._previous, fix if fix.has_fix else None
        unknown = CourseSample(fix.stamp_ns, 0.0, 0.0)
        self.speed = 0.0
        if previous is None or not fix.has_fix:
            return unknown
        dt = (fix.stamp_ns - previous.stamp_ns) / NANOSECONDS
        east, north, _ = displacement(previous, fix)
        if dt > self._parameters.max_gap_s:
            return unknown
        self.speed = math.hypot(east, north) / dt
        if self.speed == 0.0 or self.speed < self._parameters.min_speed:
            return unknown
        half = 0.5 * math.atan2(north, east)
        return CourseSample(fix.stamp_ns, math.sin(half), math.cos(half))


def displacement(start: FixSample, end: FixSample) -> Vector3:
    """East, north, up from one fix to another in the tangent plane at the first, metres."""
    return LocalFrame(start).enu(end)


def gps_angle(course: CourseSample) -> float:
    """The paper's φ of Eq. 1: radians clockwise from North, within [0, 2π)."""
    angle = (math.pi / 2 - course.angle) % math.tau
    return 0.0 if angle == math.tau else angle
