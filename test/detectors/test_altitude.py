# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""GPS height against barometer and accelerometer, on motions worked out by hand."""

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.detectors.altitude import AltitudeDetector
from hijack_detect.detectors.altitude_parameters import AltitudeParameters
from hijack_detect.detectors.barometer_check import BarometerCheck
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.detectors.vertical_channel import HeightOffsets, VerticalForce
from hijack_detect.estimation.kalman import Innovation
from hijack_detect.streams.samples import (
    AttitudeSample,
    FixSample,
    Phase,
    PhaseSample,
    PressureSample,
    Quaternion,
    Sample,
    VelocitySample,
)

MS = 1_000_000
SECOND = 10**9
DEFAULT = AltitudeParameters()
LEVEL: Quaternion = (0.0, 0.0, 0.0, 1.0)
Motion = Callable[[float], float]
Sent = list[tuple[str, Sample]]
BAROMETER = ("attitude", "pressure", "velocity", "fix")
INERTIAL = ("attitude", "velocity", "fix")


def still(_: float) -> float:
    return 0.0


def pascal(height_m: float) -> float:
    """Hydrostatics of air at the standard's lapse rate, with its own constants."""
    exponent = 9.80665 * 0.0289644 / (8.31446 * 0.0065)
    return float(101_325.0 * (1.0 - 0.0065 * height_m / 288.15) ** exponent)


def flight(
    seconds: float,
    *,
    height: Motion = still,
    climb: Motion = still,
    felt: Motion = still,
    offset: Motion = still,
    offset_rate: Motion = still,
    inputs: Iterable[str] = BAROMETER,
    orientation: Quaternion | None = LEVEL,
) -> Sent:
    """IMU at 50 Hz, barometer at 10 Hz, GPS at 5 Hz with the lag of the parameters, no errors.

    Args:
        seconds: How long.
        height: True height, m.
        climb: Its rate, m/s.
        felt: Its acceleration, m/s².
        offset: What the GPS adds to the height, at the stamp.
        offset_rate: What it adds to the climb rate.
        inputs: Which inputs there are.
        orientation: Attitude, FLU in ENU.
    """
    sent: Sent = []
    for ms in range(0, round(seconds * 1000), 20):
        stamp, t = ms * MS, ms / 1000
        then = t - DEFAULT.gps_lag_s
        force = (0.0, 0.0, 9.80665 + felt(t))
        sent.append(("attitude", AttitudeSample(stamp, orientation, 0.0, (0.0,) * 3, force)))
        if ms % 100 == 0:
            sent.append(("pressure", PressureSample(stamp, pascal(100.0 + height(t)))))
        if ms % 200 == 0:
            reported = 100.0 + height(then) + offset(t)
            up = climb(then) + offset_rate(t)
            sent.append(("velocity", VelocitySample(stamp, (0.0, 0.0, up))))
            sent.append(("fix", FixSample(stamp, 48.0, 11.0, reported)))
    chosen = set(inputs)
    return [one for one in sent if one[0] in chosen]


def run(sent: Sent, parameters: AltitudeParameters = DEFAULT) -> list[Verdict]:
    detector = AltitudeDetector(parameters)
    verdicts = (detector.update(name, sample) for name, sample in sent)
    return [one for one in verdicts if one is not None]


def first_alarm_s(verdicts: list[Verdict]) -> float | None:
    return next((one.stamp_ns / SECOND for one in verdicts if one.state is State.ALARM), None)


def ramp(rate: float, at_s: float) -> Motion:
    return lambda t: rate * max(0.0, t - at_s)


def step(size: float, at_s: float) -> Motion:
    return lambda t: size if t >= at_s else 0.0


@pytest.mark.parametrize("inputs", [BAROMETER, INERTIAL])
def test_a_climb_of_30_metres_agrees(inputs: tuple[str, ...]) -> None:
    """15 m (1 - cos 0.2 t): up to 3 m/s and 0.6 m/s²."""
    sent = flight(
        60.0,
        height=lambda t: 15.0 * (1.0 - math.cos(0.2 * t)),
        climb=lambda t: 3.0 * math.sin(0.2 * t),
        felt=lambda t: 0.6 * math.cos(0.2 * t),
        inputs=inputs,
    )
    verdicts = run(sent)
    assert verdicts[-1].state is State.NORMAL
    assert max(one.margin for one in verdicts) < 0.2


def test_a_ramp_of_1_metre_per_second_against_the_barometer() -> None:
    """5 s of it are 5 m; the limit that a good receiver has earned is 2.9 m."""
    sent = flight(
        120.0,
        height=lambda t: min(max(0.0, t - 15.0), 10.0),
        climb=lambda t: 1.0 if 15.0 <= t < 25.0 else 0.0,
        offset=ramp(1.0, 100.0),
        offset_rate=step(1.0, 100.0),
    )
    verdicts = run(sent)
    assert verdicts[-200].values["barometer_limit"] == DEFAULT.baro_floor
    alarm = first_alarm_s(verdicts)
    assert alarm is not None
    assert 100.0 + 2.1 < alarm < 100.0 + 4.0
    last = verdicts[-1]
    assert last.state is State.ALARM
    assert last.reason.startswith("The GPS")
    assert last.values["difference"] == pytest.approx(20.0, abs=0.5)


def test_a_ramp_before_the_flight_has_the_limits_of_a_receiver_that_settles() -> None:
    """Only the 9 m in total are the same."""
    sent = flight(60.0, offset=ramp(1.0, 30.0), offset_rate=step(1.0, 30.0))
    alarm = first_alarm_s(run(sent))
    assert alarm is not None
    assert 30.0 + 8.0 < alarm < 30.0 + 11.0


@pytest.mark.parametrize("wash_m", [3.5, -3.5])
def test_a_barometer_in_the_wash_of_a_take_off_is_no_alarm(wash_m: float) -> None:
    """For a second, as one of the recorded flights has it; 12 Pa are a metre."""
    clean = flight(
        60.0,
        height=lambda t: min(max(0.0, t - 15.0), 10.0),
        climb=lambda t: 1.0 if 15.0 <= t < 25.0 else 0.0,
    )
    sent: Sent = [
        (name, PressureSample(one.stamp_ns, one.pressure_pa - 12.0 * wash_m))
        if isinstance(one, PressureSample) and 15.0 <= one.stamp_ns / SECOND < 16.0
        else (name, one)
        for name, one in clean
    ]
    assert first_alarm_s(run(sent)) is None


@pytest.mark.parametrize("size", [-20.0, -10.0, 10.0, 20.0])
@pytest.mark.parametrize("inputs", [BAROMETER, INERTIAL])
def test_a_step_is_told_within_two_seconds(inputs: tuple[str, ...], size: float) -> None:
    alarm = first_alarm_s(run(flight(45.0, offset=step(size, 40.0), inputs=inputs)))
    assert alarm is not None
    assert 40.0 < alarm <= 42.0


def test_a_step_stays_an_alarm_while_it_lasts_and_ends_with_it() -> None:
    sent = flight(150.0, offset=lambda t: 12.0 if 30.0 <= t < 120.0 else 0.0)
    by_time = {one.stamp_ns // MS: one for one in run(sent)}
    assert by_time[119_000].state is State.ALARM
    assert by_time[119_000].values["difference"] == pytest.approx(12.0, abs=0.2)
    assert abs(by_time[149_800].values["difference"]) < 0.2


def test_a_fast_ramp_is_told_without_a_barometer() -> None:
    """9 m/s built up in 3 s, which the accelerometer did not feel."""
    sent = flight(
        60.0,
        offset=lambda t: 1.5 * min(max(t - 40.0, 0.0), 3.0) ** 2 + 9.0 * max(0.0, t - 43.0),
        offset_rate=lambda t: 3.0 * min(max(t - 40.0, 0.0), 3.0),
        inputs=INERTIAL,
    )
    verdicts = run(sent)
    alarm = first_alarm_s(verdicts)
    assert alarm is not None
    assert 40.0 < alarm < 46.0
    assert "accelerometer" in verdicts[-1].reason
    assert "no barometer" in verdicts[-1].reason


def test_a_constant_bias_of_the_accelerometer_is_learnt() -> None:
    sent = flight(80.0, felt=lambda _: 0.25, inputs=INERTIAL)
    verdicts = run(sent)
    assert verdicts[-1].values["vertical_bias"] == pytest.approx(0.25, abs=0.05)
    assert first_alarm_s(verdicts) is None


def test_weather_is_followed_and_an_attack_is_not() -> None:
    """0.02 m/s for ten minutes is 12 m of pressure drift; 0.3 m/s is no weather."""
    sent = flight(600.0, offset=ramp(0.02, 0.0), inputs=("pressure", "velocity", "fix"))
    drift = run(sent)
    assert max(one.margin for one in drift) < 0.5
    slow = flight(120.0, offset=ramp(0.3, 30.0), inputs=("pressure", "velocity", "fix"))
    alarm = first_alarm_s(run(slow))
    assert alarm is not None
    assert alarm < 75.0


def test_an_hour_without_samples_is_no_change_within_a_minute() -> None:
    """A clock that was set, or a long outage: the weather has moved by 3 m meanwhile."""
    inputs = ("pressure", "velocity", "fix")
    before = flight(60.0, inputs=inputs)
    after = [
        (name, replace(sample, stamp_ns=sample.stamp_ns + 3600 * SECOND))
        for name, sample in flight(60.0, offset=lambda _: 3.0, inputs=inputs)
    ]
    margins = [one.margin for one in run(before + after)]
    assert max(margins) < 0.5
    assert margins[-1] < 0.1  # a new reference


def test_not_ready_until_the_reference_is_learnt() -> None:
    verdicts = run(flight(25.0, inputs=("pressure", "fix")))
    assert verdicts[0].state is State.NOT_READY
    assert "less than 10 s" in verdicts[0].reason
    ready = next(one for one in verdicts if one.state is State.NORMAL)
    assert ready.stamp_ns == pytest.approx(10.4 * SECOND, abs=0.3 * SECOND)


def test_without_barometer_and_attitude_it_is_not_observable() -> None:
    last = run(flight(40.0, inputs=INERTIAL, orientation=None))[-1]
    assert last.state is State.NOT_OBSERVABLE
    assert last.reason == "no barometer, attitude unknown"


def test_without_anything_but_fixes_it_is_not_ready() -> None:
    assert {one.state for one in run(flight(30.0, inputs=("fix",)))} == {State.NOT_READY}


@pytest.mark.parametrize("gone", ["pressure", "velocity", "attitude"])
def test_an_input_that_stops_is_told(gone: str) -> None:
    sent = [(name, one) for name, one in flight(50.0) if name != gone or one.stamp_ns < 40 * SECOND]
    last = run(sent)[-1]
    assert last.state is State.STALE
    assert gone in last.reason


def test_fixes_that_stop_are_told() -> None:
    sent = [
        (name, one) for name, one in flight(50.0) if name != "fix" or one.stamp_ns < 40 * SECOND
    ]
    last = run(sent)[-1]
    assert last.state is State.STALE
    assert last.reason.startswith("no fix for")


def test_an_attack_from_the_first_fix_does_not_blind_it() -> None:
    """The reference is learnt from a GPS that is 50 m off; the next step is told all the same."""
    sent = flight(60.0, offset=lambda t: 50.0 + (15.0 if t >= 40.0 else 0.0))
    alarm = first_alarm_s(run(sent))
    assert alarm is not None
    assert 40.0 < alarm < 42.0


def test_speed_and_a_climb_widen_the_limit_and_no_more_than_allowed() -> None:
    """At 100 m/s the dynamic head is 510 m; the allowance is 3 m."""
    check = BarometerCheck(replace(DEFAULT, learn_s=1.0, baro_total_m=100.0))
    findings = []
    for tick in range(100):
        stamp = tick * SECOND // 5
        check.pressure(PressureSample(stamp, pascal(100.0)))
        speed = 100.0 if tick >= 50 else 0.0
        fix = FixSample(stamp, 48.0, 11.0, 100.0 + (8.0 if tick >= 50 else 0.0))
        velocity = VelocitySample(stamp, (speed, 0.0, 0.0))
        part = check.part
        finding = check.fix(fix, velocity, airborne=True, frozen=False)
        findings.append((finding.margin if finding else 0.0, part))
    margin, part = findings[51]  # the first whose pressure, 0.2 s older, is of the same time
    assert margin == pytest.approx(8.0 / (part * 4.17 + 3.0), abs=0.02)


def in_phase(sent: Sent, phase: Phase, start_s: float, end_s: float) -> Sent:
    """The same flight with a phase twice a second, FLYING outside the given time."""
    told: Sent = []
    for half in range(round(sent[-1][1].stamp_ns / SECOND * 2)):
        now = phase if start_s <= half / 2 < end_s else Phase.FLYING
        told.append(("phase", PhaseSample(half * SECOND // 2, now, 0, "test", 50.0)))
    return sorted(told + sent, key=lambda one: one[1].stamp_ns)


def test_a_receiver_that_settles_before_take_off_is_no_alarm() -> None:
    """By 24 m in 15 s, on the ground and into the flight, as one of the recorded receivers."""
    sent = flight(120.0, offset=lambda t: 1.6 * min(max(0.0, t - 12.0), 15.0))
    verdicts = run(in_phase(sent, Phase.STANDING, 0.0, 22.0))
    assert first_alarm_s(verdicts) is None
    at_25 = next(one for one in verdicts if one.stamp_ns >= 25 * SECOND)
    assert at_25.state is State.NOT_READY
    assert "had not settled" in at_25.reason
    assert verdicts[-1].state is State.NORMAL


def test_on_the_ground_it_is_not_observable_and_a_step_in_the_hover_is_seen() -> None:
    sent = flight(80.0, offset=lambda t: 12.0 if t >= 60.0 else 0.0)
    verdicts = run(in_phase(sent, Phase.STANDING, 0.0, 20.0))
    at_15 = next(one for one in verdicts if one.stamp_ns >= 15 * SECOND)
    assert at_15.state is State.NOT_OBSERVABLE
    assert at_15.reason.startswith("not in flight")
    alarm = first_alarm_s(verdicts)
    assert alarm is not None
    assert 60.0 < alarm < 62.0


@pytest.mark.parametrize("gone", ["fix", "pressure"])
def test_the_reference_starts_anew_after_a_gap(gone: str) -> None:
    sent = flight(90.0, offset=lambda t: 15.0 if t >= 45.0 else 0.0)
    sent = [
        (name, one) for name, one in sent if name != gone or not 43 <= one.stamp_ns / SECOND < 47
    ]
    barometer = [one.values.get("barometer_margin", 0.0) for one in run(sent)]
    assert max(barometer) < 0.1


@pytest.mark.parametrize(
    ("gone", "on_the_ground", "seen"),
    [
        ("fix", False, True),
        ("fix", True, False),
        ("pressure", False, False),
        ("both", False, False),
    ],
)
def test_a_height_that_comes_back_far_off_is_seen_where_the_barometer_went_on(
    gone: str, on_the_ground: bool, seen: bool
) -> None:
    """35 m, where the worst receiver may be off by 24."""
    inputs = ("pressure", "velocity", "fix")
    sent = flight(90.0, offset=lambda t: 35.0 if t >= 45.0 else 0.0, inputs=inputs)
    names = ("fix", "pressure") if gone == "both" else (gone,)
    sent = [
        (name, one)
        for name, one in sent
        if name not in names or not 43 <= one.stamp_ns / SECOND < 47
    ]
    if on_the_ground:
        sent = in_phase(sent, Phase.STANDING, 42.0, 48.0)
    verdicts = run(sent)
    alarm = first_alarm_s(verdicts)
    assert (alarm is not None) is seen
    if alarm is not None:
        assert 47.0 <= alarm < 48.5
        reason = next(one.reason for one in verdicts if one.state is State.ALARM)
        assert reason.startswith("The GPS height came back +35.0 m off the barometer (limit 24.0)")


def test_without_vertical_velocity_and_height_nothing_is_made_up() -> None:
    """A climb of a vehicle whose receiver measures neither is no climb rate of 0."""
    sent = flight(60.0, height=ramp(2.0, 20.0), climb=step(2.0, 20.0))
    no_up: Sent = [
        (name, replace(one, velocity=(0.0, 0.0, math.nan)))
        if isinstance(one, VelocitySample)
        else (name, one)
        for name, one in sent
    ]
    verdicts = run(no_up)
    assert max(one.values.get("barometer_margin", 0.0) for one in verdicts) < 0.3
    assert all(math.isfinite(one.score) for one in verdicts)
    no_height: Sent = [
        (name, replace(one, altitude_m=math.nan)) if isinstance(one, FixSample) else (name, one)
        for name, one in sent
    ]
    last = run(no_height)[-1]
    assert last.state is State.NOT_OBSERVABLE
    assert last.reason == "no GPS height"


@settings(deadline=None, max_examples=15)
@given(st.floats(0.0, 1000.0))
def test_a_claim_widens_the_limits_within_bounds_only(claimed_m: float) -> None:
    sent: Sent = [
        (name, replace(one, vertical_accuracy_m=claimed_m))
        if isinstance(one, FixSample)
        else (name, one)
        for name, one in flight(50.0, inputs=("pressure", "fix"))
    ]
    part = run(sent)[-1].values["barometer_limit"]
    assert DEFAULT.baro_floor <= part <= DEFAULT.baro_ceiling


def test_vertical_force_of_a_body_that_is_rolled_over() -> None:
    """Rolled by 60°, which is more than the 55° allowed, then by 30°: cos 30° of 12 m/s² is up."""
    force = VerticalForce(55.0, 5.0)
    for ms in range(0, 1001, 20):
        roll = 60.0 if ms < 500 else 30.0
        half = math.radians(roll) / 2.0
        turn = (math.sin(half), 0.0, 0.0, math.cos(half))
        force.add(AttitudeSample(ms * MS, turn, 0.0, (0.0,) * 3, (0.0, 0.0, 12.0)))
        assert (force.why == "") == (ms >= 500)
    assert force.at(400 * MS) is None
    start, end = force.at(600 * MS), force.at(950 * MS)
    assert start is not None
    assert end is not None
    felt = 12.0 * math.cos(math.radians(30.0)) - 9.80665
    assert end.velocity - start.velocity == pytest.approx(0.35 * felt)


@settings(deadline=None, max_examples=25)
@given(st.floats(-5.0, 5.0), st.integers(0, 3))
def test_the_bank_finds_the_size_of_an_offset_without_noise(size: float, signature: int) -> None:
    """A filter that learns nothing (gain 0); only the first onset is old enough to be judged."""
    bank = HeightOffsets()
    h = np.array([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]])
    for tick in range(9):
        t = tick * 0.2
        shapes = [(0.5 * t * t, t), (t, 1.0), (t, 0.0), (1.0, 0.0)]
        offset = np.array(shapes[signature]) * size
        if tick == 0:
            offset = np.zeros(2)
        bank.update(t, np.eye(4), Innovation(h, offset, np.eye(2), np.zeros((4, 2))))
    found = bank.evidence()[signature]
    assert found.size == pytest.approx(size)
    assert found.age_s == pytest.approx(1.6)


def test_a_bag_of_garbled_heights_never_ends_it() -> None:
    sent = flight(30.0, offset=lambda t: 1e4 * math.sin(37.0 * t))
    for one in run(sent):
        assert math.isfinite(one.score)
        assert one.score >= 0.0


def test_the_same_samples_give_the_same_verdicts() -> None:
    sent = flight(40.0, offset=step(10.0, 30.0))
    assert run(sent) == run(sent)
