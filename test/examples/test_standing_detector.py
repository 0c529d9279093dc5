# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The example of a detector in one file: by hand, in an analysis, and as a node beside a fusion."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from command import hijack_detect
from diagnostic_msgs.msg import DiagnosticArray
from live import SECOND, replay, stamp_ns, values_of
from ros import ROOT, Graph
from small_bags import START_NS, STEP_NS, raw, write
from standing_detector import StandingDetector, StandingParameters
from std_msgs.msg import Bool, Float64

from hijack_detect.bags.reader import RawMessage
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.stage import Stage
from hijack_detect.nodes.qos import STATE
from hijack_detect.streams.samples import FixSample, ImuSample

FILE = ROOT / "examples/standing_detector.py"
DEGREE_M = 111_200.0
"""Of latitude."""
STANDS_S, END_S = 20.0, 60.0
"""Then the GPS goes North at 1 m/s."""
ALARM_S = STANDS_S + 15.0 + 1.0
"""Distance over speed, and it has to last."""


def stream(shake: float = 0.0) -> Iterator[tuple[str, Any]]:
    """Imu at 50 Hz and fixes at 5 Hz of a vehicle on the ground; `shake` in m/s² at 5 Hz."""
    for index in range(round(END_S * 50)):
        at = START_NS + index * STEP_NS
        force = 9.8 + (shake if index % 10 < 5 else 0.0)
        yield "imu", ImuSample(at, (0.0, 0.0, 0.0), (0.0, 0.0, force))
        if index % 10 == 0:
            north_m = max(0.0, index / 50 - STANDS_S)
            yield "fix", FixSample(at, 48.0 + north_m / DEGREE_M, 11.0, 500.0)


def said(samples: Iterator[tuple[str, Any]]) -> list[Verdict]:
    stage = Stage(lambda: StandingDetector(StandingParameters()))
    return [verdict for name, sample in samples for verdict in stage.push(name, sample)]


def test_it_alarms_a_second_after_the_gps_has_moved_as_far_as_the_limit() -> None:
    verdicts = said(stream())
    first = next(one for one in verdicts if one.state is State.ALARM)
    assert (first.stamp_ns - START_NS) / SECOND == pytest.approx(ALARM_S, abs=0.21)
    assert first.margin == pytest.approx(16.0 / 15.0, abs=0.02)
    before = {one.state for one in verdicts if one.stamp_ns < START_NS + 30 * SECOND}
    assert before == {State.NOT_OBSERVABLE, State.NORMAL}


def test_a_vehicle_that_shakes_is_not_judged() -> None:
    states = {one.state for one in said(stream(shake=0.5))[1:]}
    assert states == {State.NOT_OBSERVABLE}


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """The flight that never leaves the ground."""
    topics = {"imu": "/imu/data_raw", "fix": "/gps/fix"}

    def messages() -> Iterator[RawMessage]:
        for name, sample in stream():
            yield raw(topics[name], sample)

    return write(tmp_path / "standing", messages())


def test_an_analysis_runs_it_and_the_fusion_hears_it(bag: Path, tmp_path: Path) -> None:
    given = ["analyze", bag, "--detector", f"{FILE}:StandingDetector", "--json", "-"]
    (alarm,) = json.loads(hijack_detect(*given).stdout)["detectors"]["standing"]["alarms"]
    assert alarm["start_s"] == pytest.approx(ALARM_S, abs=0.21)

    path = tmp_path / "any.yaml"
    path.write_text("/**/fusion:\n  ros__parameters: {policy: any}\n")
    done = hijack_detect(*given, "--params", path)
    assert done.returncode == 10, done.stderr
    assert [one["detectors"] for one in json.loads(done.stdout)["alerts"]] == [["standing"]]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("StandingDetector", "give FILE.py:CLASS"),
        ("nowhere.py:StandingDetector", "nowhere.py: is no Python file"),
        (f"{FILE}:Nobody", "has no class Nobody"),
        (f"{FILE}:StandingParameters", "is no detector: "),
        (f"{ROOT / 'README.md'}:Any", "README.md: is no Python file"),
    ],
)
def test_what_is_no_detector_is_refused(given: str, told: str) -> None:
    done = hijack_detect("analyze", ROOT / "bags/straight_3", "--detector", given)
    assert done.returncode == 2
    assert told in done.stderr
    assert "Traceback" not in done.stderr


def test_its_node_says_the_same_and_a_fusion_alerts(graph: Graph, bag: Path) -> None:
    heard = graph.listen(DiagnosticArray, "standing/verdict")
    distance = graph.listen(Float64, "standing/distance")
    alert = graph.listen(Bool, "hijack_alert", STATE)
    lossless = [
        word
        for topic in ("/imu/data_raw", "/gps/fix")
        for policy in ("reliability:=reliable", "history:=keep_all")
        for word in ("-p", f"qos_overrides.{topic}.subscription.{policy}")
    ]
    node = graph.run("examples.standing_detector", "--ros-args", *lossless)
    given = {"policy": "any", "further_detectors": "standing", "patience_s": 1.0}
    fusion = graph.start("fusion", parameters=given)
    replay(graph, bag, 60.0, ("standing_detector", "fusion"), rate=20.0)

    wanted = [(one.stamp_ns, one.state.value, str(one.score)) for one in said(stream())]
    graph.spin_until(lambda: len(heard.messages) > len(wanted) - 3, "the last verdicts")
    graph.spin_until(lambda: len(distance.messages) >= len(heard.messages), "their figures")
    told = [
        (stamp_ns(one), values_of(one)["state"], values_of(one)["score"]) for one in heard.messages
    ]
    assert told == wanted[: len(told)]
    assert len(distance.messages) == len(told)
    graph.spin_until(lambda: alert.messages and alert.messages[-1].data, "the alert")
    assert "[standing, " in fusion.output
    assert [one.interrupt() for one in (node, fusion)] == [0, 0]
