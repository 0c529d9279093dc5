# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A flight cut into epochs: the IMU up to a fix, the fix, and what else the filters are given."""

from __future__ import annotations

import bisect
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from hijack_detect.bags.reader import BagReader
from hijack_detect.estimation.ekf import ImuBlock
from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.estimation.imu_buffer import ImuBuffer
from hijack_detect.estimation.magnetic import declination
from hijack_detect.estimation.rotation import heading
from hijack_detect.streams.messages import header_stamp_ns
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    ImuSample,
    MagneticSample,
    PressureSample,
    Sample,
    Vector3,
    VelocitySample,
)

GPS_LAG_S = 0.15
"""As AttitudeParameters.gps_lag_s; PX4 counts on 0.11 s (EKF2_GPS_DELAY)."""
MAX_IMU_GAP_S = 1.0
"""After a longer gap in the IMU's data a filter restarts."""
FIRST_S = 0.5
"""The IMU's data before the first fix that levels the filter."""
AUTOPILOT_ATTITUDE = "/autopilot/attitude"
"""Attitude of the recording autopilot, `geometry_msgs/QuaternionStamped`, FLU in ENU."""


@dataclass(frozen=True, slots=True)
class Compass:
    """Where North is: the magnetic field in the body, or a heading.

    Attributes:
        field: Magnetic field, tesla, FLU; None if the heading is given.
        angle: The field's declination, or the heading counter-clockwise from East; radians.
    """

    field: Vector3 | None
    angle: float


@dataclass(frozen=True, slots=True)
class Epoch:
    """One fix, the velocity of the same stamp, and everything up to when they were true.

    Attributes:
        fix: As the receiver reported it.
        velocity: As the receiver reported it.
        block: IMU readings since the last epoch.
        barometer_m: Height by the barometer above the first fix, metres.
        compass: Where North is.
        restart: Whether there is a gap in the IMU's data before it.
    """

    fix: FixSample
    velocity: VelocitySample
    block: ImuBlock
    barometer_m: float
    compass: Compass
    restart: bool

    @property
    def stamp_ns(self) -> int:
        """Stamp of fix and velocity, nanoseconds."""
        return self.fix.stamp_ns


@dataclass(frozen=True)
class Epochs:
    """A flight as the filters see it.

    Attributes:
        frame: The plane of its positions.
        items: The epochs in order of stamp.
    """

    frame: LocalFrame
    items: list[Epoch]

    def first_from(self, stamp_ns: int) -> int:
        """Index of the first epoch at or after a stamp."""
        return bisect.bisect_left(self.items, stamp_ns, key=lambda one: one.stamp_ns)


class _Cutter:
    """Collects samples until a fix and a velocity of one stamp complete an epoch."""

    def __init__(self, headings: Sequence[tuple[int, float]]) -> None:
        self.frame: LocalFrame | None = None
        self.items: list[Epoch] = []
        self._headings = headings
        self._buffer = ImuBuffer()
        self._reached_ns: int | None = None
        self._last_imu_ns: int | None = None
        self._gap = True
        self._gps: dict[int, tuple[FixSample | None, VelocitySample | None]] = {}
        self._magnetics: list[MagneticSample] = []
        self._declination = 0.0
        self._pressure_m: float | None = None
        self._pressure_offset_m: float | None = None

    def add(self, sample: Sample) -> None:
        if isinstance(sample, ImuSample):
            last = self._last_imu_ns
            if last is not None and sample.stamp_ns - last > MAX_IMU_GAP_S * NANOSECONDS:
                self._gap = True
            self._last_imu_ns = sample.stamp_ns
            self._buffer.append(sample)
        elif isinstance(sample, MagneticSample):
            self._magnetics.append(sample)
        elif isinstance(sample, PressureSample):
            self._pressure_m = standard_height_m(sample.pressure_pa)
        elif isinstance(sample, FixSample) and sample.has_fix:
            self._pair(sample, self._gps.pop(sample.stamp_ns, (None, None))[1])
        elif isinstance(sample, VelocitySample):
            self._pair(self._gps.pop(sample.stamp_ns, (None, None))[0], sample)

    def _pair(self, fix: FixSample | None, velocity: VelocitySample | None) -> None:
        if fix is not None and velocity is not None:
            self._gps.clear()
            self._complete(fix, velocity)
        else:
            known = fix or velocity
            assert known is not None
            self._gps[known.stamp_ns] = (fix, velocity)

    def _complete(self, fix: FixSample, velocity: VelocitySample) -> None:
        if self._last_imu_ns is None:
            return
        if self.frame is None:
            self.frame = LocalFrame(fix)
            self._declination = declination(fix.latitude_deg, fix.longitude_deg, fix.altitude_m)
        true_ns = min(fix.stamp_ns - round(GPS_LAG_S * NANOSECONDS), self._last_imu_ns)
        begin_ns = self._reached_ns
        if begin_ns is None or self._gap:
            begin_ns = true_ns - round(FIRST_S * NANOSECONDS)
        compass = self._compass(true_ns)
        if compass is None or true_ns <= begin_ns or begin_ns < self._buffer.oldest_ns:
            return
        block = self._buffer.take(begin_ns, true_ns)
        height = self._height_m(self.frame.enu(fix)[2])
        self.items.append(Epoch(fix, velocity, block, height, compass, self._gap))
        self._reached_ns, self._gap = true_ns, False

    def _compass(self, true_ns: int) -> Compass | None:
        if self._headings:
            index = bisect.bisect_right(self._headings, true_ns, key=lambda one: one[0])
            return None if index == 0 else Compass(None, self._headings[index - 1][1])
        while len(self._magnetics) > 1 and self._magnetics[1].stamp_ns <= true_ns:
            del self._magnetics[0]
        if not self._magnetics:
            return None
        return Compass(self._magnetics[0].field, self._declination)

    def _height_m(self, up_m: float) -> float:
        """Height by the barometer; where there is none, that of the fix before any attack."""
        if self._pressure_m is None:
            return up_m
        if self._pressure_offset_m is None:
            self._pressure_offset_m = self._pressure_m - up_m
        return self._pressure_m - self._pressure_offset_m


def cut(samples: Iterable[Sample], headings: Sequence[tuple[int, float]] = ()) -> Epochs:
    """Cut a flight into epochs.

    Args:
        samples: Every sample in order of arrival, without an attack that is to come.
        headings: Stamp in nanoseconds and heading in radians counter-clockwise from East, in
            order of stamp, for a flight without magnetometer.

    Raises:
        ValueError: The flight has no fix with a velocity of the same stamp.
    """
    cutter = _Cutter(headings)
    for sample in samples:
        cutter.add(sample)
    if cutter.frame is None or not cutter.items:
        raise ValueError("the flight has no fix with a velocity, a heading and IMU data")
    return Epochs(cutter.frame, cutter.items)


def standard_height_m(pressure_pa: float) -> float:
    """Height in the standard atmosphere, metres above sea level."""
    return float((1.0 - (pressure_pa / 101_325.0) ** (1.0 / 5.25588)) / 2.25577e-5)


def recorded_headings(reader: BagReader) -> list[tuple[int, float]]:
    """Stamps and headings of the recording autopilot: stands for a compass that was not logged.

    Only for flights that were clean when they were flown.
    """
    found = []
    for raw in reader.messages([AUTOPILOT_ATTITUDE]):
        message = reader.deserialize(raw)
        q = message.quaternion
        found.append((header_stamp_ns(message), heading((q.x, q.y, q.z, q.w))))
    return sorted(found)
