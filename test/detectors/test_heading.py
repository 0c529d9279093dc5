# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Gyro, compass and GPS against each other: who is named, and who is never accused."""

import heapq
import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hijack_detect.detectors.heading import HeadingDetector, HeadingParameters
from hijack_detect.detectors.heading_evidence import HeadingHistory, Headings, common
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.compass import earth_field
from hijack_detect.monitor.graph import Stage
from hijack_detect.streams.samples import (
    AttitudeSample,
    FixSample,
    ImuSample,
    MagneticSample,
    Phase,
    PhaseSample,
    Sample,
    VelocitySample,
)

SECOND = 10**9
FIX = FixSample(0, 48.0, 11.0, 500.0)
FIELD = np.array(earth_field(FIX))
Sent = list[tuple[str, Sample]]
Angle = Callable[[float], float]
FORCE = (0.0, 0.0, 9.80665)


def zero(_: float) -> float:
    return 0.0


def flown(
    seconds: float,
    *,
    nose: Angle = zero,
    estimated: Angle = zero,
    course: Angle = zero,
    speed: float = 8.0,
    compass: Angle = zero,
    gyro: float = 0.0,
) -> Sent:
    """A level flight: IMU, compass 10 Hz, GPS 5 Hz, attitude 50 Hz.

    Args:
        seconds: Length.
        nose: True heading, rad, at a time.
        estimated: Error of the estimator's heading.
        course: Course minus nose.
        speed: Over ground.
        compass: Error of the compass, rad.
        gyro: Error of the gyroscope after 30 s, rad/s.
    """
    sent: Sent = []
    for k in range(round(seconds * 50)):
        t, stamp = k / 50, k * SECOND // 50
        rate = (nose(t + 1e-3) - nose(t - 1e-3)) / 2e-3 + (gyro if t > 30.0 else 0.0)
        sent.append(("imu", ImuSample(stamp, (0.0, 0.0, rate), FORCE)))
        if k % 5 == 0:
            x, y, z = Rotation.from_euler("Z", nose(t) + compass(t)).inv().apply(FIELD).tolist()
            sent.append(("mag", MagneticSample(stamp, (x, y, z))))
        if k % 10 == 0:
            track = nose(t - 0.15) + course(t)
            velocity = (speed * math.cos(track), speed * math.sin(track), 0.0)
            sent.append(("fix", replace(FIX, stamp_ns=stamp)))
            sent.append(("velocity", VelocitySample(stamp, velocity)))
        half = 0.5 * (nose(t) + estimated(t))
        q = (0.0, 0.0, math.sin(half), math.cos(half))
        sent.append(("attitude", AttitudeSample(stamp, q, 1e-3, (0.0, 0.0, rate), FORCE)))
    return sent


def run(sent: Sent) -> list[Verdict]:
    stage = Stage(lambda: HeadingDetector(HeadingParameters()))
    return [one for name, sample in sent for one in stage.push(name, sample)]


def states(verdicts: list[Verdict]) -> set[State]:
    return {one.state for one in verdicts}


def since(verdicts: list[Verdict], seconds: float) -> list[Verdict]:
    return [one for one in verdicts if one.stamp_ns >= seconds * SECOND]


def ramp(start: float, seconds: float, degrees: float) -> Angle:
    return lambda t: math.radians(degrees) * min(max((t - start) / seconds, 0.0), 1.0)


def turning(t: float) -> float:
    return 0.4 * t + 0.5 * math.sin(0.3 * t)


def test_all_agree_on_a_turning_flight() -> None:
    verdicts = run(flown(40.0, nose=turning))
    assert states(since(verdicts, 20.0)) == {State.NORMAL}
    assert states(verdicts) == {State.NOT_READY, State.NOT_OBSERVABLE, State.NORMAL}
    assert max(one.margin for one in verdicts) < 0.3


def test_a_fast_spin_is_no_attack() -> None:
    verdicts = run(flown(40.0, nose=lambda t: 2.5 * max(0.0, t - 15.0), speed=0.0))
    assert states(since(verdicts, 20.0)) == {State.NORMAL}
    assert states(verdicts) == {State.NOT_READY, State.NOT_OBSERVABLE, State.NORMAL}


def test_an_estimator_that_the_gps_drags_along_is_an_alarm() -> None:
    """The course goes on along the nose: only the estimator's heading shows it."""
    verdicts = run(flown(45.0, nose=turning, estimated=ramp(30.0, 5.0, 30.0)))
    first = next(one for one in verdicts if one.state is State.ALARM)
    assert 30.0 < first.stamp_ns / SECOND < 33.0
    assert first.reason.startswith("compass and gyro against GPS")
    assert verdicts[-20].values["difference"] == pytest.approx(math.radians(30.0), abs=0.03)


def test_an_estimator_that_was_always_off_is_none() -> None:
    """Hard iron and a wrong declination are constant."""
    verdicts = run(flown(40.0, nose=turning, estimated=lambda _: 0.3))
    assert State.ALARM not in states(verdicts)


def test_an_estimator_that_comes_back_is_none() -> None:
    verdicts = run(flown(45.0, estimated=lambda t: 0.7 - ramp(30.0, 4.0, 40.0)(t)))
    assert State.ALARM not in states(verdicts)


def test_a_compass_anomaly_is_named_and_never_an_alarm() -> None:
    def pulled(t: float) -> float:
        return math.radians(50.0) if 30.0 <= t < 50.0 else 0.0

    def dragged(t: float) -> float:
        """An estimator that trusts the compass a little, and returns slowly."""
        return 0.5 * pulled(t) if t < 50.0 else math.radians(25.0) * math.exp((50.0 - t) / 8.0)

    verdicts = run(flown(90.0, compass=pulled, estimated=dragged))
    assert {State.ALARM, State.SUSPICIOUS}.isdisjoint(states(verdicts))
    blocked = [one for one in since(verdicts, 20.0) if one.state is State.NOT_OBSERVABLE]
    assert all("compass against gyro and GPS" in one.reason for one in blocked)
    assert all("magnetic anomaly" in one.reason for one in blocked)
    assert max(one.values["compass_anomaly"] for one in blocked) > 1.0
    assert verdicts[-1].state is State.NORMAL


def test_a_gyro_fault_is_named() -> None:
    verdicts = run(flown(40.0, gyro=math.radians(12.0)))
    assert State.ALARM not in states(verdicts)
    assert any("gyro against compass and GPS" in one.reason for one in verdicts)


def test_flying_off_the_nose_is_suspicious_at_most() -> None:
    verdicts = run(flown(45.0, course=ramp(30.0, 1.0, 60.0)))
    assert State.SUSPICIOUS in states(verdicts)
    assert State.ALARM not in states(verdicts)
    assert max(one.margin for one in verdicts) < 1.0
    assert any("the course turned +" in one.reason for one in verdicts)


@pytest.mark.parametrize(("phase", "rate_hz"), [(Phase.HANDLED, 50.0), (Phase.FLYING, 4.0)])
def test_an_alarm_needs_a_flight_and_an_imu_that_is_fast_enough(
    phase: Phase, rate_hz: float
) -> None:
    sent = flown(45.0, estimated=ramp(30.0, 5.0, 25.0))
    assert State.ALARM in states(run(sent))
    gated: Sent = []
    for name, sample in sent:
        if name == "imu" and sample.stamp_ns % (SECOND // 5) == 0:
            gated.append(("phase", PhaseSample(sample.stamp_ns, phase, 0, "so it is", rate_hz)))
        gated.append((name, sample))
    assert states(run(gated)) == {State.NOT_READY, State.NOT_OBSERVABLE}


def test_without_a_magnetometer() -> None:
    sent = [one for one in flown(12.0) if one[0] != "mag"]
    verdicts = run(sent)
    late = [one for one in verdicts if one.stamp_ns >= 3 * SECOND]
    assert late
    assert {(one.state, one.reason) for one in late} == {(State.NOT_OBSERVABLE, "no magnetometer")}
    early = [one for one in verdicts if one.stamp_ns < 3 * SECOND]
    assert states(early) == {State.NOT_READY}
    assert run(sent) == verdicts


def test_a_magnetometer_that_stops_is_told() -> None:
    sent = [one for one in flown(30.0) if one[0] != "mag" or one[1].stamp_ns < 20 * SECOND]
    assert run(sent)[-1].state is State.STALE
    assert "no magnetometer for" in run(sent)[-1].reason


def test_the_attitude_estimator_that_stops_is_told() -> None:
    sent = [one for one in flown(40.0) if one[0] != "attitude" or one[1].stamp_ns < 20 * SECOND]
    verdicts = run(sent)
    assert verdicts[-1].state is State.STALE
    assert "no attitude for" in verdicts[-1].reason


def test_a_spoofed_place_does_not_turn_north() -> None:
    """On the other side of the Atlantic the declination differs by 15°."""
    sent = flown(40.0, nose=turning)
    moved = [
        (name, replace(one, latitude_deg=45.0, longitude_deg=-70.0))
        if isinstance(one, FixSample) and one.stamp_ns > 20 * SECOND
        else (name, one)
        for name, one in sent
    ]
    assert [one.values for one in run(moved)] == [one.values for one in run(sent)]


@lru_cache(maxsize=1)
def _interleaved() -> tuple[list[Verdict], list[Verdict]]:
    sent = flown(25.0, nose=turning)
    late = heapq.merge(
        [
            (one[1].stamp_ns + (90_000_000 if one[0] == "mag" else 0), k)
            for k, one in enumerate(sent)
            if one[0] == "mag"
        ],
        [(one[1].stamp_ns, k) for k, one in enumerate(sent) if one[0] != "mag"],
    )
    return run(sent), run([sent[k] for _, k in late])


def test_the_order_of_arrival_does_not_matter() -> None:
    straight, shuffled = _interleaved()
    assert shuffled == straight[: len(shuffled)]
    assert len(straight) - len(shuffled) < 3


@given(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=4))
def test_common_is_never_larger_than_any(angles: list[float]) -> None:
    assert all(abs(common(*angles)) <= abs(one) for one in angles)
    assert common(*[-one for one in angles]) == -common(*angles)


@given(st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_an_estimator_between_gyro_and_compass_counts_nothing(pull: float, part: float) -> None:
    history = HeadingHistory({2.0: 0.1}, 10.0)
    for k in range(20):
        compass = pull if k >= 10 else 0.0
        history.add(Headings(k * SECOND // 5, part * compass, compass))
    assert history.estimator().angle == pytest.approx(0.0, abs=1e-12)
