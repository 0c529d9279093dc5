# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Applies a scenario to the GPS samples of a flight, offline and live alike."""

from __future__ import annotations

import bisect
from collections import deque
from typing import TypeVar, cast

from hijack_detect.estimation.geodesy import separation_m
from hijack_detect.spoofing import schema
from hijack_detect.spoofing.attacks import (
    Attack,
    FreezeAttack,
    OffsetAttack,
    Recording,
    ReplayAttack,
    TrackAttack,
)
from hijack_detect.spoofing.forge import ForgeAttack
from hijack_detect.spoofing.offsets import make_offset
from hijack_detect.spoofing.onset import History, Onset, last_before, onset_at
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.schema import Forge
from hijack_detect.spoofing.tracks import make_track
from hijack_detect.streams.samples import NANOSECONDS, FixSample, SatelliteSample, VelocitySample


def record(model: schema.Replay, start_s: float, start_ns: int, end_ns: int | None) -> Recording:
    """Prepare the recording for a replay; feed it every true sample from the first on."""
    lag_ns = round((start_s - model.from_s) * NANOSECONDS)
    until_ns = None if end_ns is None else end_ns - lag_ns
    return Recording(
        lag_ns, History(start_ns - lag_ns, until_ns), History(start_ns - lag_ns, until_ns)
    )


def make_attack(segment: schema.Segment, onset: Onset, recording: Recording | None) -> Attack:
    """Build the attack of a segment for the vehicle's state at onset.

    Raises:
        ValueError: A replay has no recording.
    """
    model = segment.model
    if isinstance(model, schema.Replay):
        if recording is None:
            raise ValueError("a replay needs a recording")
        return ReplayAttack(recording)
    if isinstance(model, schema.Freeze):
        return FreezeAttack(model, onset)
    if isinstance(model, schema.FakeTrack | schema.TurnAway):
        return TrackAttack(make_track(model, onset), onset)
    if isinstance(model, Forge):
        return ForgeAttack(model, onset)
    return OffsetAttack(make_offset(model, onset.course), onset)


T = TypeVar("T")

RECENT = 8
"""True samples kept for the onset: two before it are needed, and some may share its stamp."""


class Spoofer:
    """Turns true fixes, velocities and numbers of satellites into reported ones.

    Give it every true sample in the order of stamps; samples of different kinds with the same
    stamp may come in any order, and there may be no velocities and no numbers at all. Outside the
    segments, and for fixes without a position, the same object comes back. A segment holds from
    its start, inclusive, to its end, exclusive, both compared with header stamps.
    """

    def __init__(self, scenario: Scenario, first_stamp_ns: int) -> None:
        """Place the scenario on a flight.

        Args:
            scenario: The attacks; their times are seconds after `first_stamp_ns`.
            first_stamp_ns: Stamp of the flight's first message.
        """
        self._segments = scenario.segments
        self._starts = [first_stamp_ns + _ns(segment.start_s) for segment in self._segments]
        self._ends = [
            None if segment.end_s is None else first_stamp_ns + _ns(segment.end_s)
            for segment in self._segments
        ]
        self._recordings: dict[int, Recording] = {
            index: record(segment.model, segment.start_s, self._starts[index], self._ends[index])
            for index, segment in enumerate(self._segments)
            if isinstance(segment.model, schema.Replay)
        }
        self._running: tuple[int, Attack] | None = None
        self._fixes: deque[FixSample] = deque(maxlen=RECENT)
        self._velocities: deque[VelocitySample] = deque(maxlen=RECENT)
        self._reported: FixSample | None = None

    def fix(self, sample: FixSample) -> FixSample:
        """Return the reported fix in place of a true one."""
        if not sample.has_fix:
            return sample
        for recording in self._recordings.values():
            recording.fixes.add(sample)
        self._reported = self._spoofed_fix(sample)
        self._fixes.append(sample)
        return self._reported

    def velocity(self, sample: VelocitySample) -> VelocitySample:
        """Return the reported velocity in place of a true one."""
        for recording in self._recordings.values():
            recording.velocities.add(sample)
        reported = self._spoofed_velocity(sample)
        self._velocities.append(sample)
        return reported

    def satellites(self, sample: SatelliteSample) -> SatelliteSample:
        """Return the reported number of satellites in place of a true one."""
        index = self._index(sample.stamp_ns)
        if index is None:
            return sample
        return self._attack(index).satellites(sample, self._since(index, sample.stamp_ns))

    def report(self, sample: T) -> T:
        """Return the reported sample in place of a true one; those of other inputs stay."""
        if isinstance(sample, FixSample):
            return cast(T, self.fix(sample))
        if isinstance(sample, VelocitySample):
            return cast(T, self.velocity(sample))
        if isinstance(sample, SatelliteSample):
            return cast(T, self.satellites(sample))
        return sample

    def active(self, stamp_ns: int) -> bool:
        """Ground truth: whether a segment covers the stamp."""
        return self._index(stamp_ns) is not None

    def onset_ns(self, stamp_ns: int) -> int | None:
        """Stamp at which the segment that covers a stamp starts, None if none does."""
        index = self._index(stamp_ns)
        return None if index is None else self._starts[index]

    @property
    def offset_m(self) -> float:
        """Separation of the last true and the last reported fix, metres in three dimensions."""
        if self._reported is None or self._reported is self._fixes[-1]:
            return 0.0
        return separation_m(self._fixes[-1], self._reported)

    def _spoofed_fix(self, sample: FixSample) -> FixSample:
        index = self._index(sample.stamp_ns)
        if index is None:
            return sample
        return self._attack(index).fix(sample, self._since(index, sample.stamp_ns))

    def _spoofed_velocity(self, sample: VelocitySample) -> VelocitySample:
        index = self._index(sample.stamp_ns)
        if index is None:
            return sample
        attack = self._attack(index)
        if not self._segments[index].velocity_consistent:
            return sample
        before = last_before(sample.stamp_ns, self._fixes)
        return attack.velocity(sample, self._since(index, sample.stamp_ns), before)

    def _index(self, stamp_ns: int) -> int | None:
        """Index of the segment that covers a stamp."""
        index = bisect.bisect_right(self._starts, stamp_ns) - 1
        if index < 0:
            return None
        end_ns = self._ends[index]
        return index if end_ns is None or stamp_ns < end_ns else None

    def _since(self, index: int, stamp_ns: int) -> float:
        """Seconds since the start of a segment."""
        return (stamp_ns - self._starts[index]) / NANOSECONDS

    def _attack(self, index: int) -> Attack:
        """Return the attack of a segment, started at the segment's first sample.

        A late sample of a segment that is over does not stop the one that runs.
        """
        if self._running is not None and self._running[0] == index:
            return self._running[1]
        onset = onset_at(self._starts[index], self._fixes, self._velocities)
        attack = make_attack(self._segments[index], onset, self._recordings.get(index))
        if self._running is None or self._running[0] < index:
            self._running = (index, attack)
        return attack


def _ns(seconds: float) -> int:
    return round(seconds * NANOSECONDS)
