# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
from __future__ import annotations

import pytest

from hijack_detect.spoofing.scenario import ScenarioError, load_scenario, parse_scenario

JUMP = "{type: jump, distance_m: 20, bearing_deg: 90}"
SECOND = "segments:\n- {start: 1, end: 2, model: " + JUMP + "}\n- "


def problems(text: str) -> tuple[str, ...]:
    with pytest.raises(ScenarioError) as error:
        parse_scenario(text, "attack.yaml")
    assert str(error.value) == "\n".join(error.value.problems)
    return error.value.problems


DRIFT = "{start: 60, name: carry-off, model: {type: drift, bearing_deg: 0, "
TRACK = "{start: 60, model: {type: fake_track, positions: "


@pytest.mark.parametrize(
    ("segment", "said"),
    [
        (
            DRIFT + "speed_m_s: -3.0, onset_acceleration_m_s2: 1}}",
            "segment 2 'carry-off': model.speed_m_s: -3.0 is below 0",
        ),
        (
            DRIFT + "speed_m_s: 2000, onset_acceleration_m_s2: 1}}",
            "segment 2 'carry-off': model.speed_m_s: 2000 is above 1000",
        ),
        (
            DRIFT + "speed_m_s: 1, onset_acceleration_m_s2: 0}}",
            "segment 2 'carry-off': model.onset_acceleration_m_s2: 0 is not above 0",
        ),
        (
            DRIFT + "speed_m_s: .nan, onset_acceleration_m_s2: 1}}",
            "segment 2 'carry-off': model.speed_m_s: nan is not a finite number",
        ),
        (
            DRIFT + "speed_m_s: fast, onset_acceleration_m_s2: 1}}",
            "segment 2 'carry-off': model.speed_m_s: 'fast' is not a number",
        ),
        (
            DRIFT + "speed_m_s: 1e1, onset_acceleration_m_s2: 1}}",
            "segment 2 'carry-off': model.speed_m_s: '1e1' is not a number but text; "
            "write it without quotes, a power of ten as 1.0e+3",
        ),
        (
            DRIFT + "speed_m_s: true, onset_acceleration_m_s2: 1}}",
            "segment 2 'carry-off': model.speed_m_s: True is not a number",
        ),
        (
            DRIFT + "speed_m_s: 1}}",
            "segment 2 'carry-off': model.onset_acceleration_m_s2: missing; "
            "how fast the offset's speed builds up, m/s2",
        ),
        (
            DRIFT + "speed: 1, speed_m_s: 1, onset_acceleration_m_s2: 1}}",
            "segment 2 'carry-off': model.speed: unknown key; did you mean speed_m_s? allowed: "
            "type, speed_m_s, bearing_deg, onset_acceleration_m_s2, relative",
        ),
        (
            DRIFT + "speed_m_s: 1, onset_acceleration_m_s2: 1, relative: 1}}",
            "segment 2 'carry-off': model.relative: 1 is not true or false",
        ),
        (
            "{start: 60, model: {type: drfit}}",
            "segment 2: model.type: 'drfit' is unknown; allowed: "
            "jump, drift, fake_track, turn_away, replay, freeze, altitude, jitter, forge",
        ),
        (
            "{start: 60, model: {speed_m_s: 1}}",
            "segment 2: model.type: missing; allowed: "
            "jump, drift, fake_track, turn_away, replay, freeze, altitude, jitter, forge",
        ),
        ("{start: 60, model: jump}", "segment 2: model: 'jump' is not a mapping of keys"),
        ("{start: 60}", "segment 2: model: missing; the attack, selected by its key 'type'"),
        (
            "{model: " + JUMP + "}",
            "segment 2: start: missing; onset, seconds after the first message",
        ),
        ("{start: -1, model: " + JUMP + "}", "segment 2: start: -1 is below 0"),
        ("{start: .inf, model: " + JUMP + "}", "segment 2: start: inf is not a finite number"),
        (
            "{start: 60, end: 60, model: " + JUMP + "}",
            "segment 2: end: 60.0 is not after start (60.0)",
        ),
        (
            "{start: 60, stop: 70, model: " + JUMP + "}",
            "segment 2: stop: unknown key; allowed: start, end, name, velocity_consistent, model",
        ),
        ("{start: 60, name: 5, model: " + JUMP + "}", "segment 2: name: 5 is not text"),
        (
            "{start: 60, velocity_consistent: 'no', model: " + JUMP + "}",
            "segment 2: velocity_consistent: 'no' is not true or false",
        ),
        ("jump", "segment 2: 'jump' is not a mapping of keys"),
        (
            "{start: 60, model: {type: replay, from_s: 60}}",
            "segment 2: model.from_s: 60.0 is not before start (60.0)",
        ),
        (
            "{start: 60, model: {type: replay, from_s: -0.5}}",
            "segment 2: model.from_s: -0.5 is below 0",
        ),
        (
            "{start: 60, model: {type: freeze, velocity: fast}}",
            "segment 2: model.velocity: 'fast' is unknown; allowed: 'frozen', 'zero' or 'true'",
        ),
        (
            "{start: 60, model: {type: altitude}}",
            "segment 2: model.rate_m_s: missing; give rate_m_s, step_m or both",
        ),
        (
            "{start: 60, model: {type: jitter, sigma_m: 1, seed: 1.5}}",
            "segment 2: model.seed: 1.5 is not a whole number",
        ),
        (
            "{start: 60, model: {type: turn_away, angle_deg: 60, rate_deg_s: 0}}",
            "segment 2: model.rate_deg_s: 0 is not above 0",
        ),
        (TRACK + "5}}", "segment 2: model.positions: 5 is not a list"),
        (
            TRACK + "[[0, 0, 0]]}}",
            "segment 2: model.positions: has 1 entries, at least 2 are needed",
        ),
        (
            TRACK + "[[0, 0, 0], [1, .inf, 0]]}}",
            "segment 2: model.positions: row 2, east_m: inf is not a finite number",
        ),
        (
            TRACK + "[[0, 0, 0], here]}}",
            "segment 2: model.positions: row 2: 'here' is not a list",
        ),
        (
            TRACK + "[[0, 0, 0], [1, 2]]}}",
            "segment 2: model.positions: row 2 has 2 numbers, allowed are 3 or 4: "
            "[t_s, east_m, north_m] or [t_s, east_m, north_m, up_m]",
        ),
        (
            TRACK + "[[1, 0, 0], [2, 2, 0]]}}",
            "segment 2: model.positions: row 1 has t_s 1.0, it must be 0 (the onset)",
        ),
        (
            TRACK + "[[0, 0, 0], [1, 2, 0], [1.0005, 2, 0]]}}",
            "segment 2: model.positions: row 3 has t_s 1.0005, it must be at least 0.001 s "
            "after row 2 (1.0)",
        ),
        (
            TRACK + "[[0, 0, 0], [0.5, 3000, 0]]}}",
            "segment 2: model.positions: row 2 needs 6000 m/s, which is above 1000 m/s",
        ),
        (
            TRACK + "[[0, 0, 0], [1, 1.0e+7, 0]]}}",
            "segment 2: model.positions: row 2 has a number beyond 1000000: (1.0, 10000000.0, 0.0)",
        ),
        (
            TRACK + "[[0, 0, 0], [1, 0, 0, 5]], speed_scale: flight}}",
            "segment 2: model.speed_scale: flight needs a first leg of at least 0.1 m/s over "
            "ground, row 2 makes it 0 m/s",
        ),
        (
            "{start: 1.5, name: b, model: " + JUMP + "}",
            "segment 2 'b': start: 1.5 overlaps segment 1, which lasts from 1.0 s to 2.0 s",
        ),
    ],
)
def test_a_bad_segment_is_refused_with_its_reason(segment, said):
    assert problems(SECOND + segment) == ("attack.yaml: " + said,)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty; it needs the key 'segments'"),
        ("- 1\n", "is not a mapping of keys; it needs the key 'segments'"),
        ("{}", "segments: missing; the attacks"),
        ("segments: []", "segments: has 0 entries, at least 1 are needed"),
        ("segments: {}", "segments: {} is not a list"),
        (
            "segment: 1\nsegments: [{start: 1, model: " + JUMP + "}]",
            "segment: unknown key; did you mean segments? allowed: description, segments",
        ),
        (
            "1: 2\nsegments: [{start: 1, model: " + JUMP + "}]",
            "1: 1 is no key; keys are text",
        ),
        (
            "segments:\n- start: 1\n  start: 2\n",
            "line 3, column 3: key 'start' is given twice, first in line 2",
        ),
        (
            "segments: [{start: 1, model: {type: jump, ",
            "line 1, column 43: while parsing a flow node, "
            "expected the node content, but found '<stream end>'",
        ),
        (
            "a: b: c",
            "line 1, column 5: mapping values are not allowed here",
        ),
        (
            "--- {}\n--- {}\n",
            "line 2, column 1: expected a single document in the stream, but "
            "found another document",
        ),
        ("? [a, b]\n: 1\n", "line 1, column 3: while constructing a mapping, found unhashable key"),
        ("a: 2024-13-45\n", "month must be in 1..12"),
    ],
)
def test_a_bad_file_is_refused_with_its_reason(text, said):
    assert problems(text) == ("attack.yaml: " + said,)


def test_every_problem_is_told_at_once():
    text = SECOND + "{start: -1, model: {type: jump, distance_m: -1}}"
    assert problems(text) == (
        "attack.yaml: segment 2: start: -1 is below 0",
        "attack.yaml: segment 2: model.distance_m: -1 is below 0",
        "attack.yaml: segment 2: model.bearing_deg: missing; "
        "direction, degrees clockwise from North",
    )


def test_an_open_segment_must_be_the_last():
    text = "segments: [{start: 1, model: " + JUMP + "}, {start: 9, model: " + JUMP + "}]"
    assert problems(text) == (
        "attack.yaml: segment 2: start: 9.0 overlaps segment 1, which lasts from 1.0 s to "
        "the flight's end",
    )


@pytest.mark.parametrize(
    "tag", ["!!python/object/apply:os.mkdir", "!!python/name:os.system", "!!python/module:os"]
)
def test_a_tag_that_would_run_something_is_refused(tag, tmp_path):
    target = tmp_path / "made"
    (said,) = problems(f"segments: {tag} ['{target}']")
    assert said.startswith("attack.yaml: line 1, column 11: could not determine a constructor")
    assert not target.exists()


def test_endless_nesting_is_refused():
    (said,) = problems("segments: " + "[" * 5000)
    assert said.startswith("attack.yaml: nested too deeply")


def test_an_alias_of_itself_is_refused():
    (said,) = problems("segments: &a [*a]\n")
    assert said.startswith("attack.yaml: segment 1: [[")
    assert said.endswith("is not a mapping of keys")


def test_a_list_of_wrong_numbers_is_cut_short():
    said = problems(SECOND + TRACK + "[" + "[a, b, c], " * 50 + "]}}")
    assert len(said) == 21
    assert said[-1] == "attack.yaml: and 130 more problems"


def test_a_number_beyond_all_bounds_is_refused():
    (said,) = problems(SECOND + "{start: 1" + "0" * 400 + ", model: " + JUMP + "}")
    assert said.startswith("attack.yaml: segment 2: start: 1000")
    assert said.endswith("is not a number")


def test_a_missing_file_is_named(tmp_path):
    path = tmp_path / "none.yaml"
    with pytest.raises(ScenarioError) as error:
        load_scenario(path)
    assert str(error.value) == f"{path}: cannot be read: No such file or directory"


def test_a_binary_file_is_named(tmp_path):
    path = tmp_path / "flight.mcap"
    path.write_bytes(b"\x89MCAP0\r\n\xff")
    with pytest.raises(ScenarioError, match=r"flight\.mcap: is not UTF-8 text \(byte 0\)"):
        load_scenario(path)


def test_an_error_names_the_file(tmp_path):
    path = tmp_path / "attack.yaml"
    path.write_text("segments: []")
    with pytest.raises(ScenarioError, match=r"attack\.yaml: segments: has 0 entries"):
        load_scenario(path)
