# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Specific force from GPS against the accelerometer, on motions worked out by hand."""

import itertools
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hijack_detect.detectors.date import DateDetector, DateParameters
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.attitude import AttitudeEstimator
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.simulation.flight import Flight
from hijack_detect.streams.samples import AttitudeSample, FixSample, Sample, VelocitySample

MS = 1_000_000
SECOND = 10**9
FAITHFUL = DateParameters(
    gps_lag_s=0.0,
    max_lag_s=0.0,
    persist_s=0.0,
    max_tilt_deg=180.0,
    noise_gain=0.0,
    max_force=1000.0,
)
GRAVITY_ENU = np.array([0.0, 0.0, -9.80665])
Vector = npt.NDArray[np.float64]
Motion = Callable[[float], Vector]
Sent = list[tuple[str, Sample]]
TILTED = Rotation.from_euler("ZYX", [30.0, 12.0, -8.0], degrees=True)


def tilted(_: float) -> Rotation:
    return TILTED


def nothing(_: float) -> Vector:
    return np.zeros(3)


def recording(
    seconds: float,
    acceleration: Motion,
    velocity: Motion,
    attitude: Callable[[float], Rotation],
    *,
    lag_s: float = 0.0,
) -> Sent:
    """IMU at 50 Hz and GPS velocity at 5 Hz of a motion, free of errors.

    The readings are those of the true acceleration; `velocity` is what the GPS reports.
    """
    sent: Sent = []
    for ms in range(0, round(seconds * 1000), 20):
        # A reading stands for the interval that ends with it.
        t = ms / 1000 - 0.01
        turn = attitude(t)
        force = turn.inv().apply(acceleration(t) - GRAVITY_ENU)
        q = tuple(attitude(ms / 1000 - 0.01).as_quat().tolist())
        sent.append(("attitude", AttitudeSample(ms * MS, q, 0.0, (0, 0, 0), tuple(force))))
        if ms % 200 == 0:
            reported = tuple(velocity(ms / 1000 - lag_s).tolist())
            sent.append(("velocity", VelocitySample(ms * MS, reported)))
    return sent


def run(parameters: DateParameters, sent: Sent) -> list[Verdict]:
    detector = DateDetector(parameters)
    verdicts = (detector.update(name, sample) for name, sample in sent)
    return [one for one in verdicts if one is not None]


def circle(t: float) -> tuple[Vector, Vector]:
    """Velocity and acceleration of a circle at 10 m/s, 0.5 rad/s: 5 m/s² inward."""
    c, s = math.cos(0.5 * t), math.sin(0.5 * t)
    return 10.0 * np.array([c, s, 0.0]), 5.0 * np.array([-s, c, 0.0])


def banked(t: float) -> Rotation:
    """The nose on the course, leaning into the turn."""
    return Rotation.from_euler("ZYX", [0.5 * t, 0.1, -math.atan2(5.0, 9.8)])


def test_a_circle_agrees_with_its_accelerometer() -> None:
    sent = recording(10.0, lambda t: circle(t)[1], lambda t: circle(t)[0], banked)
    verdicts = run(FAITHFUL, sent)
    judged = [one for one in verdicts if one.state is not State.NOT_READY]
    assert len(judged) > 30
    for one in judged:
        assert one.state is State.NORMAL
        assert one.score < 0.02
        assert abs(one.values["delta_az"]) < 0.05


def test_an_acceleration_of_2_east_shows_as_2_in_the_body_frame() -> None:
    """Turned into a body that is yawed by 30°, pitched by 12° and rolled by -8°."""
    sent = recording(6.0, nothing, lambda t: np.array([2.0 * t, 0.0, 0.0]), tilted)
    x, y, z = TILTED.inv().apply([2.0, 0.0, 0.0])
    judged = [one for one in run(FAITHFUL, sent) if one.state is not State.NOT_READY]
    for one in judged:
        assert one.values["delta_ax"] == pytest.approx(x, abs=1e-9)
        assert one.values["delta_ay"] == pytest.approx(y, abs=1e-9)
        assert one.values["delta_az"] == pytest.approx(z, abs=1e-9)
        assert one.score == pytest.approx(math.hypot(x, y), abs=1e-9)
        assert one.state is State.ALARM


def test_on_a_level_body_by_hand() -> None:
    """Nose to the North-East, 2 m/s² East: 1.41 forward and 1.41 to the right."""
    northeast = Rotation.from_euler("Z", 45.0, degrees=True)
    sent = recording(6.0, nothing, lambda t: np.array([2.0 * t, 0.0, 0.0]), lambda _: northeast)
    last = run(FAITHFUL, sent)[-1]
    assert last.values["delta_ax"] == pytest.approx(math.sqrt(2.0))
    assert last.values["delta_ay"] == pytest.approx(-math.sqrt(2.0))
    assert last.score == pytest.approx(2.0)
    assert last.margin == pytest.approx(2.0 / FAITHFUL.threshold)


def test_a_vehicle_at_rest_feels_minus_gravity() -> None:
    last = run(FAITHFUL, recording(6.0, nothing, nothing, tilted))[-1]
    assert last.state is State.NORMAL
    assert last.score == pytest.approx(0.0, abs=1e-9)


def test_a_mere_climb_is_not_horizontal() -> None:
    level = Rotation.identity()
    sent = recording(6.0, nothing, lambda t: np.array([0.0, 0.0, 3.0 * t]), lambda _: level)
    last = run(FAITHFUL, sent)[-1]
    assert last.score == pytest.approx(0.0, abs=1e-9)
    assert last.values["delta_az"] == pytest.approx(3.0)


@pytest.mark.parametrize(("threshold", "state"), [(1.9, State.ALARM), (2.1, State.NORMAL)])
def test_threshold(threshold: float, state: State) -> None:
    level = Rotation.identity()
    sent = recording(6.0, nothing, lambda t: np.array([0.0, 2.0 * t, 0.0]), lambda _: level)
    assert run(replace(FAITHFUL, threshold=threshold), sent)[-1].state is state


def test_the_mean_is_over_the_window() -> None:
    """Half of the window of 2 s after a kick of 3 m/s² began, Δa is half of it."""
    level = Rotation.identity()
    sent = recording(
        8.0, nothing, lambda t: np.array([3.0 * max(0.0, t - 4.0), 0.0, 0.0]), lambda _: level
    )
    scores = {one.stamp_ns // MS: one.score for one in run(FAITHFUL, sent)}
    assert scores[4000] == pytest.approx(0.0, abs=1e-9)
    assert scores[5000] == pytest.approx(1.5)
    assert scores[6000] == pytest.approx(3.0)


def test_the_lag_of_the_gps() -> None:
    """A swing of 4 m/s² in 4 s reported 0.4 s late: only the right lag makes it agree."""
    w = math.tau / 4.0

    def velocity(t: float) -> Vector:
        return np.array([4.0 / w * math.sin(w * t), 0.0, 0.0])

    def acceleration(t: float) -> Vector:
        return np.array([4.0 * math.cos(w * t), 0.0, 0.0])

    sent = recording(12.0, acceleration, velocity, tilted, lag_s=0.4)
    right = max(one.score for one in run(replace(FAITHFUL, gps_lag_s=0.4), sent))
    wrong = max(one.score for one in run(FAITHFUL, sent))
    assert right < 0.02
    assert wrong > 1.0


def test_a_gap_of_the_gps_is_told_and_not_compared() -> None:
    level = Rotation.identity()
    whole = recording(12.0, nothing, lambda t: np.array([4.0 * t, 0.0, 0.0]), lambda _: level)
    gapped = [one for one in whole if one[0] != "velocity" or not 5.0 < stamp_s(one[1]) < 9.5]
    verdicts = run(FAITHFUL, gapped)
    during = [one for one in verdicts if 5 * SECOND < one.stamp_ns < 9.5 * SECOND]
    assert {one.state for one in during} == {State.STALE}
    assert [round(one.stamp_ns / SECOND) for one in during] == [7, 8, 9]
    after = [one for one in verdicts if one.stamp_ns > 9.5 * SECOND]
    assert next(one.state for one in after if one.state is not State.STALE) is State.NOT_READY
    assert after[-1].state is State.ALARM


def test_a_pause_of_the_imu_is_told() -> None:
    whole = recording(12.0, nothing, lambda t: np.array([4.0 * t, 0.0, 0.0]), tilted)
    gapped = [one for one in whole if one[0] != "attitude" or not 5.0 < stamp_s(one[1]) < 9.0]
    states = {one.stamp_ns // MS: one.state for one in run(FAITHFUL, gapped)}
    assert {states[ms] for ms in range(7200, 9000, 200)} == {State.STALE}
    assert states[9600] is State.NOT_READY
    assert states[11800] is State.ALARM


def stamp_s(sample: Sample) -> float:
    return sample.stamp_ns / SECOND


def test_not_ready_before_the_window_is_filled() -> None:
    verdicts = run(FAITHFUL, recording(6.0, nothing, nothing, tilted))
    assert [one.state for one in verdicts[:8]] == [State.NOT_READY] * 8
    assert {one.state for one in verdicts[11:]} == {State.NORMAL}


@settings(deadline=None, max_examples=40)
@given(st.floats(0.2, 6.0), st.integers(1, 10))
def test_it_gets_ready_whatever_the_window_and_the_rate_of_the_gps(
    window_s: float, every: int
) -> None:
    """A window that no number of GPS intervals fills would be a gate that never fires."""
    sent = recording(12.0, nothing, nothing, tilted)
    velocities = [entry for entry in sent if entry[0] == "velocity"]
    kept = {id(entry) for entry in velocities[::every]}
    thinned = [entry for entry in sent if entry[0] != "velocity" or id(entry) in kept]
    parameters = replace(FAITHFUL, window_s=window_s, max_gap_s=3.0)
    ready = [one for one in run(parameters, thinned) if one.state is State.NORMAL]
    assert ready
    assert ready[0].stamp_ns <= (window_s + 2 * 0.2 * every) * SECOND


def test_not_ready_without_orientation() -> None:
    sent = [
        (name, replace(one, orientation=None) if isinstance(one, AttitudeSample) else one)
        for name, one in recording(6.0, nothing, lambda t: np.array([9.0 * t, 0, 0]), tilted)
    ]
    verdicts = run(FAITHFUL, sent)
    assert len(verdicts) == 30
    assert {one.state for one in verdicts} == {State.NOT_READY}


def test_not_ready_without_imu() -> None:
    sent = recording(6.0, nothing, lambda t: np.array([9.0 * t, 0.0, 0.0]), tilted)
    verdicts = run(FAITHFUL, [one for one in sent if one[0] == "velocity"])
    assert {one.state for one in verdicts} == {State.NOT_READY}


def test_the_difference_must_persist() -> None:
    def kick(t: float) -> Vector:
        return np.array([4.0 * max(0.0, t - 5.0), 0.0, 0.0])

    sent = recording(10.0, nothing, kick, tilted)
    at_once = next(one for one in run(FAITHFUL, sent) if one.state is State.ALARM)
    verdicts = run(replace(FAITHFUL, persist_s=1.0), sent)
    first = next(one for one in verdicts if one.state is State.ALARM)
    assert first.stamp_ns - at_once.stamp_ns == SECOND
    waiting = [one for one in verdicts if at_once.stamp_ns <= one.stamp_ns < first.stamp_ns]
    assert {one.state for one in waiting} == {State.SUSPICIOUS}


def test_a_tumbling_body_is_not_observable() -> None:
    def tumbling(t: float) -> Rotation:
        return Rotation.from_euler("Y", 80.0 if 5.0 <= t < 5.5 else 10.0, degrees=True)

    sent = recording(12.0, nothing, lambda t: np.array([6.0 * t, 0.0, 0.0]), tumbling)
    states = {
        one.stamp_ns // MS: one.state for one in run(replace(FAITHFUL, max_tilt_deg=75.0), sent)
    }
    assert states[5000] is State.ALARM
    assert {states[ms] for ms in range(5200, 7400, 200)} == {State.NOT_OBSERVABLE}
    assert states[7800] is State.ALARM
    assert run(FAITHFUL, sent)[30].state is State.ALARM


def test_with_a_velocity_the_fixes_are_not_used() -> None:
    level = Rotation.identity()
    sent = recording(6.0, nothing, lambda t: np.array([2.0 * t, 0.0, 0.0]), lambda _: level)
    fixes = [("fix", FixSample(ms * MS, 48.0, 11.0, 0.0)) for ms in range(100, 6000, 200)]
    both = sorted([*sent, *fixes], key=lambda one: one[1].stamp_ns)
    assert run(FAITHFUL, both) == run(FAITHFUL, sent)


def test_fixes_take_over_when_the_velocities_stop(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    curved = flight("curved", 1)
    sent = attitudes_and(samples, curved, "fix", "velocity")
    cut_ns = curved.plan.start_ns + 50 * SECOND
    lost = [one for one in sent if one[0] != "velocity" or one[1].stamp_ns < cut_ns]
    verdicts = run(DateParameters(), lost)
    later = [one for one in verdicts if one.stamp_ns > cut_ns + 6 * SECOND]
    assert len(later) > 150
    assert {one.state for one in later} == {State.NORMAL}
    stamps = [one.stamp_ns for one in verdicts if one.stamp_ns > cut_ns - SECOND]
    assert max(b - a for a, b in itertools.pairwise(stamps)) < 2.5 * SECOND


def test_fixes_before_the_first_velocity_do_not_count_once_it_is_there() -> None:
    """A lost fix returns, and its velocities a second later: coarse fixes are no acceleration."""
    level = Rotation.identity()
    sent = recording(12.0, nothing, nothing, lambda _: level)
    sent = [one for one in sent if one[0] == "attitude" or not 4 <= one[1].stamp_ns / SECOND < 8.2]
    for ms in range(0, 12_000, 200):
        east_deg = 11.0 + 1e-5 * (ms // 400 % 2)
        fix = FixSample(ms * MS, 48.0, east_deg, 500.0, has_fix=not 4000 <= ms < 7000)
        sent.append(("fix", fix))
    sent.sort(key=lambda one: (one[1].stamp_ns, ("attitude", "fix", "velocity").index(one[0])))
    judged = [one for one in run(FAITHFUL, sent) if one.values]
    assert {one.stamp_ns // SECOND for one in judged} >= {2, 3, 10, 11}
    assert max(one.score for one in judged) < 0.01


def attitudes_and(samples: Callable[..., Sent], flight: Flight, *names: str) -> Sent:
    """The estimator's attitudes of a flight, with some GPS inputs, in order of stamp."""
    estimator = AttitudeEstimator(AttitudeParameters())
    sent: Sent = []
    for name, sample in samples(flight, "imu", "fix", "velocity", "mag"):
        attitude = estimator.update(name, sample)
        if attitude is not None:
            sent.append(("attitude", attitude))
        if name in names:
            sent.append((name, sample))
    return sent


def test_velocities_and_fixes_alone_agree_on_a_flight(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    curved = flight("curved", 1)
    by_velocity = run(DateParameters(), attitudes_and(samples, curved, "velocity"))
    by_fixes = {
        one.stamp_ns: one for one in run(DateParameters(), attitudes_and(samples, curved, "fix"))
    }
    apart = []
    for one in by_velocity:
        other = by_fixes.get(one.stamp_ns)
        if one.values and other is not None and other.values:
            apart.append([one.values[k] - other.values[k] for k in ("delta_ax", "delta_ay")])
    assert len(apart) > 300
    assert np.sqrt(np.mean(np.square(apart))) < 0.4
    assert max(one.score for one in by_velocity) < 1.2


def test_verdicts_are_numbers_after_a_lost_fix() -> None:
    fixes: Sent = []
    for ms in range(0, 8000, 200):
        lost = 3000 <= ms < 3400
        place = (0.0, 0.0, 0.0) if lost else (48.0 + 1e-8 * ms, 11.0, 500.0)
        fixes.append(("fix", FixSample(ms * MS, *place, has_fix=not lost)))
    attitudes = [one for one in recording(8.0, nothing, nothing, tilted) if one[0] == "attitude"]
    sent = sorted([*attitudes, *fixes], key=lambda one: one[1].stamp_ns)
    for one in run(FAITHFUL, sent):
        assert one.score < 0.5


def swaying(size: float, attack_s: float = math.inf) -> Sent:
    """A level body whose GPS velocity sways, and from a time on gains 2 m/s² to the East."""

    def velocity(t: float) -> Vector:
        slow = size * np.sin(0.5 * t) / 0.5
        return np.array([slow + 2.0 * max(t - attack_s, 0.0), 0.0, 0.0])

    return recording(100.0, nothing, velocity, lambda _: Rotation.identity())


def test_the_limit_is_learnt_from_the_flight() -> None:
    """A sway of ±0.4 m/s² has 0.28 RMS; its means over 2 s have sin(0.5)/0.5 of that."""
    verdicts = run(DateParameters(), swaying(0.4))
    told = [one for one in verdicts if one.state is not State.NOT_READY]
    assert {one.state for one in told} == {State.NORMAL}
    rms = 0.4 * math.sqrt(0.5) * math.sin(0.5) / 0.5
    assert told[-1].threshold == pytest.approx(6.2 * rms, rel=0.05)
    assert told[0].stamp_ns == pytest.approx(22 * SECOND, abs=SECOND)


def test_a_smooth_flight_has_the_least_limit_and_sees_less() -> None:
    verdicts = run(DateParameters(), swaying(0.001, 90.0))
    before = [one for one in verdicts if one.stamp_ns < 90 * SECOND]
    assert before[-1].threshold < 6.2 * 0.35
    assert verdicts[-1].state is State.ALARM
    assert not any(one.state is State.ALARM for one in before)


def test_a_receiver_that_gets_worse_within_seconds_is_no_alarm() -> None:
    """From ±0.15 to ±1.2 m/s² within 20 s; 60 s of memory alone would lag behind."""

    def velocity(t: float) -> Vector:
        size = np.interp(t, [0.0, 60.0, 70.0, 80.0], [0.15, 0.15, 0.5, 1.2])
        return np.array([size * np.sin(1.5 * t) / 1.5, 0.0, 0.0])

    verdicts = run(
        DateParameters(), recording(100.0, nothing, velocity, lambda _: Rotation.identity())
    )
    assert {one.state for one in verdicts} <= {State.NOT_READY, State.NORMAL}
    margins = [one.margin for one in verdicts if one.stamp_ns > 60 * SECOND]
    assert 0.4 < max(margins) < 0.95


def test_an_attack_that_alarms_is_not_learnt() -> None:
    verdicts = run(DateParameters(), swaying(0.1, 50.0))
    alarms = [one for one in verdicts if one.state is State.ALARM]
    assert alarms[0].stamp_ns < 53 * SECOND
    assert alarms[-1].stamp_ns == verdicts[-1].stamp_ns
    assert alarms[-1].threshold <= alarms[0].threshold


def test_after_a_violent_force_it_cannot_tell() -> None:
    sent = swaying(0.1)
    at = next(i for i, (_, one) in enumerate(sent) if one.stamp_ns == 40 * SECOND)
    _, sample = sent[at]
    assert isinstance(sample, AttitudeSample)
    sent[at] = ("attitude", replace(sample, specific_force=(0.0, 0.0, 60.0)))
    states = {round(one.stamp_ns / SECOND, 1): one.state for one in run(DateParameters(), sent)}
    assert states[39.8] is State.NORMAL
    assert {states[t] for t in (40.2, 55.0, 69.8)} == {State.NOT_OBSERVABLE}
    assert states[71.0] is State.NORMAL


WEAVE_S = 8.0


def weaving(extra_s: Callable[[float], float], pull: float = 0.0, from_s: float = math.inf) -> Sent:
    """A swing of 3 m/s² in 8 s and of a tenth of it in 1.3 s, by a GPS that is late.

    Args:
        extra_s: Lag beyond the usual one at each time, s.
        pull: Acceleration to the East that only the GPS has, m/s².
        from_s: When it begins.
    """
    swings = ((3.0, math.tau / WEAVE_S), (0.3, math.tau / 1.3))

    def velocity(t: float) -> Vector:
        return np.array([sum(a / w * math.sin(w * t) for a, w in swings), 0.0, 0.0])

    def acceleration(t: float) -> Vector:
        return np.array([sum(a * math.cos(w * t) for a, w in swings), 0.0, 0.0])

    def reported(t: float) -> Vector:
        pulled = np.array([pull * max(0.0, t - from_s), 0.0, 0.0])
        return velocity(t - 0.15 - extra_s(t)) + pulled

    return recording(100.0, acceleration, reported, lambda _: Rotation.identity())


def grown(t: float, size: float = 1.0, over_s: float = 10.0) -> float:
    """Nothing until 50 s, then up to a size."""
    return size * min(1.0, max(0.0, (t - 50.0) / over_s))


@pytest.mark.parametrize(("size", "over_s"), [(0.4, 10.0), (1.0, 10.0), (1.2, 20.0), (1.0, 45.0)])
def test_a_gps_that_gets_late_is_named_and_no_alarm(size: float, over_s: float) -> None:
    sent = weaving(lambda t: grown(t, size, over_s))
    verdicts = run(DateParameters(), sent)
    assert {one.state for one in verdicts} <= {State.NOT_READY, State.NORMAL}
    assert all("late_gps" not in one.values for one in verdicts if one.stamp_ns < 50 * SECOND)
    if size >= 1.0:
        assert 0.15 + size - 0.55 < verdicts[-1].values["late_gps"] < 0.15 + size
        assert "the GPS is late: lags by" in verdicts[-1].reason
    unfollowed = run(replace(DateParameters(), max_lag_s=0.0), sent)
    assert max(one.margin for one in unfollowed) > max(one.margin for one in verdicts)


def test_a_latency_that_falls_at_once_is_no_alarm() -> None:
    sent = weaving(lambda t: grown(t) if t < 75.0 else 0.0)
    verdicts = run(DateParameters(), sent)
    assert State.ALARM not in {one.state for one in verdicts}
    assert max(one.values["late_gps"] for one in verdicts if "late_gps" in one.values) > 0.8
    assert "late_gps" not in verdicts[-1].values


def test_who_delays_first_buys_no_silence() -> None:
    """A pull of 2 m/s² is seen as soon with a GPS that is late by 1 s as with one that is not."""
    on_time = run(DateParameters(), weaving(lambda _: 0.0, 2.0, 80.0))
    late = run(DateParameters(), weaving(grown, 2.0, 80.0))
    first, then = (
        next(one.stamp_ns for one in verdicts if one.state is State.ALARM) / SECOND
        for verdicts in (on_time, late)
    )
    assert 80.0 < first < 84.0
    assert 80.0 < then < 84.0


def test_the_usual_difference_is_not_raised_by_a_lag_that_has_grown() -> None:
    late = run(DateParameters(), weaving(grown))
    assert late[-1].threshold < 6.2 * 0.35


def test_stamps_that_jump_back_and_forth_are_no_acceleration() -> None:
    """Velocities of a straight flight that gains speed, every other one 0.15 s late."""
    level = Rotation.identity()
    sent = recording(
        60.0,
        lambda _: np.array([0.5, 0.0, 0.0]),
        lambda t: np.array([0.5 * t, 0.0, 0.0]),
        lambda _: level,
        lag_s=0.15,
    )
    moved: Sent = []
    for name, one in sent:
        late = name == "velocity" and one.stamp_ns // (200 * MS) % 2
        moved.append((name, replace(one, stamp_ns=one.stamp_ns + 150 * MS) if late else one))
    moved.sort(key=lambda one: (one[1].stamp_ns, one[0] == "velocity"))
    judged = [one for one in run(DateParameters(), moved) if one.state is State.NORMAL]
    assert len(judged) > 80
    assert max(one.score for one in judged) < 0.15
