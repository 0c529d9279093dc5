# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attacks that are set and changed on a live stream."""

from __future__ import annotations

import dataclasses
import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.parameters import ParameterError
from hijack_detect.spoofing.live import NOTHING, LiveSpoofer, SpooferParameters, chosen_attack
from hijack_detect.spoofing.scenario import ScenarioError, parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import NANOSECONDS, FixSample, SatelliteSample

MODELS = {
    "jump": {"type": "jump", "distance_m": 20.0, "bearing_deg": 30.0, "relative": True},
    "drift": {
        "type": "drift", "speed_m_s": 3.0, "bearing_deg": 30.0, "onset_acceleration_m_s2": 0.7,
        "relative": True,
    },
    "fake_track": {
        "type": "fake_track", "frame": "course", "speed_scale": "flight",
        "positions": [[0, 0, 0], [1, 5, 0], [3, 14, 6, 1], [6, 17, 20, 3]],
    },
    "turn_away": {"type": "turn_away", "angle_deg": -70.0, "rate_deg_s": 20.0},
    "freeze": {"type": "freeze"},
    "altitude": {"type": "altitude", "rate_m_s": 1.5, "onset_acceleration_m_s2": 0.5},
    "jitter": {"type": "jitter", "sigma_m": 1.0, "seed": 3, "sigma_m_s": 0.2},
    "forge": {
        "type": "forge", "seed": 3, "altitude_sigma_m": 2.0, "satellites": [30, 40],
        "accuracy_m": [0.5, 9.0], "horizontal_sigma_m": 1.0, "drift_speed_m_s": 2.0,
        "relative": True,
    },
}  # fmt: skip


def at_once(model):
    return parse_scenario({"segments": [{"start": 0.0, "model": model}]})


def play(spoofer, flight, changes=None, order="fvs"):
    """What is reported of each stamp; `changes` sets an attack before the fix of an index."""
    rows = []
    for index, (fix, velocity) in enumerate(zip(flight.fixes, flight.velocities, strict=True)):
        if changes and index in changes:
            spoofer.set(changes[index])
        number = SatelliteSample(fix.stamp_ns, 12)
        ask = {
            "f": lambda one=fix: spoofer.fix(one),
            "v": lambda one=velocity: spoofer.velocity(one),
            "s": lambda one=number: spoofer.satellites(one),
        }
        said = {kind: ask[kind]() for kind in order}
        rows.append((said["f"], said["v"], said["s"], spoofer.active(fix.stamp_ns)))
    return rows


@pytest.mark.parametrize("kind", MODELS)
def test_a_model_set_in_flight_is_the_segment_of_a_file_that_starts_there(tools, kind):
    true = tools.flight("waving")
    start = {"start": 10.0, "model": MODELS[kind]}
    wanted = play(Spoofer(parse_scenario({"segments": [start]}), true.first_ns), true)
    live = LiveSpoofer()
    assert play(live, true, {50: at_once(MODELS[kind])}) == wanted
    assert live.onset_ns == true.fixes[50].stamp_ns == live.start_ns
    assert [row[3] for row in wanted] == [False] * 50 + [True] * 101


@pytest.mark.parametrize("kind", MODELS)
def test_a_velocity_that_comes_before_its_fix_is_still_true_at_the_onset(tools, kind):
    true = tools.flight("waving")
    change = {50: at_once(MODELS[kind])}
    first, second = (play(LiveSpoofer(), true, change, order) for order in ("fvs", "vfs"))
    assert second[50][1] is true.velocities[50]
    assert [row[0] for row in first] == [row[0] for row in second]
    assert [row[1:] for row in first[51:]] == [row[1:] for row in second[51:]]


@pytest.mark.parametrize("kind", MODELS)
def test_an_attack_that_is_set_again_starts_anew_from_the_true_flight(tools, kind):
    true = tools.flight("waving")
    attack = at_once(MODELS[kind])
    again = play(LiveSpoofer(), true, {50: attack, 80: attack})
    late = play(LiveSpoofer(), true, {80: attack})
    assert again[80:] == late[80:]


@settings(max_examples=25)
@given(changes=st.dictionaries(st.integers(0, 79), st.sampled_from(sorted(MODELS)), min_size=1))
def test_each_attack_is_as_if_there_had_been_no_other(tools, changes):
    true = tools.flight("waving", seconds=16.0)
    attacks = {index: at_once(MODELS[kind]) for index, kind in changes.items()}
    rows = play(LiveSpoofer(), true, attacks)
    order = [*sorted(attacks), len(rows)]
    assert all(row[0] is fix for row, fix in zip(rows[: order[0]], true.fixes, strict=False))
    for start, end in itertools.pairwise(order):
        alone = play(LiveSpoofer(), true, {start: attacks[start]})
        assert rows[start:end] == alone[start:end]


def test_none_ends_an_attack_and_a_late_velocity_is_still_under_it(tools):
    true = tools.flight("straight")
    live = LiveSpoofer()
    drift = at_once(MODELS["drift"])
    rows = play(
        live,
        dataclasses.replace(true, fixes=true.fixes[:60], velocities=true.velocities[:60]),
        {10: drift},
    )
    live.set(NOTHING)
    assert live.fix(true.fixes[60]) is true.fixes[60]
    assert live.offset_m == 0.0 and not live.active(true.fixes[60].stamp_ns)
    assert live.onset_ns is None
    assert live.velocity(true.velocities[59]) == rows[59][1] != true.velocities[59]
    assert live.velocity(true.velocities[60]) is true.velocities[60]


def test_the_times_of_a_scenario_count_from_the_fix_after_it_was_set(tools):
    true = tools.flight("waving")
    text = {
        "segments": [
            {"start": 2.0, "end": 4.0, "model": {"type": "replay", "from_s": 0.5}},
            {"start": 6.0, "end": 8.0, "model": MODELS["jump"]},
        ]
    }
    scenario = parse_scenario(text)
    later = Spoofer(scenario, true.fixes[40].stamp_ns)
    wanted = play(later, true)
    live = LiveSpoofer()
    assert play(live, true, {40: scenario}) == wanted
    active = [row[3] for row in wanted]
    assert active.index(True) == 50 and sum(active) == 20
    assert wanted[50][0].latitude_deg != true.fixes[50].latitude_deg
    assert play(LiveSpoofer(scenario), true) == play(Spoofer(scenario, true.first_ns), true)


def test_the_offset_is_that_of_the_last_fix(tools):
    true = tools.flight("hover")
    live = LiveSpoofer(at_once({"type": "jump", "distance_m": 30.0, "bearing_deg": 0.0}))
    live.fix(true.fixes[0])
    assert live.offset_m == pytest.approx(30.0, abs=1e-3)
    live.fix(FixSample(true.fixes[1].stamp_ns, 0.0, 0.0, 0.0, has_fix=False))
    assert live.offset_m == 0.0


@pytest.mark.parametrize("ahead_s", [-20.0, 4000.0])
def test_another_flight_starts_the_attack_anew(tools, ahead_s):
    true = tools.flight("straight")
    live = LiveSpoofer(at_once(MODELS["drift"]))
    first = play(live, true)
    by_ns = round(ahead_s * NANOSECONDS) + true.fixes[-1].stamp_ns - true.first_ns
    moved = dataclasses.replace(
        true,
        fixes=tuple(dataclasses.replace(f, stamp_ns=f.stamp_ns + by_ns) for f in true.fixes),
        velocities=tuple(
            dataclasses.replace(v, stamp_ns=v.stamp_ns + by_ns) for v in true.velocities
        ),
    )
    second = play(live, moved)
    assert live.restarts == 1
    assert [row[0].latitude_deg for row in first] == [row[0].latitude_deg for row in second]
    assert [row[1].velocity for row in first] == [row[1].velocity for row in second]


def test_a_short_step_back_or_a_gap_changes_nothing(tools):
    true = tools.flight("straight")
    live = LiveSpoofer(at_once(MODELS["drift"]))
    rows = [live.fix(true.fixes[index]) for index in (0, 5, 4, 6, 90)]
    whole = play(LiveSpoofer(at_once(MODELS["drift"])), true)
    assert rows == [whole[index][0] for index in (0, 5, 4, 6, 90)]
    assert live.restarts == 0


def parameters(**values):
    return SpooferParameters.from_mapping(values)


def test_soft_forges_the_basic_parameters_and_hard_all():
    (soft,) = chosen_attack(parameters(mode="soft", satellites_low=3)).segments
    assert soft.model.satellites == (3, 20) and soft.model.accuracy_m == (0.5, 8.0)
    assert soft.model.drift_speed_m_s == soft.model.horizontal_sigma_m == 0.0
    (hard,) = chosen_attack(parameters(mode="hard", bearing_deg=45.0)).segments
    assert (hard.model.drift_speed_m_s, hard.model.bearing_deg) == (2.0, 45.0)
    assert hard.model.velocity_sigma_m_s == 0.5
    assert chosen_attack(parameters()) is NOTHING


def test_a_model_is_the_text_of_a_scenario_file():
    (segment,) = chosen_attack(parameters(mode="model", model="type: freeze")).segments
    assert (segment.start_s, segment.end_s, segment.name) == (0.0, None, "freeze")


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"mode": "model"}, "mode model needs an attack in the parameter 'model'"),
        ({"mode": "model", "model": "{"}, "parameter 'model': line "),
        ({"mode": "model", "model": "jump"}, "parameter 'model': model: 'jump' is not a mapping"),
        (
            {"mode": "model", "model": "{type: drift, speed_m_s: -1, bearing_deg: 0}"},
            "parameter 'model': model.speed_m_s: -1 is below 0\n"
            "parameter 'model': model.onset_acceleration_m_s2: missing",
        ),
        (
            {"mode": "model", "model": "{type: replay, from_s: 1}"},
            "parameter 'model': a replay needs a recording of what went before; write it into a "
            "scenario file and use mode scenario",
        ),
        ({"mode": "scenario"}, "mode scenario needs a file in the parameter 'scenario'"),
        ({"mode": "scenario", "scenario": "/no.yaml"}, "/no.yaml: cannot be read"),
        ({"mode": "loud"}, "parameter 'mode' must be one of none, soft, hard, model, scenario"),
        ({"satellites_low": 21}, "parameter 'satellites_low' is 21, above 'satellites_high' (20)"),
        ({"accuracy_low_m": 9.0}, "parameter 'accuracy_low_m' is 9.0, above 'accuracy_high_m'"),
        ({"mode": "soft", "correlation_s": 1e-5}, "mode soft: segment 1 'soft': model.correlation"),
    ],
)
def test_what_cannot_be_run_is_refused_with_a_sentence(values, said):
    with pytest.raises((ParameterError, ScenarioError)) as error:
        chosen_attack(parameters(**values))
    assert str(error.value).startswith(said)


def test_what_was_given_is_checked_even_if_the_mode_does_not_use_it():
    wrong = parameters(model="{type: jmup}", scenario="/no.yaml")
    assert chosen_attack(wrong) is NOTHING
    for name in ("model", "scenario"):
        with pytest.raises(ValueError, match=r"jmup|cannot be read"):
            chosen_attack(wrong, {name})
