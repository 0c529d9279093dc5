# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The consistency checks on motions worked out by hand, each attack and its innocent likeness."""

import dataclasses
import itertools

import pytest
from gnss_stream import SECOND, START_NS, Sent, fix, flight, run, seconds, velocity
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.detectors.gnss_sanity import GnssSanityDetector, GnssSanityParameters
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.streams.samples import Phase, PhaseSample, SatelliteSample, Vector3

CALM = {State.NOT_READY, State.NORMAL}


def first(verdicts: list[Verdict], state: State) -> Verdict:
    return next(one for one in verdicts if one.state is state)


def states(verdicts: list[Verdict]) -> set[State]:
    return {one.state for one in verdicts}


def test_a_steady_flight_is_normal_and_has_every_margin() -> None:
    verdicts = run(flight(40.0))
    assert verdicts[0].state is State.NOT_READY
    assert states(verdicts[1:]) == {State.NORMAL}
    values = verdicts[-1].values
    assert {"jump", "freeze", "time", "publishers", "velocity_mismatch", "speed"} <= set(values)
    assert values["speed"] == pytest.approx(5.0 / 48.0, rel=1e-3)


def test_a_poor_receiver_is_named_and_no_state_follows() -> None:
    """In NORMAL, SUSPICIOUS and ALARM; an attacker jams first."""

    def offset(t: float) -> Vector3:
        return (5.0 * (t >= 15.0) + 20.0 * (t >= 18.0), 0.0, 0.0)

    good = flight(20.0, offset)
    bad = [
        (name, dataclasses.replace(one, accuracy_m=9.0) if name == "fix" else one)
        for name, one in good
    ]
    said, usual = run(bad, accuracy_gain=0.0), run(good, accuracy_gain=0.0)
    assert [one.state for one in said] == [one.state for one in usual]
    words = "; the receiver is poor by its own word: claims an accuracy of 9.0 m"
    late = [one for one in said if seconds(one) > 5.0]
    assert states(late) == {State.NORMAL, State.SUSPICIOUS, State.ALARM}
    for one in late:
        assert one.reason.endswith(words)
        assert one.reason.count(words) == 1
        assert one.values["poor_accuracy"] == 9.0
    assert not any("poor" in one.reason or "poor_accuracy" in one.values for one in usual)


@pytest.mark.parametrize("repeated", [False, True])
def test_silence_is_a_lost_fix_and_a_stamp_that_stands_still_is_none(repeated: bool) -> None:
    """In both velocities go on; the message of 10 s may come again and again."""
    sent = flight(40.0)
    at_10_s = next(
        one for name, one in sent if name == "fix" and one.stamp_ns == START_NS + 10 * SECOND
    )
    late = [
        (name, one if name == "velocity" else at_10_s)
        for name, one in sent
        if one.stamp_ns > at_10_s.stamp_ns and (name == "velocity" or repeated)
    ]
    said = run([*(pair for pair in sent if pair[1].stamp_ns <= at_10_s.stamp_ns), *late])
    assert said[-1].state is State.STALE
    assert ("no fix for 28 s of a minute" in said[-1].reason) is not repeated
    assert ("poor_no_fix" in said[-1].values) is not repeated


def test_a_clock_of_another_rate_is_named_and_no_state_follows() -> None:
    slow = [
        (name, dataclasses.replace(one, stamp_ns=START_NS + (one.stamp_ns - START_NS) * 12 // 13))
        for name, one in flight(40.0)
    ]
    said = run(slow)
    assert states(said[1:]) == {State.NORMAL}
    assert said[-1].reason.endswith("; the clock of the stamps runs 7.7 % slow")
    assert said[-1].values["clock_rate"] == pytest.approx(13 / 12, abs=1e-3)
    assert not any("clock" in one.reason for one in run(flight(40.0)))


@pytest.mark.parametrize(
    ("metres", "expected"), [(2.0, State.NORMAL), (5.0, State.SUSPICIOUS), (20.0, State.ALARM)]
)
def test_a_jump_is_judged_by_its_size_at_once(metres: float, expected: State) -> None:
    verdicts = run(flight(20.0, lambda t: (metres if t >= 10.0 else 0.0, 0.0, 0.0)))
    at = next(one for one in verdicts if seconds(one) == 10.0)
    assert at.state is expected
    assert at.values["jump"] == pytest.approx(max(metres / 15.15, (metres > 3.0) / 3), rel=1e-3)
    if expected is State.NORMAL:
        assert states(verdicts[1:]) == {State.NORMAL}
    else:
        assert at.reason.startswith(f"jump: position jumped by {metres:.1f} m")
        held = [seconds(one) for one in verdicts if one.state is expected]
        assert held[-1] == 12.0
        assert verdicts[-1].state is State.NORMAL


def test_a_jump_in_three_steps_does_not_slip_through() -> None:
    verdicts = run(flight(20.0, lambda t: (min(3, max(0.0, (t - 9.6) // 0.39)) * 1.5, 0.0, 0.0)))
    assert State.SUSPICIOUS in states(verdicts)
    assert State.ALARM not in states(verdicts)


def test_three_jumps_in_5_s_are_an_alarm() -> None:
    verdicts = run(flight(20.0, lambda t: (4.0 * min(3, max(0, (t - 8.0) // 1.5)), 0.0, 0.0)))
    assert "3 times in 5 s" in first(verdicts, State.ALARM).reason


def test_coming_back_after_an_outage_some_metres_off_is_quiet() -> None:
    sent = [one for one in flight(60.0, lambda t: (8.0 * (t > 25.0), 0.0, 0.0))]
    kept = [one for one in sent if not 10.0 < (one[1].stamp_ns - START_NS) / SECOND < 30.0]
    assert states(run(kept)) <= {*CALM, State.STALE}


def test_position_carried_off_while_the_velocity_is_left_alone() -> None:
    """0.4 m/s² up to 2 m/s: 5 m after 5 s, 11 m after 8 s."""

    def offset(t: float) -> Vector3:
        s = max(0.0, t - 60.0)
        return (0.2 * s * s if s < 5.0 else 5.0 + 2.0 * (s - 5.0), 0.0, 0.0)

    verdicts = run(flight(75.0, offset))
    alarm = first(verdicts, State.ALARM)
    assert alarm.reason.startswith("velocity_mismatch: position off")
    assert 62.0 < seconds(alarm) < 66.0
    assert alarm.values["velocity_mismatch_limit"] < 0.4


@pytest.mark.parametrize(("starts_s", "alarms"), [(5.0, False), (25.0, True)])
def test_a_receiver_that_wanders_on_the_ground_is_no_alarm_after_take_off(
    starts_s: float, alarms: bool
) -> None:
    """20 m at 1.5 m/s without a velocity that says so; the vehicle takes off at 20 s."""
    sent = flight(45.0, lambda t: (min(20.0, max(0.0, 1.5 * (t - starts_s))), 0.0, 0.0))
    for half in range(90):
        phase = Phase.STANDING if half < 40 else Phase.FLYING
        stamp_ns = START_NS + half * SECOND // 2
        sent.append(("phase", PhaseSample(stamp_ns, phase, stamp_ns, "test", 50.0)))
    verdicts = run(sorted(sent, key=lambda one: one[1].stamp_ns))
    found = [one for one in verdicts if one.state is State.ALARM]
    assert bool(found) is alarms
    assert all(seconds(one) > starts_s for one in found)


def test_training_the_limits_up_is_slow_and_published() -> None:
    def wander(t: float) -> Vector3:
        s = max(0.0, t - 100.0)
        return (min(0.9, s * 0.1) * s % 18.0 / 9.0, 0.0, 0.0)

    parts = [
        one.values["velocity_mismatch_limit"] for one in run(flight(160.0, wander)) if one.values
    ]
    rises = [after - before for before, after in itertools.pairwise(parts)]
    assert max(rises) <= 0.005 * 0.2 + 1e-9
    assert parts[-1] <= 1.0


@pytest.mark.parametrize("told", ["frozen", "zero", "true", "absent"])
def test_a_frozen_stream_is_found_within_2_s(told: str) -> None:
    sent: Sent = []
    for name, true in flight(20.0, velocities=told != "absent"):
        sample = true
        frozen = sample.stamp_ns > START_NS + 10 * SECOND
        if name == "fix" and frozen:
            sample = dataclasses.replace(fix(10.0, (0.0, 50.0, 0.0)), stamp_ns=sample.stamp_ns)
        if name == "velocity" and frozen and told == "zero":
            sample = dataclasses.replace(sample, velocity=(0.0, 0.0, 0.0))
        sent.append((name, sample))
    alarm = first(run(sent), State.ALARM)
    assert alarm.reason.startswith("freeze: position repeats")
    assert seconds(alarm) <= 12.0


def test_a_receiver_that_holds_still_at_rest_is_normal() -> None:
    assert states(run(flight(30.0, speed=0.0))) <= CALM


def test_impossible_speed() -> None:
    sent = flight(20.0)
    at = next(i for i, one in enumerate(sent) if one[1].stamp_ns == START_NS + 10 * SECOND)
    sent[at] = ("velocity", velocity(10.0, (0.0, 60.0, 0.0)))
    assert first(run(sent), State.ALARM).reason.startswith(("speed: speed 60.0", "acceleration"))


def test_a_step_of_height() -> None:
    verdicts = run(flight(20.0, lambda t: (0.0, 0.0, 30.0 * (t >= 10.0))))
    assert first(verdicts, State.ALARM).reason.startswith("vertical: height jumped by 30.0 m")


def test_satellites_and_claimed_accuracy_are_suspicious_at_most() -> None:
    detector = GnssSanityDetector(GnssSanityParameters())
    verdicts = []
    for index in range(100):
        t = index / 5
        detector.update("velocity", velocity(t, (0.0, 5.0, 0.0)))
        count = 9 + 10 * (index % 2) if index > 50 else 9
        detector.update("satellites", SatelliteSample(START_NS + index * SECOND // 5, count))
        accuracy = 1.0 if index < 50 or index % 2 else 4.0
        verdicts.append(detector.update("fix", fix(t, (0.0, 5.0 * t, 0.0), accuracy)))
    told = [one for one in verdicts if one is not None]
    assert states(told) == {State.NOT_READY, State.NORMAL, State.SUSPICIOUS}
    assert told[-1].values["satellites"] == told[-1].values["covariance"] == 0.9


def test_two_interleaved_publishers() -> None:
    sent = flight(10.0)
    for index in range(50, 100):
        t = index / 5
        sent.append(("velocity", velocity(t, (0.0, 5.0, 0.0))))
        sent.append(("fix", fix(t, (0.0, 5.0 * t, 0.0))))
        sent.append(("fix", fix(t + 0.1, (10.0, 5.0 * (t + 0.1), 0.0))))
    verdicts = run(sent)
    assert State.ALARM in states(verdicts)
    assert any(one.reason.startswith("publishers: position alternates") for one in verdicts)


@pytest.mark.parametrize(("metres", "worst"), [(0.0, State.SUSPICIOUS), (10.0, State.ALARM)])
def test_repeated_stamps(metres: float, worst: State) -> None:
    """Copies may come from a bridge that publishes twice; other positions may not."""
    sent: Sent = []
    for name, sample in flight(20.0):
        sent.append((name, sample))
        t = (sample.stamp_ns - START_NS) / SECOND
        if name == "fix" and 10.0 <= t < 14.0:
            copy = fix(t, (metres, 5.0 * t, 0.0))
            sent.append((name, dataclasses.replace(sample) if metres == 0.0 else copy))
    verdicts = run(sent)
    assert (State.ALARM in states(verdicts)) is (worst is State.ALARM)
    assert any(one.reason.startswith("time: ") for one in verdicts)
    assert verdicts[-1].state is State.NORMAL


def test_fixes_that_were_overtaken_are_no_alarm() -> None:
    """A radio link that swaps every fourth fix with the next one, but none is from before that."""
    sent = flight(20.0)
    places = [place for place, (name, _) in enumerate(sent) if name == "fix"]
    for one, other in zip(places[8::4], places[9::4], strict=False):
        sent[one], sent[other] = sent[other], sent[one]
    verdicts = run(sent)
    assert State.ALARM not in states(verdicts)
    assert State.SUSPICIOUS in states(verdicts)
    assert any("(0 of them neither copies, nor overtaken," in one.reason for one in verdicts)


def set_by(shift_s: float, offset_m: float = 0.0) -> Sent:
    """A flight with 20 m/s whose clock is set at 10 s; from then on the position is off."""
    shift_ns, at_ns = round(shift_s * SECOND), START_NS + 10 * SECOND
    sent = flight(20.0, lambda t: (offset_m if t >= 10.0 else 0.0, 0.0, 0.0), speed=20.0)
    return [
        (name, dataclasses.replace(one, stamp_ns=one.stamp_ns + shift_ns * (one.stamp_ns >= at_ns)))
        for name, one in sent
    ]


@pytest.mark.parametrize("shift_s", [-3.0, -1.0, 1.0, 1.7])
def test_a_clock_that_is_set_makes_no_jump(shift_s: float) -> None:
    verdicts = run(set_by(shift_s))
    assert State.ALARM not in states(verdicts)
    assert not any(one.reason.startswith("jump") for one in verdicts)
    assert verdicts[-1].state is State.NORMAL


def test_a_clock_set_forward_hides_no_jump_to_the_side() -> None:
    assert first(run(set_by(1.0, 60.0)), State.ALARM).reason.startswith("jump")


def test_after_a_clock_was_set_back_jumps_are_seen_at_the_first_fix_in_order() -> None:
    sent = set_by(-1.0)
    before, *after = [at for at, (name, _) in enumerate(sent) if name == "fix"][49:]
    caught_up = next(at for at in after if sent[at][1].stamp_ns > sent[before][1].stamp_ns)
    _, place = sent[caught_up]
    sent[caught_up] = ("fix", dataclasses.replace(place, latitude_deg=place.latitude_deg + 0.001))
    assert any(one.reason.startswith("jump: position jumped by 11") for one in run(sent))


def test_what_is_said_of_stamps_does_not_depend_on_arrival() -> None:
    sent: Sent = []
    for name, sample in flight(20.0):
        sent.append((name, sample))
        if name == "fix" and (sample.stamp_ns - START_NS) // SECOND == 10:
            sent.append((name, sample))
    late = [one for one in sent if one[0] == "fix"], [one for one in sent if one[0] == "velocity"]
    behind: Sent = []
    for index, (name, sample) in enumerate(late[0]):
        behind.append((name, sample))
        if 3 <= index < 3 + len(late[1]):
            behind.append(late[1][index - 3])
    behind += late[1][len(late[0]) - 3 :]
    said = {one.stamp_ns: one for one in run(sent)}
    again = {one.stamp_ns: one for one in run(behind)}
    both = said.keys() & again.keys()
    assert len(both) > 90
    assert all(said[stamp] == again[stamp] for stamp in both)


def test_no_fix_and_a_stopped_fix_are_said() -> None:
    sent = flight(10.0)
    lost = dataclasses.replace(fix(10.0, (0.0, 0.0, 0.0)), has_fix=False)
    sent.append(("velocity", velocity(10.0, (0.0, 5.0, 0.0))))
    sent.append(("fix", lost))
    for index in range(51, 90):
        sent.append(("velocity", velocity(index / 5, (0.0, 5.0, 0.0))))
    verdicts = run(sent)
    assert first(verdicts, State.NOT_OBSERVABLE).reason == "the receiver has no fix"
    assert verdicts[-1].state is State.STALE


@settings(max_examples=40)
@given(
    st.lists(
        st.tuples(st.floats(-80, 80), st.floats(-180, 180), st.floats(-900, 40_000), st.booleans()),
        min_size=1,
        max_size=20,
    )
)
def test_it_survives_every_sample(places: list[tuple[float, float, float, bool]]) -> None:
    sent: Sent = []
    for index, (latitude, longitude, altitude, has_fix) in enumerate(places):
        one = fix(index / 5, (0.0, 0.0, 0.0))
        sent.append(
            (
                "fix",
                dataclasses.replace(
                    one,
                    latitude_deg=latitude,
                    longitude_deg=longitude,
                    altitude_m=altitude,
                    has_fix=has_fix,
                ),
            )
        )
    for verdict in run(sent):
        assert verdict.score >= 0.0
        assert verdict.reason
