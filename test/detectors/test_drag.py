# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A multirotor in an ideal wind: what the drag detector says of its GPS velocity."""

import math

import numpy as np

from hijack_detect.detectors.drag import DragDetector, DragParameters
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.streams.samples import AttitudeSample, VelocitySample

MS = 1_000_000
PARAMETERS = DragParameters(gps_lag_s=0.0)


def fly(
    seconds: float,
    offset: float = 0.0,
    onset_s: float = 60.0,
    *,
    k: float = 0.3,
    moves: bool = True,
) -> list[Verdict]:
    """A circle at 6 m/s, nose ahead; from the onset on, the GPS adds an offset to the East."""
    detector = DragDetector(PARAMETERS)
    said: list[Verdict | None] = []
    for ms in range(0, round(seconds * 1000), 50):
        t = ms / 1000
        angle = 0.2 * t
        q = (0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2))
        speed = 6.0 if moves else 0.0
        force = (-k * speed, 0.0, 9.80665)
        said.append(detector.update("attitude", AttitudeSample(ms * MS, q, 0.0, (0, 0, 0), force)))
        if ms % 200 == 0:
            added = min(offset, max(0.0, t - onset_s))
            velocity = speed * np.array([math.cos(angle), math.sin(angle)])
            sample = VelocitySample(ms * MS, (float(velocity[0]) + added, float(velocity[1]), 0.0))
            said.append(detector.update("velocity", sample))
    return [one for one in said if one is not None]


def test_a_clean_flight_becomes_normal() -> None:
    said = fly(80.0)
    assert said[-1].state is State.NORMAL
    assert not any(one.state in (State.SUSPICIOUS, State.ALARM) for one in said)
    assert abs(said[-1].values["drag"] - 0.3) < 0.05


def test_a_constant_offset_alarms_and_says_what_wind_it_needs() -> None:
    said = fly(110.0, offset=6.0)
    alarm = next(one for one in said if one.state is State.ALARM)
    assert 60.0 < alarm.stamp_ns / 1e9 < 95.0
    assert alarm.reason.startswith("The GPS velocity needs a wind change of ")
    assert said[-1].state is State.ALARM
    assert abs(said[-1].values["wind_change"] - 6.0) < 1.0


def test_a_vehicle_that_never_moved_is_not_observable() -> None:
    assert {one.state for one in fly(60.0, moves=False)} <= {State.NOT_READY, State.NOT_OBSERVABLE}


def test_without_drag_nothing_is_claimed() -> None:
    said = fly(110.0, offset=6.0, k=0.0)
    assert said[-1].state is State.NOT_OBSERVABLE


def test_the_limit_grows_with_the_wind() -> None:
    assert PARAMETERS.limit(2.0) == 3.7
    assert PARAMETERS.limit(8.0) == 5.4
