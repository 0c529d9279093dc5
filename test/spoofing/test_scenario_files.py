# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
from __future__ import annotations

from pathlib import Path

import pytest

from hijack_detect.spoofing.scenario import (
    Scenario,
    ScenarioError,
    load_scenario,
    parse_scenario,
)
from hijack_detect.spoofing.schema import MODELS, Drift, FakeTrack

EXAMPLES = sorted((Path(__file__).parents[2] / "config" / "scenarios").glob("*.yaml"))

TWO = """
segments:
  - {start: 70, model: {type: altitude, step_m: 5}}
  - {start: 10, end: 20, name: first, model: {type: jump, distance_m: 5, bearing_deg: 90}}
"""


def test_examples_show_every_model():
    shown = {segment.model.type for path in EXAMPLES for segment in load_scenario(path).segments}
    assert shown == set(MODELS)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_is_valid_for_a_flight_of_two_minutes(path):
    scenario = load_scenario(path)
    scenario.check_within(120.0)
    assert all(segment.start_s == 60.0 for segment in scenario.segments)
    assert scenario.description


def test_segments_are_sorted_and_named():
    scenario = parse_scenario(TWO)
    assert [segment.name for segment in scenario.segments] == ["first", "altitude"]
    assert [(s.start_s, s.end_s) for s in scenario.segments] == [(10.0, 20.0), (70.0, None)]


def test_a_segment_may_start_where_another_ends():
    parse_scenario(TWO.replace("start: 70", "start: 20"))


def test_a_mapping_is_checked_like_text():
    model = {"type": "drift", "speed_m_s": 1, "bearing_deg": 0, "onset_acceleration_m_s2": 1}
    scenario = parse_scenario({"segments": [{"start": 1, "model": model}]})
    assert isinstance(scenario.segments[0].model, Drift)


def test_velocity_true_may_be_written_without_quotes():
    text = "segments: [{start: 1, model: {type: freeze, velocity: true}}]"
    assert parse_scenario(text).segments[0].model.velocity == "true"


def test_segments_cannot_be_changed():
    segment = parse_scenario(TWO).segments[0]
    with pytest.raises(ValueError, match="frozen"):
        segment.start_s = 3.0


def test_inside_the_flight():
    parse_scenario(TWO).check_within(70.1)
    with pytest.raises(ScenarioError) as error:
        parse_scenario(TWO, "two.yaml").check_within(15.0)
    assert error.value.problems == (
        "two.yaml: segment 2 'first': end: 20.0 is outside the flight, allowed is up to 15 s, "
        "or leave it out for the flight's end",
        "two.yaml: segment 1 'altitude': start: 70.0 is outside the flight, "
        "allowed is 0 to below 15 s",
    )


def test_a_scenario_can_be_made_without_a_file():
    assert Scenario("none", ()).segments == ()
    Scenario("none", ()).check_within(0.0)


def test_paths_may_be_text(tmp_path):
    path = tmp_path / "two.yaml"
    path.write_text(TWO)
    assert load_scenario(str(path)).source == str(path)


def test_rows_of_a_track_may_leave_height_out():
    text = """
segments:
  - start: 1
    model: {type: fake_track, positions: [[0, 0, 0], [1, 2, 3, 4]]}
"""
    model = parse_scenario(text).segments[0].model
    assert isinstance(model, FakeTrack)
    assert model.positions == ((0.0, 0.0, 0.0), (1.0, 2.0, 3.0, 4.0))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_a_scenario_written_as_yaml_reads_back_the_same(path: Path) -> None:
    scenario = load_scenario(path)
    again = parse_scenario(scenario.to_yaml())
    assert again.segments == scenario.segments
    assert again.description == scenario.description


def test_moving_a_scenario_keeps_lengths_and_distances() -> None:
    text = {
        "segments": [
            {"start": 10.0, "end": 12.5, "model": {"type": "freeze"}},
            {"start": 20.0, "model": {"type": "altitude", "step_m": 5.0}},
        ]
    }
    moved = parse_scenario(text).moved_to(100.0)
    assert [(one.start_s, one.end_s) for one in moved.segments] == [(100.0, 102.5), (110.0, None)]
    moved.check_within(200.0)
    with pytest.raises(ScenarioError, match="outside the flight"):
        moved.check_within(105.0)
