# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What one clean flight says of its vehicle, and when an attack would fit into it."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hijack_detect.evaluation.trials.cases import Case
from hijack_detect.evaluation.trials.recorded import Recorded, record
from hijack_detect.evaluation.tuning.noise import ImuNoise, Lag, gps_lag, imu_noise
from hijack_detect.monitor.graph import MonitorParameters
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.streams.samples import NANOSECONDS, FixSample

SETTLED_S = 12.0
"""An attack begins this long after the flight has begun to move forward, at the earliest."""
BROKEN_S = 2.0
"""A shorter time without a course does not end forward flight."""


@dataclass(frozen=True)
class Survey:
    """What a clean flight says of its vehicle.

    Attributes:
        name: The flight.
        hours: Its length.
        day: Date (UTC, ISO) of its first stamp.
        lag: The GPS's lag, None if the flight does not tell.
        noise: The IMU's noise, None if it never moved.
        fix_interval_s: Usual time between fixes, seconds.
        onsets_s: For each scenario when to begin it, empty where it does not fit in.
    """

    name: str
    hours: float
    day: str
    lag: Lag | None
    noise: ImuNoise | None
    fix_interval_s: float
    onsets_s: tuple[tuple[float, ...], ...]


def survey(
    parameters: MonitorParameters, scenarios: Sequence[Scenario], attacks: int, case: Case
) -> Survey:
    """Estimate lag and noise on a clean flight, and choose when to attack it.

    Args:
        parameters: Parameters of every part.
        scenarios: What to attack it with.
        attacks: How often, with each scenario.
        case: The flight.

    Raises:
        ValueError: The flight cannot be read, or is not clean; the text names it.
    """
    flight = record(case, parameters)
    if flight.attack is not None:
        raise ValueError(f"{case.name}: has an attack but is not labelled so; label or remove it")
    fixes = [sample.stamp_ns for _, sample in flight.samples if isinstance(sample, FixSample)]
    interval_ns = float(np.median(np.diff(fixes))) if len(fixes) > 1 else 0.0
    return Survey(
        case.name,
        flight.hours,
        str(np.datetime64(flight.start_ns, "ns").astype("datetime64[D]")),
        gps_lag(flight),
        imu_noise(flight),
        interval_ns / NANOSECONDS,
        tuple(attack_onsets_s(flight, case.name, scenario, attacks) for scenario in scenarios),
    )


def attack_onsets_s(
    flight: Recorded, name: str, scenario: Scenario, count: int
) -> tuple[float, ...]:
    """Times in the longest forward flight at which a scenario fits in, seconds.

    They are drawn from a seed made of the flight's name, so that the same flight always gets the
    same attacks. Empty if the vehicle does not fly forward for long enough.
    """
    begin_ns, end_ns = longest_forward(flight)
    first, last = scenario.segments[0], scenario.segments[-1]
    length_s = 0.0 if last.end_s is None else last.end_s - first.start_s
    earliest = (begin_ns - flight.start_ns) / NANOSECONDS + SETTLED_S
    latest = (end_ns - flight.start_ns) / NANOSECONDS - length_s
    if begin_ns == end_ns or latest < earliest:
        return ()
    rng = np.random.default_rng(zlib.crc32(f"{name} {scenario.segments[0].name}".encode()))
    return tuple(round(onset, 1) for onset in rng.uniform(earliest, latest, count).tolist())


def longest_forward(flight: Recorded) -> tuple[int, int]:
    """First and last stamp of the longest time with a course, nanoseconds; equal without any."""
    longest, since_ns, last_ns = (0, 0), 0, 0
    for course in flight.courses:
        if not course.observable:
            continue
        if course.stamp_ns - last_ns > BROKEN_S * NANOSECONDS:
            since_ns = course.stamp_ns
        last_ns = course.stamp_ns
        longest = max(longest, (since_ns, last_ns), key=lambda span: span[1] - span[0])
    return longest
