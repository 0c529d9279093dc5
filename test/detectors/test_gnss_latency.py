# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A receiver that becomes later is no contradiction; what its latency cannot explain is."""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from gnss_stream import SECOND, START_NS, Sent, fix, flight, run, seconds, velocity
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hijack_detect.detectors.gnss_checks.latency import (
    PERIODS,
    FixIntervals,
    LatencyMark,
    Passed,
    unexplained,
    without_latency,
)
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.lag_ekf import GROWTH, MOST_GROWTH_S
from hijack_detect.streams.samples import Vector3

CALM = {State.NOT_READY, State.NORMAL}
GROWS_S = 50.0


def late(sent: Sent, latency: Callable[[float], float]) -> Sent:
    """With stamps later by what is given of the true time; a link keeps their order."""
    last: dict[str, int] = {}
    moved: Sent = []
    for name, sample in sent:
        t = (sample.stamp_ns - START_NS) / SECOND
        stamp_ns = sample.stamp_ns + round(latency(t) * SECOND)
        stamp_ns = last[name] = max(stamp_ns, last.get(name, 0) + SECOND // 50)
        moved.append((name, replace(sample, stamp_ns=stamp_ns)))
    return sorted(moved, key=lambda one: one[1].stamp_ns)


def growth(total_s: float, over_s: float, fall_s: float) -> Callable[[float], float]:
    """Grows from GROWS_S on, stays for 10 s, and falls."""

    def latency(t: float) -> float:
        grown = total_s * min(1.0, max(0.0, (t - GROWS_S) / over_s))
        falling = t - GROWS_S - over_s - 10.0
        return grown * (1.0 if falling < 0.0 else max(0.0, 1.0 - falling / fall_s))

    return latency


def circle(seconds_: float, speed: float, turn: float) -> Sent:
    """Fixes and velocities at 5 Hz on a circle, rad/s."""
    sent: Sent = []
    for index in range(round(seconds_ * 5)):
        t = index / 5
        angle = turn * t
        east, north = speed / turn * (1.0 - math.cos(angle)), speed / turn * math.sin(angle)
        sent.append(
            ("velocity", velocity(t, (speed * math.sin(angle), speed * math.cos(angle), 0)))
        )
        sent.append(("fix", fix(t, (east, north, 0.0))))
    return sent


def states(verdicts: list[Verdict]) -> set[State]:
    return {one.state for one in verdicts}


@pytest.mark.parametrize("speed", [5.0, 15.0])
def test_a_latency_that_grows_is_named_and_no_alarm(speed: float) -> None:
    verdicts = run(late(flight(100.0, speed=speed), growth(1.2, 10.0, 0.5)))
    assert states(verdicts) <= CALM
    named = [one for one in verdicts if "later_s" in one.values]
    assert GROWS_S < seconds(named[0]) < GROWS_S + 12.0
    assert "the GPS has become later by" in named[0].reason
    assert max(one.values["later_s"] for one in named) == pytest.approx(1.2, abs=0.1)
    assert not any("later_s" in one.values for one in run(flight(100.0, speed=speed)))


def test_a_latency_that_grew_in_a_hover_may_fall_in_motion() -> None:
    """1.2 s, which drain at 8 m/s: without the intervals a jump of 10 m."""
    hover = flight(70.0, speed=0.0)
    away = [
        (name, replace(one, stamp_ns=one.stamp_ns + 70 * SECOND))
        for name, one in flight(40.0, speed=8.0)
    ]
    grown = late(hover + away, growth(1.2, 10.0, 0.3))
    assert State.ALARM not in states(run(grown))  # falls while the speed steps from 0 to 8 m/s
    fallen_s = GROWS_S + 35.0
    latency = growth(1.2, 10.0, 1e6)
    drained = late(hover + away, lambda t: latency(t) if t < fallen_s else 0.0)
    assert State.ALARM not in states(run(drained))
    jumped = [
        (
            name,
            replace(one, latitude_deg=one.latitude_deg + 1e-4)
            if name == "fix" and one.stamp_ns >= START_NS + fallen_s * SECOND
            else one,
        )
        for name, one in hover + away
    ]
    assert State.ALARM in states(run(jumped))


@settings(max_examples=8, deadline=None)
@given(
    st.floats(0.2, MOST_GROWTH_S),
    st.floats(0.7, 1.0),
    st.floats(0.3, 20.0),
    st.floats(3.0, 12.0),
    st.floats(0.02, 0.3),
)
def test_no_latency_within_the_bounds_alarms(
    total_s: float, pace: float, fall_s: float, speed: float, turn: float
) -> None:
    over_s = total_s / GROWTH / pace
    verdicts = run(late(circle(95.0, speed, turn), growth(total_s, over_s, fall_s)))
    assert State.ALARM not in states(verdicts)


@pytest.mark.parametrize(
    ("pull", "within_s"),
    [
        pytest.param((0.0, -0.12), 25.0, id="longer than any latency grows"),
        pytest.param((0.0, -0.4), 8.0, id="faster than any latency grows"),
        pytest.param((0.0, -0.12), 12.0, id="no fix comes later"),
        pytest.param((0.12, 0.0), 10.0, id="across the path"),
        pytest.param((0.0, 0.12), 10.0, id="ahead, and was never late"),
    ],
)
def test_what_no_latency_explains_is_an_alarm(pull: tuple[float, float], within_s: float) -> None:
    """The position is pulled at parts of the speed of 8 m/s, the velocity is left alone."""

    def offset(t: float) -> Vector3:
        pulled_s = max(0.0, t - 60.0)
        return (8.0 * pull[0] * pulled_s, 8.0 * pull[1] * pulled_s, 0.0)

    verdicts = run(flight(60.0 + within_s, offset, speed=8.0))
    alarms = [seconds(one) for one in verdicts if one.state is State.ALARM]
    assert alarms
    assert alarms[0] > 60.0


def test_a_hover_explains_nothing() -> None:
    """0.9 m/s beside a velocity of zero, as a carry-off by the position alone."""
    sent = flight(60.0) + [
        (name, replace(sample, stamp_ns=sample.stamp_ns + 60 * SECOND))
        for name, sample in flight(20.0, lambda t: (0.9 * max(0.0, t - 5.0), 300.0, 0.0), speed=0.0)
    ]
    assert State.ALARM in states(run(sent))


def moved(
    speed: Callable[[float], float], places: Callable[[float], float], total_s: float
) -> Sent:
    """To the North at a speed, 5 Hz; `places` is added to the position."""
    sent: Sent = []
    north, before = 0.0, speed(0.0)
    for index in range(round(total_s * 5)):
        t = index / 5
        north, before = north + 0.1 * (before + speed(t)) * (index > 0), speed(t)
        sent.append(("velocity", velocity(t, (0.0, before, 0.0))))
        sent.append(("fix", fix(t, (0.0, north + places(t), 0.0))))
    return sent


@pytest.mark.parametrize("metres", [8.0, 14.0, 20.0])
def test_a_slow_pull_back_buys_no_jump_ahead(metres: float) -> None:
    """3.3 m at 2.2 m/s are 1.5 s, which are 22 m at 15 m/s; no interval changes."""

    def places(t: float) -> float:
        return -3.3 * min(1.0, max(0.0, (t - 30.0) / 25.0)) + metres * (t >= 80.0)

    sent = moved(lambda t: min(15.0, 2.2 + 3.0 * max(0.0, t - 60.0)), places, 90.0)
    assert 80.0 <= next(seconds(one) for one in run(sent) if one.state is State.ALARM) <= 86.1


def test_a_brake_in_a_hole_buys_no_jump_ahead() -> None:
    sent = moved(lambda t: max(3.0, min(12.0, 12.0 - 9.0 * (t - 40.3))), lambda _: 0.0, 45.0)
    away = moved(lambda _: 12.0, lambda t: 17.0 * (t >= 10.0), 20.0)
    last = [sample for name, sample in sent if name == "fix"][-1]
    offset_deg = last.latitude_deg - 48.0
    for name, sample in away:
        at = replace(sample, stamp_ns=sample.stamp_ns + 45 * SECOND)
        north = {"latitude_deg": sample.latitude_deg + offset_deg} if name == "fix" else {}
        sent.append((name, replace(at, **north)))
    kept = [one for one in sent if not 40.0 < seconds(one[1]) < 43.0]
    alarms = [seconds(one) for one in run(kept) if one.state is State.ALARM]
    assert any(55.0 <= one <= 56.5 for one in alarms)


def learnt(intervals: list[float]) -> tuple[FixIntervals, list[float]]:
    period = FixIntervals()
    return period, [period.add(one) for one in intervals]


@pytest.mark.parametrize(
    ("intervals", "period_s"),
    [
        pytest.param([0.2] * 10 + [30.0] + [0.2] * 90, 0.2, id="an early outage"),
        pytest.param([0.2] * 10 + [1.8] * 5 + [0.2] * 90, 0.2, id="lost fixes early"),
        pytest.param([1.0] * 60 + [0.2] * 100, 0.2, id="1 to 5 Hz"),
        pytest.param([0.2] * 300 + [0.1] * 100, 0.1, id="5 to 10 Hz"),
        pytest.param([0.2] * 300 + [0.25] * 100, 0.25, id="5 to 4 Hz"),
        pytest.param([0.2] * 100 + [0.23] * 50 + [0.2] * 50, 0.2, id="a growth"),
        pytest.param([0.2] * 100 + [0.02] * 8 + [0.2] * 50, 0.2, id="a backlog"),
    ],
)
def test_the_period_is_that_of_the_receiver(intervals: list[float], period_s: float) -> None:
    period, grown = learnt(intervals)
    assert period.even
    assert period.period_s == pytest.approx(period_s, rel=0.005)
    assert sum(grown[-40:]) == pytest.approx(0.0, abs=0.05)


def test_uneven_intervals_say_nothing() -> None:
    assert not learnt([0.14, 0.26] * PERIODS)[0].even


def test_a_new_rate_gives_no_credit_for_a_jump_ahead() -> None:
    """5 to 4 Hz at 60 s in a hover, then 15 m/s."""
    sent: Sent = []
    for index in range(115 * 20):
        t = index / 20
        if index % (4 if t < 60.0 else 5):
            continue
        speed = min(15.0, 3.0 * max(0.0, t - 90.0))
        flown = 1.5 * min(5.0, max(0.0, t - 90.0)) ** 2 + 15.0 * max(0.0, t - 95.0)
        sent.append(("velocity", velocity(t, (0.0, speed, 0.0))))
        sent.append(("fix", fix(t, (0.0, flown + 20.0 * (t >= 110.0), 0.0))))
    verdicts = run(sent)
    alarms = [seconds(one) for one in verdicts if one.state is State.ALARM]
    assert alarms[0] == pytest.approx(110.0, abs=0.3)


def test_a_fall_is_explained_as_far_as_the_steps_before_and_after_it_say() -> None:
    """The change of latency in the first step counts."""
    start = LatencyMark(short_s=1.0, bound_s=1.0)
    step = Passed((0.2, 0.0, 0.0), (10.0, 0.0, 0.0), LatencyMark(short_s=0.2, bound_s=0.2))
    assert unexplained((8.9, 0.0, 0.0), start, [step])[0] == pytest.approx(0.0, abs=1e-9)
    assert unexplained((12.0, 0.0, 0.0), start, [step])[0] == pytest.approx(3.0)
    assert unexplained((8.9, 0.0, 0.0), step.latency, [step])[0] == pytest.approx(7.9)


vectors = st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(-9, 9))


@given(
    vectors, st.lists(st.tuples(vectors, st.floats(0.0, MOST_GROWTH_S)), min_size=1, max_size=30)
)
def test_latency_explains_at_most_the_difference(
    difference: Vector3, steps: list[tuple[Vector3, float]]
) -> None:
    passed = [
        Passed((0.2 * v[0], 0.2 * v[1], 0.2 * v[2]), v, LatencyMark(backlog_s=late_s))
        for v, late_s in steps
    ]
    across, up = unexplained(difference, passed[0].latency, passed)
    assert 0.0 <= across <= math.hypot(difference[0], difference[1]) + 1e-9
    assert 0.0 <= up <= abs(difference[2]) + 1e-9


@given(vectors, st.floats(0.0, GROWTH), st.integers(1, 40), st.floats(0.0, 20.0))
def test_a_growth_within_the_bounds_is_explained_and_what_is_across_is_not(
    v: Vector3, rate: float, count: int, aside_m: float
) -> None:
    expected = (0.2 * v[0], 0.2 * v[1], 0.2 * v[2])
    passed = [Passed(expected, v, LatencyMark(bound_s=0.2 * rate * (k + 1))) for k in range(count)]
    off = -rate * 0.2 * count
    assert unexplained((off * v[0], off * v[1], off * v[2]), LatencyMark(), passed)[0] <= 1e-6
    speed = math.hypot(v[0], v[1])
    assume(speed > 1.0)
    across = (-aside_m * v[1] / speed, aside_m * v[0] / speed)
    aside = (off * v[0] + across[0], off * v[1] + across[1], 0.0)
    assert unexplained(aside, LatencyMark(), passed)[0] == pytest.approx(
        aside_m, rel=0.01, abs=1e-6
    )


@given(vectors, vectors, st.floats(0.0, 2.0), st.floats(0.0, MOST_GROWTH_S))
def test_a_step_across_the_path_stays(
    residual: Vector3, v: Vector3, growth_s: float, fall_s: float
) -> None:
    left = without_latency(residual, v, v, growth_s, fall_s)
    assert math.hypot(left[0], left[1]) <= math.hypot(residual[0], residual[1]) + 1e-6
    cross = (residual[0] * v[1] - residual[1] * v[0], left[0] * v[1] - left[1] * v[0])
    assert cross[1] == pytest.approx(cross[0], abs=1e-6)
    assert left[2] == residual[2]
