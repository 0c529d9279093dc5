# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which of three headings has turned away from the other two."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

from hijack_detect.detectors.follow import FollowsCourse
from hijack_detect.detectors.window import Unwrap, WindowSums
from hijack_detect.estimation.motion import GpsMotion, Motion
from hijack_detect.streams.samples import NANOSECONDS, FixSample, VelocitySample

WINDOW_S, BEFORE_S = 2.0, 10.0
"""The course is judged over the former against the latter, the time before. Chosen, not swept."""
FOLLOW_SIGMA_DEG, FOLLOW_OFFSET_DEG = 8.0, 45.0
"""What the nose may be off the course in that time: standard deviation and mean.
Chosen, not swept."""
KEPT_NS = 2 * NANOSECONDS
"""Noses older than this belong to no GPS sample that is still to come."""
NO_VELOCITY_S = MAX_GAP_S = 2.0
"""Without a GPS velocity for this long the course comes from the fixes, if no two of them are as
far apart. Chosen, not swept."""


class NoseCourse:
    """How far the course has turned from the nose since the nose last followed it."""

    def __init__(self, min_speed: float, gps_lag_s: float) -> None:
        """Start without history; the course needs a speed (m/s), and is this late (s)."""
        self._min_speed = min_speed
        self._lag_ns = round(gps_lag_s * NANOSECONDS)
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
        """The course was lost: restart."""
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


SWING_S = 45.0
"""The compass is watched over this time. A disturbance also misleads the estimator's gyroscope
bias, which turns its heading for half a minute after the compass is right again.
Chosen, not swept."""

SWING_GAIN = 2.0
"""The estimator overshoots a compass that swings and comes back by up to this factor.
Chosen, not swept."""


@dataclass(frozen=True, slots=True)
class Headings:
    """All headings at one time, rad; the first two are continuous.

    They are differences, so that a turn of the vehicle, which all see, drops out.
    """

    stamp_ns: int
    estimated_gyro: float
    """Heading of the estimator, which believes the GPS, minus the turn of the gyroscope."""
    compass_gyro: float
    """Heading of the compass minus the turn of the gyroscope."""
    course_gyro: float | None = None
    """Course of the GPS minus the turn of the gyroscope; None where there is no course."""

    @property
    def estimated_compass(self) -> float:
        """Estimator minus compass, rad, wrapped."""
        return math.remainder(self.estimated_gyro - self.compass_gyro, math.tau)


@dataclass(frozen=True, slots=True)
class Turn:
    """How far one heading has turned away, rad, over a window, against the limit of that window."""

    angle: float
    seconds: float
    limit: float

    @property
    def margin(self) -> float:
        """Angle over limit."""
        return abs(self.angle) / self.limit


class HeadingHistory:
    """The headings of the last 45 s, compared over windows."""

    def __init__(self, limits: Mapping[float, float], tolerated: float) -> None:
        """Start without history.

        Args:
            limits: How far the estimator may turn away, rad, by length of the window in seconds.
            tolerated: Swing of compass against gyro that the limits allow for, rad.
        """
        self._limits = limits
        self._tolerated = tolerated
        self._entries: deque[Headings] = deque()
        self._judged_ns: int | None = None

    def clear(self) -> None:
        """Forget everything: a heading has jumped for a known reason."""
        self._entries.clear()

    def judge_from(self, stamp_ns: int) -> None:
        """Leave out what the estimator did before a stamp; the compass is remembered."""
        self._judged_ns = stamp_ns

    def add(self, headings: Headings) -> None:
        """Add the newest headings."""
        oldest_ns = headings.stamp_ns - round(SWING_S * NANOSECONDS)
        self._entries.append(headings)
        while self._entries[0].stamp_ns < oldest_ns:
            self._entries.popleft()

    @property
    def span_s(self) -> float:
        """Time from the oldest to the newest entry, s."""
        if not self._entries:
            return 0.0
        return (self._entries[-1].stamp_ns - self._entries[0].stamp_ns) / NANOSECONDS

    def _before(self, seconds: float) -> Headings | None:
        """The newest entry that is at least so old, None if there is none."""
        wanted_ns = self._entries[-1].stamp_ns - round(seconds * NANOSECONDS)
        found = None
        for entry in self._entries:
            if entry.stamp_ns > wanted_ns:
                break
            found = entry
        return found

    @property
    def swing(self) -> float:
        """Largest minus smallest of compass against gyro in the last 45 s, rad."""
        values = [entry.compass_gyro for entry in self._entries]
        return max(values) - min(values)

    @property
    def difference(self) -> float:
        """Estimator minus compass now, rad, wrapped; there must be an entry."""
        return self._entries[-1].estimated_compass

    def estimator(self) -> Turn:
        """How far the estimator has turned away from compass and gyro, which agree.

        It must have turned away from the gyro and from the compass, to the same side, and be on
        that side of the compass now. An estimator that a disturbed compass pulls along is between
        the two, and one that comes back from an error turns towards the compass: both count zero.
        """
        now = self._entries[-1]
        extra = SWING_GAIN * max(0.0, self.swing - self._tolerated)
        turns = []
        for seconds, limit in self._limits.items():
            then = self._before(seconds)
            if then is None or (self._judged_ns or then.stamp_ns) > then.stamp_ns:
                continue
            from_gyro = now.estimated_gyro - then.estimated_gyro
            from_compass = from_gyro - (now.compass_gyro - then.compass_gyro)
            angle = common(from_gyro, from_compass, now.estimated_compass)
            turns.append(Turn(angle, seconds, limit + extra))
        longest = max(self._limits)
        empty = Turn(0.0, longest, self._limits[longest] + extra)
        return max(turns, key=lambda turn: turn.margin, default=empty)

    def compass(self, limit: float) -> tuple[Turn, bool]:
        """How far compass and gyro have turned from each other, and whether the gyro is wrong.

        It is where the course of the GPS went with the compass.
        """
        now = self._entries[-1]
        worst, gyro = Turn(0.0, max(self._limits), limit), False
        for seconds in self._limits:
            then = self._before(seconds)
            if then is None:
                continue
            angle = now.compass_gyro - then.compass_gyro
            if abs(angle) > abs(worst.angle):
                worst = Turn(angle, seconds, limit)
                gyro = False
                if now.course_gyro is not None and then.course_gyro is not None:
                    with_gyro = now.course_gyro - then.course_gyro
                    with_compass = math.remainder(with_gyro - angle, math.tau)
                    gyro = abs(with_compass) < 0.5 * abs(angle)
        return worst, gyro


def common(*angles: float) -> float:
    """The smallest of angles on one side of zero; zero if they are not on one side."""
    if all(angle > 0.0 for angle in angles):
        return min(angles)
    if all(angle < 0.0 for angle in angles):
        return max(angles)
    return 0.0
