# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Data of the figures: values of the verdicts, angles, tracks and the receiver's claims."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pymap3d

from hijack_detect.analysis.report.curves import Array, Curve, Rows, Trace
from hijack_detect.bags.reader import BagReader
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.estimation.course import gps_angle
from hijack_detect.estimation.rotation import heading
from hijack_detect.replay.truth import truth_track, valid_fixes
from hijack_detect.streams.samples import (
    AttitudeSample,
    CourseSample,
    FixSample,
    Sample,
    SatelliteSample,
    VelocitySample,
)


@dataclass(frozen=True)
class Track:
    """Positions over time: seconds from the bag's first message, East and North in metres."""

    time_s: Array
    east_m: Array
    north_m: Array


@dataclass(frozen=True)
class Recording:
    """Everything that is drawn. Angles are degrees clockwise from North, within [0, 360).

    Attributes:
        reported: The track that the GPS reports, spoofed or not.
        true: The track that was flown, if that is known.
        yaw: Direction of the nose.
        course: Direction of motion over ground.
        speed: Reported speed over ground, m/s.
        interval: Time since the fix before, s.
        no_fix: Times of messages without a fix, s.
        sigma: Reported horizontal standard deviation, m; empty if the receiver gives none.
        satellites: Number of satellites; empty if the bag has none.
        traces: Numbers of the verdicts of each detector.
        start_ns: Log time of the bag's first message.
    """

    reported: Track
    true: Track | None
    yaw: Curve
    course: Curve
    speed: Curve
    interval: Curve
    no_fix: Array
    sigma: Curve
    satellites: Curve
    traces: Mapping[str, Trace]
    start_ns: int

    def curve(self, detector: str, name: str) -> Curve:
        """A number of a detector's verdicts, NaN where it could not tell; see `Trace`."""
        trace = self.traces.get(detector, Trace())
        return trace.curve(name, self.start_ns)


class Recorder:
    """Recorder of an analysis: `take` is its `on_sample`, `take_output` its `on_output`."""

    def __init__(self) -> None:
        """Start empty."""
        self.fixes = Rows(5)
        """Latitude and longitude (°), altitude (m), whether it is a fix, and accuracy (m)."""
        self.satellites = Rows(1)
        self.speeds = Rows(1)
        self.angles = Rows(2)
        """Yaw and course."""
        self.traces: dict[str, Trace] = defaultdict(Trace)
        self._yaw = math.nan

    def take(self, sample: Sample) -> None:
        """Keep what the GPS reports."""
        if isinstance(sample, FixSample):
            place = (sample.latitude_deg, sample.longitude_deg, sample.altitude_m)
            self.fixes.add(sample.stamp_ns, *place, sample.has_fix, sample.accuracy_m or 0.0)
        elif isinstance(sample, SatelliteSample):
            self.satellites.add(sample.stamp_ns, sample.count)
        elif isinstance(sample, VelocitySample):
            self.speeds.add(sample.stamp_ns, math.hypot(*sample.velocity[:2]))

    def take_output(self, part: str, output: Any) -> None:
        """Keep the numbers of verdicts, and the yaw at each course: drawn at the rate of fixes."""
        if isinstance(output, Verdict):
            self.traces[part].add(output)
        elif isinstance(output, AttitudeSample):
            turn = output.orientation
            self._yaw = math.nan if turn is None else _bearing(heading(turn))
        elif isinstance(output, CourseSample):
            course = math.degrees(gps_angle(output)) if output.observable else math.nan
            self.angles.add(output.stamp_ns, self._yaw, course)


def recording(reader: BagReader, recorder: Recorder, *, injected: bool) -> Recording:
    """Put together what was recorded of an analysis, and what the bag has of the receiver.

    Args:
        reader: The bag.
        recorder: What listened to the analysis of it.
        injected: Whether an attack was injected; then the bag's own fixes are the true track.

    Raises:
        BagError: The bag is damaged.
    """
    start_ns = reader.start_ns
    if injected:
        truth: Sequence[FixSample] = valid_fixes(reader, reader.inputs().fix)
    else:
        known = truth_track(reader)
        truth = () if known is None else known.fixes
    flown = Rows(3)
    for fix in truth:
        flown.add(fix.stamp_ns, fix.latitude_deg, fix.longitude_deg, fix.altitude_m)
    time_s, fixes = recorder.fixes.table(start_ns)
    valid, accuracy_m = fixes[:, 3] > 0.0, fixes[:, 4]
    claimed = valid & (accuracy_m > 0.0)
    true_s, true = flown.table(start_ns)
    origin = (*true, *fixes[valid, :3])[:1]
    yaw, course = recorder.angles.curves(start_ns)
    return Recording(
        reported=_track(time_s[valid], fixes[valid, :3], origin),
        true=_track(true_s, true, origin) if truth else None,
        yaw=yaw,
        course=course,
        speed=recorder.speeds.curves(start_ns)[0],
        interval=Curve(time_s[1:], np.diff(time_s)),
        no_fix=time_s[~valid],
        sigma=Curve(time_s[claimed], accuracy_m[claimed]),
        satellites=recorder.satellites.curves(start_ns)[0],
        traces=dict(recorder.traces),
        start_ns=start_ns,
    )


def _track(time_s: Array, places: Array, origin: Sequence[Array]) -> Track:
    """Places as metres East and North of the origin, which is empty if there are none."""
    if not len(places):
        return Track(time_s, np.array([]), np.array([]))
    places, place = np.nan_to_num(places), np.nan_to_num(origin[0])  # heights not measured
    east, north, _ = pymap3d.geodetic2enu(*places.T, *place)
    return Track(time_s, np.asarray(east), np.asarray(north))


def _bearing(angle: float) -> float:
    """Degrees clockwise from North of an angle counter-clockwise from East (rad)."""
    return (90.0 - math.degrees(angle)) % 360.0
