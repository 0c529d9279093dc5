# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node gps_spoofer between a receiver and its users."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import TwistStamped
from live import stamp_ns, values_of
from ros import Graph
from spoofer_link import START_NS, STEP_NS, TOPICS, Link, true_messages
from std_msgs.msg import UInt32

from hijack_detect.spoofing.live import LiveSpoofer, SpooferParameters, chosen_attack
from hijack_detect.spoofing.scenario import load_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.messages import fix_sample, velocity_sample
from hijack_detect.streams.samples import SatelliteSample


def reported(spoofer: LiveSpoofer | Spoofer, first: int, last: int) -> list[tuple[Any, ...]]:
    """What a spoofer in this process says of the true messages of some indices."""
    rows = []
    for index in range(first, last):
        true = true_messages(index)
        stamp = stamp_ns(true["fix"])
        fix = spoofer.fix(fix_sample(true["fix"]))
        velocity = spoofer.velocity(velocity_sample(true["velocity"]))
        count = spoofer.satellites(SatelliteSample(stamp, true["satellites"].data)).count
        rows.append((fix, velocity, count, spoofer.active(stamp), spoofer.offset_m))
    return rows


def test_modes_change_while_it_runs(graph: Graph) -> None:
    link = Link(graph)
    twin = LiveSpoofer()
    link.send(3)
    assert {name: one.messages for name, one in link.heard.items()} == link.sent
    reported(twin, 0, 3)
    first = 3
    changes: list[dict[str, Any]] = [
        {"mode": "soft", "satellites_low": 30, "satellites_high": 40},
        {"bearing_deg": 90.0},  # which soft does not use: the attack goes on
        {"mode": "hard", "drift_speed_m_s": 20.0, "onset_acceleration_m_s2": 100.0},
        {"mode": "model", "model": "{type: turn_away, angle_deg: 90, rate_deg_s: 30}"},
        {"mode": "none"},
        {"mode": "model", "model": "type: freeze"},
    ]
    values: dict[str, Any] = {}
    for change in changes:
        assert link.change(**change) == ""
        values |= change
        if "mode" in change:
            twin.set(chosen_attack(SpooferParameters.from_mapping(values)))
        link.send(5)
        assert link.samples(first) == reported(twin, first, first + 5)
        first += 5
    flags = [one.data for one in link.truth.messages]
    assert flags == [False] * 3 + [True] * 20 + [False] * 5 + [True] * 5
    for ours, theirs in zip(link.heard["fix"].messages, link.sent["fix"], strict=True):
        assert (ours.header, ours.status) == (theirs.header, theirs.status)
    kinds = [one.position_covariance_type for one in link.heard["fix"].messages]
    assert kinds == [2] * 3 + [1] * 15 + [2] * 15
    assert all(one.twist.angular.z == 0.25 for one in link.heard["velocity"].messages)

    said = link.report()
    told = values_of(said)
    assert said.level == DiagnosticStatus.WARN and said.message == "GPS is being forged"
    assert (told["mode"], told["restarts"]) == ("model", "0")
    assert told["onset_ns"] == told["times count from_ns"] == str(START_NS + 28 * STEP_NS)
    assert (told["passed fix"], told["forged fix"]) == ("8", "25")
    assert (told["passed satellites"], told["forged satellites"]) == ("18", "15")
    assert link.node.interrupt() == 0
    lines = [line.split("]: ")[1] for line in link.node.output.splitlines() if "attack" in line]
    assert [line.split(" at ")[0] for line in lines] == [
        "mode soft: attack began", "mode hard: attack began", "mode model: attack began",
        "mode none: attack ended", "mode model: attack began",
    ]  # fmt: skip


def test_what_is_refused_leaves_the_running_attack_alone(graph: Graph, tmp_path: Any) -> None:
    link = Link(graph, mode="hard", seed=4)
    link.send(2)
    file = tmp_path / "bad.yaml"
    file.write_text("segments: [{start: 1, model: {type: jmup}}, {start: -1}]")
    refusals: list[tuple[dict[str, Any], str]] = [
        ({"mode": "loud"}, "parameter 'mode' must be one of none, soft, hard, model, scenario"),
        ({"mode": "model"}, "mode model needs an attack in the parameter 'model'"),
        ({"mode": "model", "model": "{type: replay, from_s: 1}"}, "parameter 'model': a replay"),
        ({"mode": "scenario", "scenario": "/no.yaml"}, "/no.yaml: cannot be read"),
        ({"scenario": str(file)}, f"{file}: segment 1: model.type: 'jmup' is unknown"),
        ({"seed": 5, "altitude_sigma_m": -1.0}, "altitude_sigma_m"),
        ({"satellites_low": 21}, "parameter 'satellites_low' is 21, above 'satellites_high' (20)"),
        ({"keep": 5}, "read-only"),
        ({"noise": 5.0}, "undeclared parameter"),
    ]
    for change, said in refusals:
        assert said in link.change(**change)
    reason = link.change(mode="scenario", scenario=str(file))
    assert len(reason.splitlines()) == 3  # every problem of the file
    link.send(3)
    hard = chosen_attack(SpooferParameters(mode="hard", seed=4))
    assert link.samples(0) == reported(LiveSpoofer(hard), 0, 5)
    assert link.node.interrupt() == 0


def test_a_scenario_given_at_the_start_counts_from_the_first_fix(
    graph: Graph, tmp_path: Any
) -> None:
    file = tmp_path / "replay.yaml"
    file.write_text(
        "segments:\n"
        "  - {start: 2, end: 4, model: {type: replay, from_s: 0.5}}\n"
        "  - {start: 5, model: {type: drift, speed_m_s: 9, bearing_deg: 0, "
        "onset_acceleration_m_s2: 5, relative: true}}\n"
    )
    link = Link(graph, mode="scenario", scenario=file)
    link.send(40)
    assert link.samples(0) == reported(Spoofer(load_scenario(file), START_NS), 0, 40)
    flags = [
        (key, len([*run])) for key, run in itertools.groupby(m.data for m in link.truth.messages)
    ]
    assert flags == [(False, 10), (True, 10), (False, 5), (True, 15)]
    assert link.node.interrupt() == 0


def test_a_fix_waits_for_nothing_and_bad_messages_pass(graph: Graph) -> None:
    link = Link(graph, mode="soft", satellites_low=30, satellites_high=40)
    link.put("satellites", UInt32(data=7))  # of no fix
    link.send(3, ("fix",))
    for _ in range(2):
        bad = true_messages(len(link.sent["fix"]))["fix"]
        bad.latitude = 91.0
        link.put("fix", bad)
    unknown = TwistStamped(header=bad.header)
    unknown.twist.linear.x = math.inf
    link.put("velocity", unknown)
    lost = true_messages(5)["fix"]
    lost.status.status = -1
    link.put("fix", lost)
    for count in (255, 9):
        link.put("satellites", UInt32(data=count))
    fixes = link.heard["fix"].messages
    assert fixes[3:] == link.sent["fix"][3:]
    assert all(ours != theirs for ours, theirs in zip(fixes[:3], link.sent["fix"], strict=False))
    assert link.heard["velocity"].messages == [unknown]
    numbers = [one.data for one in link.heard["satellites"].messages]
    assert numbers[:2] == [7, 255] and 30 <= numbers[2] <= 40
    assert [one.data for one in link.offset.messages][3:] == [0.0] * 3
    assert all(one.data for one in link.truth.messages)
    told = values_of(link.report())
    assert [told[f"refused {name}"] for name in TOPICS] == ["2", "1", "0"]
    assert link.node.output.count("passed on as it is: latitude is 91.0") == 1
    assert "/gps/fix_in: passed on as it is" in link.node.output
    assert link.node.interrupt() == 0


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"mode": "loud"}, "error: gps_spoofer: parameter 'mode' must be one of none, soft"),
        ({"mode": "scenario", "scenario": "/no.yaml"}, "error: /no.yaml: cannot be read"),
        ({"mood": "soft"}, "error: gps_spoofer: unknown parameter 'mood'"),
    ],
)
def test_bad_input_ends_with_two_and_a_line(
    graph: Graph, parameters: dict[str, Any], said: str
) -> None:
    node = graph.start("gps_spoofer", parameters=parameters)
    assert node.wait() == 2
    assert said in node.output and len(node.output.splitlines()) == 1
