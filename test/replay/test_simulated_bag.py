# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The bags of the project are made by the commands in their README; attacks come with labels."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.bags.topics import PRESETS, detect
from hijack_detect.cli.simulate import simulate
from hijack_detect.replay.simulated_bag import make_bag
from hijack_detect.replay.truth import known_attack, truth_track
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.spoofing.scenario import ScenarioError, load_scenario
from hijack_detect.streams.messages import fix_sample

ROOT = Path(__file__).parents[2]
CARRY_OFF = ROOT / "config/scenarios/carry_off.yaml"
SHORT = FlightPlan("curved", duration_s=60.0)
BAGS = {
    "curved_8": "--route curved --seed 8",
    "straight_3": "--route straight --seed 3",
    "curved_no_velocity_5": "--route curved --seed 5 --without velocity --without mag",
}


def messages(path: Path) -> list[RawMessage]:
    with BagReader(path) as bag:
        return list(bag.messages())


def command(out: Path, options: str) -> Result:
    return CliRunner().invoke(simulate, [str(out), *shlex.split(options)])


@pytest.mark.parametrize("name", BAGS)
def test_the_command_makes_the_bag(name: str, tmp_path: Path) -> None:
    """Message for message: the file's bytes also depend on the versions of rosbags and zstd."""
    committed = ROOT / "bags" / name
    done = command(tmp_path / name, BAGS[name])
    assert done.exit_code == 0, done.output
    assert messages(tmp_path / name) == messages(committed)
    assert (tmp_path / name / "label.json").read_text() == (committed / "label.json").read_text()
    assert sum(file.stat().st_size for file in committed.iterdir()) < 3_000_000


@pytest.mark.parametrize("name", BAGS)
def test_the_readme_has_the_command(name: str) -> None:
    line = f"hijack-detect simulate bags/{name} {BAGS[name]}"
    assert line in (ROOT / "bags" / "README.md").read_text().splitlines()


def test_same_bytes_twice(tmp_path: Path) -> None:
    scenario = load_scenario(CARRY_OFF).moved_to(30.0)
    for parent in ("a", "b"):
        make_bag(tmp_path / parent / "bag", SHORT, 4, scenario=scenario)
    for file in ("bag.mcap", "metadata.yaml", "label.json"):
        first, second = (tmp_path / parent / "bag" / file for parent in ("a", "b"))
        assert first.read_bytes() == second.read_bytes()


def test_topics() -> None:
    with BagReader(ROOT / "bags" / "curved_8") as bag:
        assert detect(bag.topics) == PRESETS["default"]
        assert set(bag.topics) == {
            *dict(PRESETS["default"].items()).values(),
            "/truth/fix",
            "/truth/attitude",
            "/spoof_active",
        }
    with BagReader(ROOT / "bags" / "curved_no_velocity_5") as bag:
        found = detect(bag.topics)
        assert found.velocity is None
        assert found.mag is None
        assert found.pressure == "/pressure"


def test_a_clean_bag_says_that_it_is_clean() -> None:
    with BagReader(ROOT / "bags/curved_8") as bag:
        fixes = [raw.log_ns for raw in bag.messages(["/gps/fix"])]
        flags = list(bag.messages(["/spoof_active"]))
        assert [raw.log_ns for raw in flags] == fixes
        assert not any(bag.deserialize(raw).data for raw in flags)
        assert known_attack(bag).attack is None
    label = json.loads((ROOT / "bags/curved_8/label.json").read_text())
    assert (label["id"], label["kind"], label["route"], label["yaw"], label["attack"]) == (
        "curved_8", "curved", "curved", "path", None
    )  # fmt: skip
    assert label["t_takeoff"] < label["t_forward_start"] < label["t_forward_end"] < 110.0
    assert label["duration"] == 110.0


def test_an_attacked_bag_holds_the_truth_of_the_attack(tmp_path: Path) -> None:
    scenario = load_scenario(CARRY_OFF).moved_to(30.0)
    label = make_bag(tmp_path / "bag", SHORT, 4, scenario=scenario)
    assert json.loads((tmp_path / "bag/label.json").read_text()) == label
    attack = label["attack"]
    assert label["kind"] == "hijack"
    assert (attack["kind"], attack["t_start"], attack["t_end"]) == ("drift", 30.0, 60.0)
    assert attack["max_separation_h_m"] == pytest.approx(55.0, abs=1.0)
    assert attack["max_separation_v_m"] == 0.0
    assert attack["max_deviation_m"] == pytest.approx(55.0, abs=4.0)
    assert attack["real_drone_deviated"] is True
    with BagReader(tmp_path / "bag") as bag:
        flags = [(raw.log_ns, bag.deserialize(raw).data) for raw in bag.messages(["/spoof_active"])]
        assert all(on == (log_ns >= bag.start_ns + 30 * 10**9) for log_ns, on in flags)
        found, track = known_attack(bag).attack, truth_track(bag)
        assert found is not None
        assert found.onset_ns == next(log_ns for log_ns, on in flags if on)
        assert track is not None
        last = [fix_sample(bag.deserialize(raw)) for raw in bag.messages(["/gps/fix"])][-1]
        assert track.separation_m(last) == pytest.approx(attack["max_separation_h_m"], abs=0.1)


def test_a_refused_jump_does_not_move_the_vehicle(tmp_path: Path) -> None:
    scenario = load_scenario(ROOT / "config/scenarios/jump.yaml").moved_to(30.0)
    short = scenario.segments[0].model_copy(update={"end_s": 35.0})
    label = make_bag(tmp_path / "bag", SHORT, 4, scenario=type(scenario)(scenario.source, (short,)))
    assert label["attack"]["max_separation_h_m"] == pytest.approx(20.0, abs=0.1)
    assert label["attack"]["t_ramp_end"] == 30.0
    assert label["attack"]["real_drone_deviated"] is False


@pytest.mark.parametrize(("route", "kind"), [("hover", "hardneg"), ("fixed_yaw", "hardneg")])
def test_flights_that_tempt_a_detector_are_labelled(tmp_path: Path, route: str, kind: str) -> None:
    label = make_bag(tmp_path / "bag", FlightPlan(route, duration_s=60.0, wind_m_s=2.0), 1)
    assert (label["kind"], label["yaw"], label["wind"]["spd"]) == (kind, "fixed", 2.0)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ("--seed -1", "seed is -1"),
        ("--duration 5", "duration is 5.0"),
        ("--duration nan", "duration is nan"),
        ("--speed 40", "speed is 40.0"),
        ("--height 1", "height is 1.0"),
        ("--wind 30", "wind is 30.0"),
        ("--route round", "'round' is not one of"),
        ("--without imu", "'imu' is not one of"),
        ("--attack no_such_scenario", "no_such_scenario: cannot be read"),
        ("--attack carry_off --onset 200", "outside the flight"),
        ("--onset 20", "give --attack"),
    ],
)
def test_what_cannot_be_made_is_refused(tmp_path: Path, options: str, reason: str) -> None:
    done = command(tmp_path / "bag", options)
    assert done.exit_code == 2
    assert reason in done.output
    assert "Traceback" not in done.output
    assert not (tmp_path / "bag").exists()


def test_the_command_tells_what_it_made(tmp_path: Path) -> None:
    options = "--duration 60 --seed 4 --speed 6 --wind 1 --attack carry_off --onset 40"
    done = command(tmp_path / "bag", options)
    assert done.exit_code == 0, done.output
    assert "60 s, route curved, 6.0 m/s, wind 1.0 m/s, seed 4" in done.output
    assert "Attacked from 40 s: up to 35 m off its route." in done.output
    again = command(tmp_path / "bag", options)
    assert again.exit_code == 2
    assert "exists" in again.output


def test_an_unknown_input_cannot_be_left_out(tmp_path: Path) -> None:
    with pytest.raises(BagError, match="cannot leave out 'imu'"):
        make_bag(tmp_path / "bag", SHORT, 1, without=("imu",))
    with pytest.raises(ScenarioError, match="outside the flight"):
        make_bag(tmp_path / "bag", SHORT, 1, scenario=load_scenario(CARRY_OFF))
    assert not (tmp_path / "bag").exists()
