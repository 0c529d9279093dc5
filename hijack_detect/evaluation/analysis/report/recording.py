"""What the figures show: figures of the verdicts, angles, tracks and what the receiver said."""

from __future__ import annotations

import math
from array import array
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pymap3d

from hijack_detect.bags.reader import BagReader
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.estimation.course import gps_angle
from hijack_detect.estimation.rotation import heading
from hijack_detect.evaluation.analysis.report.curve import Array, Curve
from hijack_detect.evaluation.analysis.report.trace import Trace
from hijack_detect.evaluation.ground_truth.truth import truth_track, valid_fixes
from hijack_detect.streams.samples import (
    NANOSECONDS,
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
        no_fix: Times of messages that say that there is no fix, s.
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

    def said(self, detector: str, name: str) -> Curve:
        """A number of a detector's verdicts, NaN where it could not tell; see `Trace`."""
        trace = self.traces.get(detector, Trace())
        return trace.curve(name, self.start_ns)


class Recorder:
    """Listens to an analysis: give `take` as its `on_sample`, and `hear` as its `on_output`."""

    def __init__(self) -> None:
        """Start empty."""
        self.fixes: list[FixSample] = []
        self.satellites: list[SatelliteSample] = []
        self.speeds = array("d")
        self.speed_stamps = array("q")
        self.angles = array("d")
        """Yaw and course in turn."""
        self.traces: dict[str, Trace] = defaultdict(Trace)
        self.angle_stamps = array("q")
        self._yaw = math.nan

    def take(self, sample: Sample) -> None:
        """Keep what the GPS reports."""
        if isinstance(sample, FixSample):
            self.fixes.append(sample)
        elif isinstance(sample, SatelliteSample):
            self.satellites.append(sample)
        elif isinstance(sample, VelocitySample):
            self.speed_stamps.append(sample.stamp_ns)
            self.speeds.append(math.hypot(*sample.velocity[:2]))

    def hear(self, part: str, output: Any) -> None:
        """Keep the numbers of verdicts, and the yaw at each course: drawn at the rate of fixes."""
        if isinstance(output, Verdict):
            self.traces[part].add(output)
        elif isinstance(output, AttitudeSample):
            turn = output.orientation
            self._yaw = math.nan if turn is None else _bearing(heading(turn))
        elif isinstance(output, CourseSample):
            course = math.degrees(gps_angle(output)) if output.observable else math.nan
            self.angle_stamps.append(output.stamp_ns)
            self.angles.extend((self._yaw, course))


def recording(reader: BagReader, recorder: Recorder, *, injected: bool) -> Recording:
    """Put together what was heard in an analysis, and what else the bag says of the receiver.

    Args:
        reader: The bag.
        recorder: What listened to the analysis of it.
        injected: Whether an attack was injected; then the bag's own fixes are the true track.

    Raises:
        BagError: The bag is damaged.
    """
    start_ns = reader.start_ns
    reported = [fix for fix in recorder.fixes if fix.has_fix]
    if injected:
        truth: Sequence[FixSample] = valid_fixes(reader, reader.inputs().fix)
    else:
        known = truth_track(reader)
        truth = () if known is None else known.fixes
    origin = (*truth, *reported)[:1]
    stamps = [fix.stamp_ns for fix in recorder.fixes]
    angle_s = _seconds(recorder.angle_stamps, start_ns)
    angles = np.array(recorder.angles).reshape(-1, 2)
    return Recording(
        reported=_track(reported, origin, start_ns),
        true=_track(truth, origin, start_ns) if truth else None,
        yaw=Curve(angle_s, angles[:, 0]),
        course=Curve(angle_s, angles[:, 1]),
        speed=Curve(_seconds(recorder.speed_stamps, start_ns), np.array(recorder.speeds)),
        interval=Curve(_seconds(stamps[1:], start_ns), np.diff(_seconds(stamps, start_ns))),
        no_fix=_seconds([fix.stamp_ns for fix in recorder.fixes if not fix.has_fix], start_ns),
        sigma=_curve([(f.stamp_ns, f.accuracy_m) for f in reported if f.accuracy_m], start_ns),
        satellites=_curve([(one.stamp_ns, one.count) for one in recorder.satellites], start_ns),
        traces=dict(recorder.traces),
        start_ns=start_ns,
    )


def _track(fixes: Sequence[FixSample], origin: Sequence[FixSample], start_ns: int) -> Track:
    """Fixes as metres East and North of the origin, which is empty if there are no fixes."""
    places = np.array([(f.latitude_deg, f.longitude_deg, f.altitude_m) for f in fixes])
    time_s = _seconds([fix.stamp_ns for fix in fixes], start_ns)
    if not len(fixes):
        return Track(time_s, np.array([]), np.array([]))
    first = origin[0]
    east, north, _ = pymap3d.geodetic2enu(
        *places.T, first.latitude_deg, first.longitude_deg, first.altitude_m
    )
    return Track(time_s, np.asarray(east), np.asarray(north))


def _curve(pairs: Sequence[tuple[int, float]], start_ns: int) -> Curve:
    stamps = [stamp_ns for stamp_ns, _ in pairs]
    return Curve(_seconds(stamps, start_ns), np.array([value for _, value in pairs], dtype=float))


def _seconds(stamps: Sequence[int], start_ns: int) -> Array:
    seconds: Array = (np.array(stamps, dtype=np.int64) - start_ns) / NANOSECONDS
    return seconds


def _bearing(angle: float) -> float:
    """Degrees clockwise from North of an angle counter-clockwise from East (rad)."""
    return (90.0 - math.degrees(angle)) % 360.0
