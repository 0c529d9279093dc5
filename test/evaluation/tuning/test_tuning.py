# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Thresholds from clean flights."""

from __future__ import annotations

import dataclasses
from functools import lru_cache
from pathlib import Path

import pytest
from ros import ROOT

from hijack_detect.detectors.correlation import CorrelationParameters
from hijack_detect.detectors.date import DateDetector, DateParameters
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.evaluation.trials.cases import SETTLED_S, BagCase, SimulatedCase
from hijack_detect.evaluation.trials.recorded import Recorded, judge, record
from hijack_detect.evaluation.tuning.sweeps import verdicts_at
from hijack_detect.evaluation.tuning.thresholds import (
    FEW_FLIGHTS_FACTOR,
    SMALLEST_FACTOR,
    TUNABLES,
    Alarms,
    Choice,
    FlightAlarms,
    Kept,
    Tunable,
    at_threshold,
    choose,
    safety_factor,
)
from hijack_detect.evaluation.tuning.tuning import (
    attack_onsets_s,
    longest_forward,
    survey,
    tune,
    with_choices,
    with_lag,
)
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.simulated_bag import make_bag
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.spoofing.scenario import load_scenario

BAG = ROOT / "bags/curved_8"
DEFAULT = policy_parameters("default")
TURN_AWAY = load_scenario(ROOT / "config/scenarios/turn_away_track.yaml")
GRID = Tunable("date", "threshold", "m/s²", (1.0, 2.0, 3.0, 4.0), 6.0, TUNABLES["date"].count)


@lru_cache
def flown() -> Recorded:
    return record(BagCase(BAG, "curved", "curved"), DEFAULT)


def flight(*counts: int, hours: float = 0.1, judged_s: float = 300.0) -> FlightAlarms:
    return FlightAlarms(f"{counts}", hours, {"date": Alarms(judged_s, counts)})


@pytest.mark.parametrize("detector", ["correlation", "date"])
def test_a_detector_says_of_a_recording_what_it_says_in_the_monitor(detector: str) -> None:
    said = BagCase(BAG, "curved", "curved").run(DEFAULT).run.verdicts[detector]
    name = {"correlation": "mu_deg", "date": "threshold"}[detector]
    value = getattr(DEFAULT[detector], name)
    [found] = verdicts_at(flown(), DEFAULT, detector, name, [value])
    assert said[: len(found)] == found
    # That nothing more is to come only the monitor knows.
    assert len(said) - len(found) <= 3


@pytest.mark.parametrize("threshold", [0.15, 0.3, 1.5])
def test_a_threshold_can_be_changed_afterwards(threshold: float) -> None:
    plain = dataclasses.replace(DEFAULT.of(DateParameters), noise_gain=0.0)
    date = dataclasses.replace(plain, threshold=threshold)
    real = judge(flown(), lambda: DateDetector(date))
    changed = at_threshold(judge(flown(), lambda: DateDetector(plain)), threshold, 0.4)
    assert [(v.stamp_ns, v.state) for v in changed] == [(v.stamp_ns, v.state) for v in real]


@pytest.mark.parametrize("name", TUNABLES)
def test_a_larger_threshold_alarms_less(name: str) -> None:
    tunable = TUNABLES[name]
    alarms = tunable.count(flown(), DEFAULT, (tunable.values[0], tunable.values[-1]))
    assert alarms.counts[0] >= alarms.counts[1] == 0
    assert 0.0 < alarms.judged_s < flown().hours * 3600.0


def test_a_rate_that_cannot_be_shown_takes_no_alarm_and_a_factor() -> None:
    choice = choose(GRID, "date", [flight(5, 1, 0, 0), flight(1, 0, 0, 0)], per_hour=1.0)
    assert isinstance(choice, Choice)
    assert (choice.quiet, choice.factor) == (3.0, FEW_FLIGHTS_FACTOR)
    assert choice.value == 5.1
    assert choice.judged_hours == pytest.approx(600.0 / 3600.0)


def test_a_rate_that_can_be_shown_takes_no_factor() -> None:
    flights = [flight(9, 2, 1, 0, hours=10.0) for _ in range(4)]
    assert choose(GRID, "date", flights, per_hour=0.2) == choose(GRID, "date", flights, 0.1 + 0.1)
    choice = choose(GRID, "date", flights, per_hour=0.3)
    assert isinstance(choice, Choice)
    assert (choice.value, choice.quiet, choice.factor) == (3.0, 3.0, 1.0)


def test_two_alarms_that_merge_at_a_smaller_threshold_are_not_fewer() -> None:
    choice = choose(GRID, "date", [flight(0, 1, 0, 0)], per_hour=1.0)
    assert isinstance(choice, Choice)
    assert choice.quiet == 3.0


def test_a_detector_that_never_could_tell_is_left_alone() -> None:
    kept = choose(GRID, "date", [flight(0, 0, 0, 0, judged_s=20.0)], per_hour=1.0)
    assert kept == Kept("it could tell for 20 s only")
    assert with_choices(DEFAULT, {"date": kept}) == DEFAULT


@pytest.mark.parametrize("loud", [(1, 1, 1, 1), (1, 1, 1, 0)])
def test_a_threshold_that_would_be_of_no_use_is_not_taken(loud: tuple[int, ...]) -> None:
    kept = choose(GRID, "date", [flight(0, 0, 0, 0), flight(*loud)], per_hour=1.0)
    assert isinstance(kept, Kept)
    assert kept.reason.endswith(f"more than 6 m/s²: quiet from 4 on, loudest is {loud}")


def test_the_factor_covers_what_one_half_does_not_know_of_the_other() -> None:
    alike = [flight(1, 0, 0, 0)] * 8
    assert safety_factor(GRID, "date", alike) == SMALLEST_FACTOR
    assert safety_factor(GRID, "date", [*alike[:7], flight(1, 1, 1, 0)]) == 2.0
    assert safety_factor(GRID, "date", alike[:3]) == FEW_FLIGHTS_FACTOR


def test_the_lag_does_not_replace_what_a_policy_sets_on_purpose() -> None:
    tuned = with_lag(DEFAULT, "default", 0.2345, 0.2)
    assert tuned.of(AttitudeParameters).gps_lag_s == tuned.of(DateParameters).gps_lag_s == 0.234
    assert tuned.of(CorrelationParameters).course_lag_s == 0.434
    paper = with_lag(policy_parameters("paper"), "paper", 0.2345, 0.2)
    assert paper.of(AttitudeParameters).gps_lag_s == 0.234
    assert paper.of(DateParameters).gps_lag_s == 0.0
    assert paper.of(CorrelationParameters).course_lag_s == 0.0


def test_attacks_lie_in_forward_flight_and_are_always_the_same() -> None:
    begin_ns, end_ns = longest_forward(flown())
    onsets = attack_onsets_s(flown(), "curved", TURN_AWAY, 3)
    assert len(onsets) == 3
    assert onsets == attack_onsets_s(flown(), "curved", TURN_AWAY, 3)
    assert onsets != attack_onsets_s(flown(), "other", TURN_AWAY, 3)
    earliest = (begin_ns - flown().start_ns) / 1e9 + SETTLED_S
    latest = (end_ns - flown().start_ns) / 1e9 - 30.0
    assert all(earliest - 0.1 <= onset <= latest + 0.1 for onset in onsets)


def test_a_hover_is_not_attacked() -> None:
    case = SimulatedCase("hover", "hover", FlightPlan("hover", duration_s=70.0), 1)
    found = survey(DEFAULT, (TURN_AWAY,), 2, case)
    assert found.onsets_s == ((),)
    assert found.hours == pytest.approx(70.0 / 3600.0)
    assert (found.name, found.day) == ("hover", "2025-06-15")


@pytest.mark.slow
def test_two_flights_are_judged_by_each_other(tmp_path: Path) -> None:
    missing = BagCase(tmp_path / "gone", "gone", "curved")
    cases = [BagCase(tmp_path / route, route, route) for route in ("curved", "straight")]
    for case in cases:
        make_bag(case.path, FlightPlan(case.name, 60.0), 8)
    steps: list[str] = []

    def progress(text: str, total: int) -> object:
        steps.append(f"{text} {total}")
        return lambda done: None

    tuning = tune([*cases, missing], "default", DEFAULT, per_hour=1.0, progress=progress)  # type: ignore[arg-type]
    assert steps[0] == "lag and noise 3"
    assert [failure.name for failure in tuning.failures] == ["gone"]
    assert [outcome.name for outcome in tuning.held_out] == ["curved", "straight"]
    assert tuning.attacked_before == tuning.attacked_after == []
    date = tuning.choices["date"]
    assert isinstance(date, Choice)
    chosen, given = (one.of(DateParameters).threshold for one in (tuning.parameters, DEFAULT))
    assert chosen == date.value < given
    assert tuning.hours == pytest.approx(sum(one.hours for one in tuning.surveys))


def test_without_a_clean_flight_nothing_is_tuned(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no clean flight to tune on\ngone: "):
        tune([BagCase(tmp_path / "gone", "gone", "any")], "default", DEFAULT, per_hour=1.0)
