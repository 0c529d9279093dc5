# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attack families: the same for everyone, to any side, sizes that differ in size only."""

from __future__ import annotations

import itertools
from collections import Counter

import pytest

from hijack_detect.evaluation.trials.families import (
    ANY_PHASE,
    CLEAN,
    FAMILIES,
    WATCHED_S,
    attacks_on,
    climb,
    scenario_of,
)
from hijack_detect.spoofing.schema import Altitude, Drift, FakeTrack, Freeze, Jump, Replay

SPANS = [(30.0, 120.0), (150.0, 280.0)]
PLACED = attacks_on("a flight", SPANS, 300.0, moving=4, any_phase=3)


def test_every_onset_has_every_size_and_one_without_attack() -> None:
    moving = sum(map(len, FAMILIES.values()))
    assert len(PLACED) == 4 * (moving + 1) + 3 * (sum(map(len, ANY_PHASE.values())) + 1)
    counts = Counter(one.family for one in PLACED)
    assert counts == {
        CLEAN: 7,
        "jump_any_phase": 21,
        "drift_any_phase": 6,
        **{family: 4 * len(sizes) for family, sizes in FAMILIES.items()},
    }
    assert all((one.scenario is None) == (one.family == CLEAN) for one in PLACED)


def test_onsets_are_in_order_and_in_the_flight() -> None:
    onsets = [one.onset_s for one in PLACED]
    assert onsets == sorted(onsets)
    assert max(onsets) <= 300.0 - WATCHED_S + 0.05
    for one in PLACED:
        if one.family in FAMILIES:
            assert any(begin <= one.onset_s <= end for begin, end in SPANS)
        if one.scenario is not None:
            (segment,) = one.scenario.segments
            assert (segment.start_s, segment.end_s) == (one.onset_s, None)


def test_attacks_are_the_same_each_time_and_others_on_another_flight() -> None:
    again = attacks_on("a flight", SPANS, 300.0, moving=4, any_phase=3)
    assert [one.scenario for one in again] == [one.scenario for one in PLACED]
    other = attacks_on("another", SPANS, 300.0, moving=4, any_phase=3)
    assert [one.onset_s for one in other] != [one.onset_s for one in PLACED]


def test_sizes_at_one_onset_go_to_the_same_side_and_onsets_to_different_ones() -> None:
    jumps = [one for one in PLACED if one.family == "jump" and one.scenario]
    bearings = []
    for _, group in itertools.groupby(jumps, key=lambda one: one.onset_s):
        models = [one.scenario.segments[0].model for one in group if one.scenario]
        assert all(isinstance(model, Jump) for model in models)
        assert len({model.bearing_deg for model in models}) == 1
        assert [model.distance_m for model in models] == [2.0, 5.0, 8.0, 10.0, 15.0, 20.0, 40.0]
        bearings.append(models[0].bearing_deg)
    assert len(set(bearings)) == 4


def test_families_are_what_they_are_called() -> None:
    kinds = {
        "jump": Jump,
        "drift": Drift,
        "drift_position_only": Drift,
        "fake_track": FakeTrack,
        "freeze": Freeze,
        "altitude_ramp": Altitude,
        "altitude_step": Altitude,
        "replay": Replay,
    }
    for one in PLACED:
        if one.scenario is None:
            continue
        (segment,) = one.scenario.segments
        assert isinstance(segment.model, kinds.get(one.family, type(segment.model)))
        assert segment.velocity_consistent == (one.family != "drift_position_only")
        if isinstance(segment.model, Drift):
            assert one.figures == {
                "acceleration": segment.model.onset_acceleration_m_s2,
                "speed": segment.model.speed_m_s,
            }
        if isinstance(segment.model, Replay):
            assert segment.model.from_s == pytest.approx(max(0.0, one.onset_s - 30.0))


def test_both_sides_are_drawn_unless_one_is_asked_for() -> None:
    def rates(side: float | None) -> set[float]:
        scenarios = [scenario_of("x", climb(2.0, side), "f", float(t)) for t in range(30)]
        models = [scenario.segments[0].model for scenario in scenarios]
        return {model.rate_m_s for model in models if isinstance(model, Altitude)}

    assert rates(None) == {2.0, -2.0}
    assert rates(-1.0) == {-2.0}


def test_a_flight_without_forward_flight_has_attacks_at_any_phase_only() -> None:
    found = attacks_on("hover", [], 200.0, any_phase=2)
    assert {one.family for one in found} == {CLEAN, *ANY_PHASE}
