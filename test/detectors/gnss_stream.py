# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A straight flight to the North as a receiver tells it, and what the detector says of it."""

from collections.abc import Callable
from typing import Any

import pymap3d

from hijack_detect.detectors.gnss_sanity import GnssSanityDetector, GnssSanityParameters
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.monitor.graph import Stage
from hijack_detect.streams.samples import FixSample, Vector3, VelocitySample

SECOND = 10**9
START_NS = 1_700_000_000 * SECOND
STEP_NS = SECOND // 5
Sent = list[tuple[str, Any]]


def nowhere(_: float) -> Vector3:
    return (0.0, 0.0, 0.0)


def fix(t: float, place: Vector3, accuracy_m: float | None = None) -> FixSample:
    latitude, longitude, altitude = pymap3d.enu2geodetic(*place, 48.0, 11.0, 500.0)
    stamp = START_NS + round(t * SECOND)
    return FixSample(
        stamp, float(latitude), float(longitude), float(altitude), accuracy_m=accuracy_m
    )


def velocity(t: float, value: Vector3) -> VelocitySample:
    return VelocitySample(START_NS + round(t * SECOND), value)


def flight(
    seconds: float,
    offset: Callable[[float], Vector3] = nowhere,
    *,
    speed: float = 5.0,
    velocities: bool = True,
) -> Sent:
    """Fixes and velocities at 5 Hz; `offset` is added to the position only."""
    sent: Sent = []
    for index in range(round(seconds * 5)):
        t = index / 5
        east, north, up = offset(t)
        if velocities:
            sent.append(("velocity", velocity(t, (0.0, speed, 0.0))))
        sent.append(("fix", fix(t, (east, speed * t + north, up))))
    return sent


def run(sent: Sent, **parameters: float) -> list[Verdict]:
    """Verdicts of the detector behind a stage, as in a node."""
    stage = Stage(lambda: GnssSanityDetector(GnssSanityParameters(**parameters)))
    return [verdict for name, sample in sent for verdict in stage.push(name, sample)]


def seconds(verdict: Verdict) -> float:
    return (verdict.stamp_ns - START_NS) / SECOND
