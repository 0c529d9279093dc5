# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A step of position that is not taken back."""

from collections.abc import Callable
from dataclasses import replace

import pytest
from gnss_stream import SECOND, START_NS, Sent, flight, run, seconds
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.streams.samples import Phase, PhaseSample, Vector3

JUMP_S = 30.0


def step(metres: float, back_s: float = 1e9) -> Callable[[float], Vector3]:
    """To the East at JUMP_S, and back after a time."""
    return lambda t: (metres if JUMP_S <= t < JUMP_S + back_s else 0.0, 0.0, 0.0)


def claiming(sent: Sent, accuracy_m: Callable[[float], float]) -> Sent:
    """With a claimed accuracy."""
    return [
        (name, replace(one, accuracy_m=accuracy_m(index / 10)) if name == "fix" else one)
        for index, (name, one) in enumerate(sent)
    ]


def alarms(verdicts: list[Verdict]) -> list[float]:
    """Seconds after the step."""
    return [seconds(one) - JUMP_S for one in verdicts if one.state is State.ALARM]


@pytest.mark.parametrize(("metres", "after_s"), [(8.0, 1.0), (6.0, 6.0)])
def test_a_step_that_lasts_is_an_alarm(metres: float, after_s: float) -> None:
    verdicts = run(flight(45.0, step(metres)))
    assert alarms(verdicts)[0] == pytest.approx(after_s, abs=0.3)
    said = next(one for one in verdicts if one.state is State.ALARM)
    assert said.reason.startswith(f"jump: position jumped by {metres:.1f} m and stays there")
    assert verdicts[-1].state is State.NORMAL


@pytest.mark.parametrize(("metres", "back_s"), [(6.0, 5.0), (9.0, 0.8), (4.0, 1e9)])
def test_a_reflection_and_a_small_step_are_none(metres: float, back_s: float) -> None:
    verdicts = run(flight(60.0, step(metres, back_s)))
    assert not alarms(verdicts)
    assert State.SUSPICIOUS in {one.state for one in verdicts}


def test_switching_between_two_antennas_4_m_apart_is_none() -> None:
    assert not alarms(run(flight(120.0, lambda t: (4.0 * (t // 10.0 % 2), 0.0, 0.0))))


def test_three_small_steps_within_a_second_are_one() -> None:
    verdicts = run(flight(45.0, lambda t: (2.7 * min(3, max(0, (t - 29.7) // 0.39)), 0.0, 0.0)))
    assert alarms(verdicts)


def test_the_limit_follows_what_the_receiver_claims_and_has_shown() -> None:
    seven = flight(45.0, step(7.0))
    assert alarms(run(seven))
    assert not alarms(run(claiming(seven, lambda _: 5.0)))

    def reflected(t: float) -> Vector3:
        return (6.0 if 15.0 <= t < 17.0 else step(7.0)(t)[0], 0.0, 0.0)

    assert not alarms(run(flight(45.0, reflected)))


@settings(max_examples=8, deadline=None)
@given(st.floats(0.5, 500.0), st.floats(1.0, 4.9), st.floats(14.5, 100.0))
def test_nothing_that_is_claimed_or_shown_hides_a_step_of_three_limits(
    accuracy_m: float, trained_m: float, metres: float
) -> None:
    def offset(t: float) -> Vector3:
        return (trained_m * (t // 6.0 % 2) if t < JUMP_S else metres, 0.0, 0.0)

    assert alarms(run(claiming(flight(40.0, offset), lambda _: accuracy_m)))


@pytest.mark.parametrize("metres", [14.0, 300.0])
def test_what_a_receiver_does_before_it_has_settled_raises_no_limit(metres: float) -> None:
    def offset(t: float) -> Vector3:
        return (metres * (t > 3.0) + step(8.0)(t)[0], 0.0, 0.0)

    assert any(0.0 < one < 2.0 for one in alarms(run(flight(40.0, offset))))


def test_what_was_shown_on_the_ground_is_forgotten_at_the_take_off() -> None:
    """It switches by 4.5 m on the ground, and jumps by 7.5 m in the air."""

    def offset(t: float) -> Vector3:
        return (4.5 * (t // 3.0 % 2) if t < 21.0 else step(7.5)(t)[0], 0.0, 0.0)

    sent = flight(40.0, offset)
    assert not alarms(run(sent))
    for half in range(80):
        phase = Phase.STANDING if half < 44 else Phase.FLYING
        stamp_ns = START_NS + half * SECOND // 2
        sent.append(("phase", PhaseSample(stamp_ns, phase, stamp_ns, "test", 50.0)))
    assert alarms(run(sorted(sent, key=lambda one: one[1].stamp_ns)))


def test_a_shown_step_raises_the_limit_for_minutes_only() -> None:
    """7 m beside a claim of 5 m count as 4 m, which are 2.2 m after 180 s."""

    def offset(t: float) -> Vector3:
        return (7.0 * (15.0 <= t < 16.0) + 8.0 * (t >= 200.0), 0.0, 0.0)

    sent = claiming(flight(205.0, offset), lambda t: 5.0 if t < 25.0 else 1.0)
    assert alarms(run(sent))


def test_a_reflection_while_a_backlog_drains_is_none() -> None:
    """1 s at 10 m/s drains at 80 s, and a reflection takes 5.8 m for 3 s."""
    sent: Sent = []
    newest: dict[str, int] = {}
    for name, one in flight(95.0, lambda t: (0.0, 5.8 * (80.0 <= t < 83.0), 0.0), speed=10.0):
        t = seconds(one)
        later_s = min(1.0, max(0.0, (t - 50.0) / 12.0)) if t < 80.0 else 0.0
        stamp_ns = max(one.stamp_ns + round(later_s * SECOND), newest.get(name, 0) + SECOND // 50)
        newest[name] = stamp_ns
        sent.append((name, replace(one, stamp_ns=stamp_ns)))
    verdicts = run(sorted(sent, key=lambda one: one[1].stamp_ns))
    assert State.SUSPICIOUS in {one.state for one in verdicts}
    assert not alarms(verdicts)


def test_a_receiver_that_comes_back_from_a_gap_may_settle() -> None:
    sent = flight(60.0, step(7.0))
    gap = [one for one in sent if not 24.0 < seconds(one[1]) < 27.0]
    assert not alarms(run(gap))
    early = [one for one in sent if not 10.0 < seconds(one[1]) < 13.0]
    assert alarms(run(early))


def test_the_same_without_velocities_is_suspicious_only() -> None:
    assert not alarms(run(flight(45.0, step(8.0), velocities=False)))
