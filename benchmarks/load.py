# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Bags to measure with: a simulated flight, resampled to any rate of IMU and GPS."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from hijack_detect.bags.encoding import encode_count, encode_pressure, encode_sample
from hijack_detect.bags.topics import PRESETS
from hijack_detect.bags.writer import BagWriter
from hijack_detect.simulation.flight import generate_flight
from hijack_detect.simulation.gps import velocity_there
from hijack_detect.simulation.plan import FlightPlan, Place
from hijack_detect.streams.samples import NANOSECONDS, FixSample, ImuSample, VelocitySample

SEED = 1
NOISE = (0.01, 0.1)
"""Of gyroscope and accelerometer, rad/s and m/s²: resampled readings alone would be too smooth."""


def load_bag(
    folder: Path, seconds: float, imu_hz: int, gps_hz: int = 10, place: Place | None = None
) -> Path:
    """The bag of a flight of this length, at these rates; made if it is not there."""
    path = folder / f"load_{seconds:g}s_{imu_hz}hz_{gps_hz}hz"
    if place is not None:
        where = (place.latitude_deg, place.longitude_deg, place.altitude_m)
        path = path.with_name("_".join([path.name, *(f"{number:g}" for number in where)]))
    if path.is_dir():
        return path
    flight = generate_flight(FlightPlan("curved", duration_s=seconds, place=place or Place()), SEED)
    velocities = flight.velocities
    if place is not None:
        velocities = list(map(partial(velocity_there, place), flight.fixes, velocities))
    topics = PRESETS["default"]
    rng = np.random.default_rng(SEED)

    def noisy(row: Sequence[float]) -> ImuSample:
        stamp, *read = row
        shaken = read + rng.normal(size=6) * np.repeat(NOISE, 3)
        return ImuSample(int(stamp), tuple(shaken[:3].tolist()), tuple(shaken[3:].tolist()))

    sources: list[tuple[str | None, list[tuple[int, tuple[str, bytes]]]]] = [
        (
            topics.imu,
            _resampled(
                flight.imu, imu_hz, lambda s: (*s.angular_velocity, *s.specific_force), noisy
            ),
        ),
        (
            topics.fix,
            _resampled(
                flight.fixes,
                gps_hz,
                lambda s: (s.latitude_deg, s.longitude_deg, s.altitude_m),
                lambda row: FixSample(
                    int(row[0]), row[1], math.remainder(row[2], 360.0), row[3], accuracy_m=1.0
                ),
            ),
        ),
        (
            topics.velocity,
            _resampled(
                velocities,
                gps_hz,
                lambda s: s.velocity,
                lambda row: VelocitySample(int(row[0]), (row[1], row[2], row[3])),
            ),
        ),
        (topics.mag, [(one.stamp_ns, encode_sample(one)) for one in flight.magnetics]),
        (topics.pressure, [(at, encode_pressure(at, pascal)) for at, pascal in flight.pressures]),
        (topics.satellites, [(one.stamp_ns, encode_count(one.count)) for one in flight.satellites]),
    ]
    messages = [(at, topic, kind, data) for topic, all_of in sources for at, (kind, data) in all_of]
    part = path.with_name(f"{path.name}.part")
    with BagWriter(part) as writer:
        for at, topic, kind, data in sorted(messages, key=lambda one: one[0]):
            assert topic is not None
            writer.write_raw(topic, kind, at, data)
    part.rename(path)
    return path


def _resampled(
    samples: Sequence[Any],
    hz: int,
    numbers: Callable[[Any], tuple[float, ...]],
    make: Callable[[Sequence[float]], Any],
) -> list[tuple[int, tuple[str, bytes]]]:
    """Stamps and encoded samples on a new grid, linear between the old ones."""
    stamps = np.array([one.stamp_ns for one in samples])
    values = np.unwrap([numbers(one) for one in samples], period=360.0, axis=0)  # longitudes
    grid = np.arange(stamps[0], stamps[-1], NANOSECONDS // hz)
    columns = [np.interp(grid - stamps[0], stamps - stamps[0], column) for column in values.T]
    rows = zip(grid.tolist(), *(column.tolist() for column in columns), strict=True)
    return [(int(row[0]), encode_sample(make(row))) for row in rows]
