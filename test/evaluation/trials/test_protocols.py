# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The generated flights: how many of what, always the same, and attacked by fake tracks."""

from __future__ import annotations

import itertools
import math
import pickle
from collections import Counter

import numpy as np
import pytest

from hijack_detect.evaluation.scores.evaluate import evaluate
from hijack_detect.evaluation.trials.cases import MAX_SCALE
from hijack_detect.evaluation.trials.fake_tracks import ATTACK_S, TRACKS, fake_track
from hijack_detect.evaluation.trials.limits import (
    CLASSES,
    FIRST_SEED,
    FLIGHTS,
    SEEDS_OF_A_CLASS,
    limits,
)
from hijack_detect.evaluation.trials.protocols import NOISE_M, PROTOCOLS, feng2018
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.simulation.plan import forward_end_s, forward_start_s
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.schema import FakeTrack

CASES = feng2018()


def courses(scenario: Scenario) -> list[float]:
    """Direction of each leg of a fake track, degrees to the left of the course at onset."""
    model = scenario.segments[0].model
    assert isinstance(model, FakeTrack)
    legs = itertools.pairwise(model.positions)
    return [math.degrees(math.atan2(b[2] - a[2], b[1] - a[1])) for a, b in legs]


def test_classes_are_those_of_the_paper() -> None:
    assert Counter(case.kind for case in CASES) == {"straight": 25, "curved": 25, "hijacked": 50}
    assert Counter(case.plan.route for case in CASES if case.scenario) == {
        "straight": 25,
        "curved": 25,
    }
    assert all((case.scenario is not None) == (case.kind == "hijacked") for case in CASES)


def test_a_larger_scale_adds_flights_and_changes_none() -> None:
    more = feng2018(3)
    assert len(more) == 300
    assert len({case.name for case in more}) == len({case.seed for case in more}) == 300
    assert all(case in more for case in CASES)
    for scale in (0, 201):
        with pytest.raises(ValueError, match=f"scale is {scale}"):
            feng2018(scale)


def test_cases_are_made_the_same_each_time_and_can_be_sent_to_other_processes() -> None:
    assert feng2018() == CASES
    assert pickle.loads(pickle.dumps(CASES)) == CASES


def test_every_fake_track_is_flown_on_every_route() -> None:
    flown = {(c.plan.route, c.scenario.segments[0].name) for c in CASES if c.scenario is not None}
    assert flown == {(route, shape) for route in ("straight", "curved") for shape in TRACKS}


def test_the_noisy_variant_flies_the_same_with_noise_on_the_fake_fixes() -> None:
    noisy = PROTOCOLS["feng2018_noisy"](1)
    offsets = []
    for case, other in zip(CASES, noisy, strict=True):
        assert (case.name, case.plan, case.seed) == (other.name, other.plan, other.seed)
        if case.scenario is None or other.scenario is None:
            assert case == other
            continue
        drawn, recorded = (one.scenario.segments[0] for one in (case, other))  # type: ignore[union-attr]
        assert (drawn.start_s, drawn.name) == (recorded.start_s, recorded.name)
        rows = zip(drawn.model.positions, recorded.model.positions, strict=True)
        offsets += [(a[1] - b[1], a[2] - b[2]) for a, b in rows if a[0] > 0.0]
        assert drawn.model.positions[0] == recorded.model.positions[0] == (0.0, 0.0, 0.0)
    # 3000 draws on each axis: within four standard errors.
    assert np.std(offsets, axis=0) == pytest.approx(NOISE_M, rel=0.06)
    assert np.mean(offsets, axis=0) == pytest.approx(0.0, abs=0.003)


def test_attacks_lie_in_forward_flight() -> None:
    for case in feng2018(2):
        if case.scenario is None:
            continue
        (segment,) = case.scenario.segments
        assert segment.end_s == pytest.approx(segment.start_s + ATTACK_S)
        assert forward_start_s(case.plan) + 10.0 < segment.start_s
        assert segment.end_s < forward_end_s(case.plan) + 0.1
        assert segment.velocity_consistent


@pytest.mark.parametrize("seed", range(8))
def test_fake_tracks_start_ahead_and_turn_as_their_names_say(seed: int) -> None:
    straight, turn, s_shape = (
        courses(fake_track(shape, 40.0, np.random.default_rng(seed)))
        for shape in ("straight", "turn", "s_shape")
    )
    assert set(straight) == {0.0}
    assert turn[0] == pytest.approx(0.0)
    assert 40.0 <= abs(turn[-1]) <= 110.0
    assert s_shape[0] == pytest.approx(0.0)
    assert s_shape[-1] == pytest.approx(0.0, abs=1e-9)
    assert max(map(abs, s_shape)) >= 39.0
    steps = np.abs(np.diff(turn + s_shape[::-1]))
    assert steps[: len(turn) - 1].max() <= 15.0 + 1e-9  # 30°/s for half a second


def test_a_clean_and_a_hijacked_flight() -> None:
    few = [CASES[index] for index in (0, 50)]
    found = evaluate(few, policy_parameters("default"), source="few", policy="default")
    assert [flight.name for flight in found.flights] == [case.name for case in few]
    assert [flight.kind for flight in found.flights] == [case.kind for case in few]
    assert found.failed == []
    date = found.methods["date"]
    assert (date.type_1.total, date.type_2.total) == (1, 1)
    for flight, case in zip(found.flights, few, strict=True):
        onset = None if case.scenario is None else case.scenario.segments[0].start_s
        assert flight.onset_s == onset


def test_limits_has_classes_of_their_own() -> None:
    cases = limits()
    counts = Counter(case.kind for case in cases)
    assert counts == {
        "clean_straight": 15,
        "clean_curved": 15,
        **dict.fromkeys(CLASSES, 30),
    }
    more = limits(4)
    assert len({case.seed for case in more}) == len({case.name for case in more}) == len(more)
    assert all(count in (60, 120) for count in Counter(case.kind for case in more).values())
    assert all(case in more for case in cases)
    assert pickle.loads(pickle.dumps(cases)) == cases
    with pytest.raises(ValueError, match="scale is 0"):
        limits(0)


def test_attacks_of_limits_lie_in_forward_flight_on_both_routes() -> None:
    attacked = [case for case in limits() if case.scenario is not None]
    for case in attacked:
        assert case.scenario is not None
        (segment,) = case.scenario.segments
        assert segment.end_s is None
        assert forward_start_s(case.plan) + 10.0 < segment.start_s < forward_end_s(case.plan) - 39.0
    assert {(case.kind, case.plan.route) for case in attacked} == set(
        itertools.product(CLASSES, ("straight", "curved"))
    )
    assert min(case.seed for case in limits()) == FIRST_SEED == 60_000_000
    assert FLIGHTS * MAX_SCALE <= SEEDS_OF_A_CLASS
