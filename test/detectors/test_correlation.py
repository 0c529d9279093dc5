# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Algorithm 2 of the paper on constructed trends, against NumPy."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.detectors.correlation import CorrelationDetector, CorrelationParameters
from hijack_detect.detectors.flight_gate import MIN_IMU_HZ
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.streams.samples import AttitudeSample, CourseSample, Phase, PhaseSample

MS = 1_000_000
FAITHFUL = CorrelationParameters(
    mu_deg=10.0,
    min_sigma_deg=0.0,
    persist_s=0.0,
    course_lag_s=0.0,
    follow_s=0.0,
    max_heading_sigma_deg=180.0,
)
Angle = Callable[[float], float]


@dataclass
class Feed:
    """Yaw at 50 Hz and course at 5 Hz, angles in degrees counter-clockwise from East."""

    detector: CorrelationDetector
    ms: int = 0

    def __call__(
        self,
        seconds: float,
        yaw: Angle,
        course: Angle,
        *,
        observable: bool = True,
        oriented: bool = True,
        heading_sigma_deg: float = 1.0,
    ) -> list[Verdict]:
        """The angles are functions of the seconds since the first sample of all."""
        verdicts = []
        for ms in range(self.ms, self.ms + round(seconds * 1000), 20):
            half = math.radians(yaw(ms / 1000)) / 2
            orientation = (0.0, 0.0, math.sin(half), math.cos(half)) if oriented else None
            variance = math.radians(heading_sigma_deg) ** 2
            attitude = AttitudeSample(ms * MS, orientation, variance, (0, 0, 0), (0, 0, 9.8))
            assert self.detector.update("attitude", attitude) is None
            if ms % 200 == 0:
                half = math.radians(course(ms / 1000)) / 2
                z, w = (math.sin(half), math.cos(half)) if observable else (0.0, 0.0)
                verdict = self.detector.update("course", CourseSample(ms * MS, z, w))
                assert verdict is not None
                assert verdict.stamp_ns == ms * MS
                verdicts.append(verdict)
        self.ms += round(seconds * 1000)
        return verdicts


def run(
    parameters: CorrelationParameters, seconds: float, yaw: Angle, course: Angle
) -> list[Verdict]:
    return Feed(CorrelationDetector(parameters))(seconds, yaw, course)


def swing(t: float) -> float:
    return 30.0 * math.sin(1.5 * t)


def steady(_: float) -> float:
    return 20.0


def past_start(verdicts: list[Verdict]) -> list[Verdict]:
    return [one for one in verdicts if one.stamp_ns >= 2500 * MS]


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 1000), st.sampled_from([0.0, 0.2, 0.5]))
def test_coefficient_and_difference_are_those_of_numpy(seed: int, smoothing_s: float) -> None:
    """Random walks; the held course, both moving means and the window computed here at once."""
    rng = np.random.default_rng(seed)
    yaw = np.degrees(np.cumsum(rng.normal(0.0, 0.1, 251)))
    course = np.degrees(np.cumsum(rng.normal(0.0, 0.5, 26))) + 40.0
    detector = CorrelationDetector(replace(FAITHFUL, smoothing_s=smoothing_s))
    verdicts = Feed(detector)(
        5.0, lambda t: float(yaw[round(t * 50)]), lambda t: float(course[round(t * 5)])
    )

    # The first attitude comes before any course; equal stamps: attitude before course.
    held = np.radians(course[(np.arange(1, 250) - 1) // 10])
    turned = np.radians(yaw[1:250])
    count = max(1, round(smoothing_s * 50))

    def smooth(angles: np.ndarray) -> np.ndarray:
        return np.array(
            [np.mean(angles[max(0, k - count + 1) : k + 1]) for k in range(len(angles))]
        )

    for verdict in past_start(verdicts):
        last = verdict.stamp_ns // (20 * MS)
        rows = slice(last - 100, last)
        a, b = smooth(turned)[rows], smooth(held)[rows]
        expected = np.corrcoef(a, b)[0, 1]
        assert verdict.values["coefficient"] == pytest.approx(expected, abs=1e-6)
        difference = math.remainder(float(np.mean(b) - np.mean(a)), math.tau)
        apart = math.remainder(verdict.values["mean_difference"] - difference, math.tau)
        assert apart == pytest.approx(0.0, abs=1e-6)
        apart_deg = abs(math.degrees(difference))
        assert (verdict.state is State.ALARM) == (expected < 0.85 and apart_deg > 10.0)
        assert (verdict.score > verdict.threshold) == (verdict.state is State.ALARM)


@pytest.mark.parametrize(
    ("sense", "offset_deg", "state"),
    [
        (1.0, 0.0, State.NORMAL),
        (1.0, 40.0, State.NORMAL),
        (-1.0, 0.0, State.NORMAL),
        (-1.0, 40.0, State.ALARM),
        (-1.0, -40.0, State.ALARM),
    ],
    ids=["together", "turning together", "pointing together", "neither left", "neither right"],
)
def test_the_four_cases_of_algorithm_2(sense: float, offset_deg: float, state: State) -> None:
    """Whole periods of a swing, so that the means are those of the offset."""
    period = FAITHFUL.window_s

    def yaw(t: float) -> float:
        return 20.0 * math.sin(math.tau * t / period)

    def course(t: float) -> float:
        return sense * yaw(t) + offset_deg

    verdicts = past_start(run(FAITHFUL, 8.0, yaw, course))
    assert {one.state for one in verdicts} == {state}
    for one in verdicts:
        found = one.values["coefficient"]
        assert found > 0.85 if sense > 0 else found < 0.0
        assert math.degrees(one.values["mean_difference"]) == pytest.approx(offset_deg, abs=4.0)


@pytest.mark.parametrize("offset_deg", [0.0, 30.0])
def test_a_perfectly_straight_flight_has_no_turn_to_correlate(offset_deg: float) -> None:
    verdicts = past_start(run(FAITHFUL, 6.0, steady, lambda t: 20.0 + offset_deg))
    assert verdicts
    for one in verdicts:
        assert one.state is State.NORMAL
        assert one.score == 0.0
        assert "no turn to correlate" in one.reason
        assert "coefficient" not in one.values


@pytest.mark.parametrize("rate_deg_s", [-40.0, 40.0])
def test_turning_through_half_a_turn_is_seamless(rate_deg_s: float) -> None:
    """Course and yaw go around several times together, 5° apart."""
    verdicts = past_start(
        run(FAITHFUL, 20.0, lambda t: rate_deg_s * t, lambda t: rate_deg_s * t + 5.0)
    )
    for one in verdicts:
        assert one.state is State.NORMAL
        assert one.values["coefficient"] > 0.95
        expected = 5.0 - 0.11 * rate_deg_s  # the course is held between fixes
        assert math.degrees(one.values["mean_difference"]) == pytest.approx(expected, abs=1.0)


@pytest.mark.parametrize(("course_lag_s", "apart_deg"), [(0.0, -16.4), (0.3, -4.4), (0.4, -0.4)])
def test_the_yaw_is_held_back_by_the_lag_of_the_course(
    course_lag_s: float, apart_deg: float
) -> None:
    """In a turn of 40°/s; the course is 0.3 s late and held, another 0.11 s in the mean."""
    verdicts = past_start(
        run(
            replace(FAITHFUL, course_lag_s=course_lag_s),
            8.0,
            lambda t: 40.0 * t,
            lambda t: 40.0 * (t - 0.3),
        )
    )
    for one in verdicts:
        found = math.degrees(one.values["mean_difference"])
        assert found == pytest.approx(apart_deg, abs=0.5)


@settings(deadline=None, max_examples=15)
@given(st.floats(-400.0, 400.0))
def test_verdicts_do_not_depend_on_where_north_is(turned_deg: float) -> None:
    def verdicts(offset_deg: float) -> list[Verdict]:
        return past_start(
            run(
                FAITHFUL,
                6.0,
                lambda t: swing(t) + offset_deg,
                lambda t: -swing(t) + 15.0 + offset_deg,
            )
        )

    for one, other in zip(verdicts(0.0), verdicts(turned_deg), strict=True):
        assert one.state is other.state
        assert one.values["coefficient"] == pytest.approx(other.values["coefficient"], abs=1e-6)
        apart = math.remainder(
            one.values["mean_difference"] - other.values["mean_difference"], math.tau
        )
        assert apart == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_mean_difference_across_half_a_turn_is_the_short_way(sense: float) -> None:
    verdicts = past_start(
        run(FAITHFUL, 6.0, lambda t: sense * 170.0, lambda t: sense * (-170.0 + 0.1 * t))
    )
    for one in verdicts:
        found = math.degrees(one.values["mean_difference"])
        assert found == pytest.approx(sense * 20.0, abs=1.0)


def test_opposite_directions_differ_by_half_a_turn_and_not_by_none() -> None:
    verdicts = past_start(run(FAITHFUL, 6.0, swing, lambda t: 180.0 - swing(t)))
    assert {one.state for one in verdicts} == {State.ALARM}
    for one in verdicts:
        assert abs(math.degrees(one.values["mean_difference"])) > 100.0


def test_not_ready_until_the_window_is_filled() -> None:
    verdicts = run(FAITHFUL, 4.0, swing, swing)
    states = [one.state for one in verdicts]
    assert states[:9] == [State.NOT_READY] * 9
    assert set(states[11:]) == {State.NORMAL}


def test_not_ready_without_attitude() -> None:
    verdicts = Feed(CorrelationDetector(FAITHFUL))(5.0, swing, swing, oriented=False)
    assert {one.state for one in verdicts} == {State.NOT_READY}


def test_losing_the_attitude_empties_the_window() -> None:
    feed = Feed(CorrelationDetector(FAITHFUL))
    assert feed(4.0, swing, swing)[-1].state is State.NORMAL
    assert feed(0.4, swing, swing, oriented=False)[-1].state is State.NOT_READY
    states = [one.state for one in feed(4.0, swing, swing)]
    assert states[:8] == [State.NOT_READY] * 8
    assert states[-1] is State.NORMAL


def test_without_course_it_is_not_observable() -> None:
    feed = Feed(CorrelationDetector(FAITHFUL))
    feed(4.0, swing, lambda t: -swing(t) + 40.0)
    hovering = feed(3.0, swing, steady, observable=False)
    assert {one.state for one in hovering} == {State.NOT_OBSERVABLE}
    assert all("no course" in one.reason and one.score == 0.0 for one in hovering)


def test_a_course_that_stops_is_told_once_a_second() -> None:
    """Even the IMU alone makes the detector speak, and what was held is forgotten."""
    feed = Feed(CorrelationDetector(FAITHFUL))
    feed(4.0, swing, lambda t: -swing(t) + 40.0)
    told = []
    for ms in range(4000, 9000, 20):
        verdict = feed.detector.update(
            "attitude", AttitudeSample(ms * MS, (0.0, 0.0, 0.0, 1.0), 0.0, (0, 0, 0), (0, 0, 9.8))
        )
        if verdict is not None:
            told.append(verdict)
    assert {one.state for one in told} == {State.STALE}
    assert [one.stamp_ns // (1000 * MS) for one in told] == [5, 6, 7, 8]
    assert "no course for" in told[-1].reason
    feed.ms = 9000
    again = feed(4.0, swing, swing)
    assert {one.state for one in again[:8]} == {State.NOT_READY}
    assert again[-1].state is State.NORMAL


def test_an_attitude_that_stops_is_told() -> None:
    feed = Feed(CorrelationDetector(FAITHFUL))
    feed(4.0, swing, lambda t: -swing(t) + 40.0)
    states = []
    for ms in range(4000, 9000, 200):
        verdict = feed.detector.update("course", CourseSample(ms * MS, 0.0, 1.0))
        assert verdict is not None
        states.append(verdict.state)
    assert set(states[11:]) == {State.STALE}


def test_an_uncertain_heading_is_not_observable() -> None:
    feed = Feed(CorrelationDetector(replace(FAITHFUL, max_heading_sigma_deg=10.0)))
    feed(4.0, swing, lambda t: -swing(t) + 40.0, heading_sigma_deg=9.0)
    assert feed(1.0, swing, lambda t: -swing(t) + 40.0)[-1].state is State.ALARM
    unsure = feed(1.0, swing, lambda t: -swing(t) + 40.0, heading_sigma_deg=11.0)
    assert {one.state for one in unsure} == {State.NOT_OBSERVABLE}
    assert "11°" in unsure[-1].reason


def test_the_condition_must_persist() -> None:
    verdicts = past_start(
        run(replace(FAITHFUL, persist_s=1.0), 8.0, swing, lambda t: -swing(t) + 60.0)
    )
    states = [one.state for one in verdicts]
    first = next(one for one in verdicts if one.state is State.ALARM)
    begun = next(
        one
        for one in run(FAITHFUL, 8.0, swing, lambda t: -swing(t) + 60.0)
        if one.state is State.ALARM
    )
    assert first.stamp_ns - begun.stamp_ns == 1000 * MS
    assert State.SUSPICIOUS in states
    assert set(states[states.index(State.ALARM) :]) == {State.ALARM}


@pytest.mark.parametrize(("mu_deg", "state"), [(25.0, State.ALARM), (35.0, State.NORMAL)])
def test_mu_is_in_degrees(mu_deg: float, state: State) -> None:
    period = FAITHFUL.window_s

    def yaw(t: float) -> float:
        return 20.0 * math.sin(math.tau * t / period)

    verdicts = past_start(run(replace(FAITHFUL, mu_deg=mu_deg), 6.0, yaw, lambda t: 30.0 - yaw(t)))
    assert {one.state for one in verdicts} == {state}


@pytest.mark.parametrize(("epsilon", "state"), [(-0.2, State.NORMAL), (0.2, State.ALARM)])
def test_epsilon_bounds_the_coefficient(epsilon: float, state: State) -> None:
    """A quarter period apart, ρ is about zero; holding the course delays it by 0.11 s."""
    period = FAITHFUL.window_s
    verdicts = past_start(
        run(
            replace(FAITHFUL, epsilon=epsilon, smoothing_s=0.0),
            6.0,
            lambda t: 20.0 * math.sin(math.tau * t / period),
            lambda t: 20.0 * math.cos(math.tau * (t + 0.11) / period) + 60.0,
        )
    )
    assert {one.state for one in verdicts} == {state}


def test_without_a_turn_the_hardened_variant_judges_the_direction() -> None:
    """Below `min_sigma_deg` ρ is noise, the direction is not."""
    feed = Feed(CorrelationDetector(CorrelationParameters()))
    assert feed(15.0, steady, lambda t: 24.0)[-1].state is State.NORMAL
    away = feed(10.0, steady, lambda t: 90.0)
    assert away[-1].state is State.ALARM
    assert "no turn" in away[-1].reason


@pytest.mark.parametrize(
    ("parameters", "state"), [(CorrelationParameters(), State.ALARM), (FAITHFUL, State.NORMAL)]
)
def test_a_course_drawn_straight_does_not_correlate_with_a_turn(
    parameters: CorrelationParameters, state: State
) -> None:
    """A fake track without noise turns by 1e-6 °/s: ρ is 1, only the faithful one believes it."""
    feed = Feed(CorrelationDetector(parameters))

    def yaw(t: float) -> float:
        return 20.0 + max(0.0, 10.0 * (t - 15.0))

    feed(15.0, yaw, steady)
    away = feed(9.0, yaw, lambda t: 20.0 + 1e-6 * t)[-1]
    assert abs(math.degrees(away.values["mean_difference"])) > 60.0
    assert away.state is state
    assert ("coefficient" in away.values) is (state is State.NORMAL)
    if state is State.NORMAL:
        assert away.values["coefficient"] > 0.99


def test_a_crab_angle_is_taken_off() -> None:
    """Wind: the course lies 30° off the nose all the time, more than μ."""
    verdicts = run(CorrelationParameters(), 30.0, steady, lambda t: 50.0)
    judged = [one for one in verdicts if one.state is not State.NOT_READY]
    assert State.ALARM not in {one.state for one in judged}
    assert judged[-1].state is State.NORMAL
    assert math.degrees(judged[-1].values["crab_angle"]) == pytest.approx(30.0, abs=0.1)
    assert judged[-1].score == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("offset_deg", [90.0, -90.0, 180.0])
def test_flying_sideways_or_backwards_is_not_observable(offset_deg: float) -> None:
    verdicts = run(CorrelationParameters(), 30.0, swing, lambda t: swing(t) + offset_deg)
    assert {one.state for one in verdicts} == {State.NOT_READY, State.NOT_OBSERVABLE}
    assert "off the nose" in verdicts[-1].reason


def test_a_nose_that_does_not_follow_is_not_observable() -> None:
    """A camera drone that turns on the spot of its straight course."""
    verdicts = run(CorrelationParameters(), 30.0, lambda t: 30.0 * t, steady)
    late = [one for one in verdicts if one.stamp_ns > 12_000 * MS]
    assert {one.state for one in late} == {State.NOT_OBSERVABLE}


def test_the_time_before_must_have_had_a_course() -> None:
    """After a hover the nose must follow again for `follow_s` before anything is claimed."""
    feed = Feed(CorrelationDetector(CorrelationParameters()))
    assert feed(15.0, steady, steady)[-1].state is State.NORMAL
    feed(2.0, steady, steady, observable=False)
    again = feed(15.0, steady, steady)
    states = [one.state for one in again]
    judged = states.index(State.NORMAL)
    assert set(states[:judged]) == {State.NOT_OBSERVABLE}
    assert 7.0 <= judged * 0.2 <= 10.5
    assert set(states[judged:]) == {State.NORMAL}


def test_an_alarm_does_not_become_the_new_normal() -> None:
    """The course is led 60° away and stays there: a reference that learned would forget it."""
    feed = Feed(CorrelationDetector(CorrelationParameters()))
    before = feed(15.0, steady, lambda t: 25.0)[-1].values["crab_angle"]
    away = feed(60.0, steady, lambda t: 85.0)
    begun = next(k for k, one in enumerate(away) if one.state is State.ALARM)
    assert begun * 0.2 < 4.0
    assert {one.state for one in away[begun:]} == {State.ALARM}
    crabs = {one.values["crab_angle"] for one in away[begun:]}
    assert len(crabs) == 1
    assert crabs.pop() == pytest.approx(before, abs=math.radians(1.0))


def test_an_alarm_ends_when_course_and_nose_agree_again() -> None:
    feed = Feed(CorrelationDetector(CorrelationParameters()))
    feed(15.0, steady, steady)
    assert feed(10.0, steady, lambda t: 80.0)[-1].state is State.ALARM
    assert feed(6.0, steady, steady)[-1].state in (State.NORMAL, State.NOT_OBSERVABLE)
    assert feed(20.0, steady, steady)[-1].state is State.NORMAL


@pytest.mark.parametrize(
    ("phase", "rate_hz", "fault"),
    [
        (Phase.STANDING, 50.0, ""),
        (Phase.HANDLED, 50.0, ""),
        (Phase.FLYING, MIN_IMU_HZ - 1.0, ""),
        (Phase.FLYING, 50.0, "the accelerometer clips at 14 m/s²"),
    ],
)
def test_it_judges_in_flight_only_and_the_faithful_one_always(
    phase: Phase, rate_hz: float, fault: str
) -> None:
    def told(parameters: CorrelationParameters, sample: PhaseSample) -> list[Verdict]:
        detector = CorrelationDetector(parameters)
        feed, found = Feed(detector), []
        for half in range(20):
            assert detector.update("phase", replace(sample, stamp_ns=500 * half * MS)) is None
            found += feed(0.5, swing, lambda t: -swing(t))
        return past_start(found)

    flying = PhaseSample(0, Phase.FLYING, 0, "flies", 50.0)
    blocked = replace(flying, phase=phase, imu_rate_hz=rate_hz, imu_fault=fault)
    hardened = CorrelationParameters(follow_s=0.0)
    faithful = policy_parameters("paper").of(CorrelationParameters)
    assert {one.state for one in told(hardened, blocked)} == {State.NOT_OBSERVABLE}
    assert State.NOT_OBSERVABLE not in {one.state for one in told(hardened, flying)}
    assert told(faithful, blocked) == told(faithful, flying)
