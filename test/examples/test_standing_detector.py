# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The example of a detector in one file: by hand, in an analysis, and as a node beside a fusion."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from command import hijack_detect
from diagnostic_msgs.msg import DiagnosticArray
from live import SECOND, replay, stamp_ns, values_of
from ros import ROOT, Graph
from small_bags import START_NS, STEP_NS, raw, write
from standing_detector import StandingDetector, StandingParameters
from std_msgs.msg import Bool, Float64

from hijack_detect import evaluate_folder
from hijack_detect.bags.reader import RawMessage
from hijack_detect.cli.main import main
from hijack_detect.cli.parameter_files import load_parameters, parameter_file
from hijack_detect.detectors.likelihood import UNCALIBRATED, LikelihoodRatio, Weight
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.graph import Stage
from hijack_detect.monitor.parts import own_part
from hijack_detect.monitor.policies import from_nodes, policy_parameters
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


WITHOUT_ROS = """
import sys
sys.modules.update(dict.fromkeys(("rclpy", "sensor_msgs", "diagnostic_msgs", "std_msgs")))
from hijack_detect.cli.main import main
main()
"""
"""The command line tool where there is no ROS: each import of it fails."""


def vehicle(folder: Path, **changes: str) -> Path:
    """The parameter file of a vehicle that has the detector, with some lines changed."""
    done = hijack_detect("params", "--detector", f"{FILE}:StandingDetector")
    assert done.returncode == 0, done.stderr
    text = done.stdout
    for name, value in changes.items():
        text, count = re.subn(
            rf"^    {name}: .*$", f"    {name}: {value}", text, flags=re.MULTILINE
        )
        assert count == 1, name
    path = folder / "vehicle.yaml"
    path.write_text(text)
    return path


def test_the_file_of_a_vehicle_has_its_parameters_and_its_weight(bag: Path, tmp_path: Path) -> None:
    """The path of our own detectors, without ROS: section, weight, alert, and report."""
    weight = '"standing=10.0,0.6,-0.1,5.0"'
    params = vehicle(tmp_path, moved_m="25.0", further_weights=weight)
    detector = ["--detector", f"{FILE}:StandingDetector", "--params", str(params)]
    command = [sys.executable, "-c", WITHOUT_ROS, "analyze", str(bag), *detector, "--json", "-"]
    report = ["--report", str(tmp_path / "page")]
    done = subprocess.run([*command, *report], capture_output=True, text=True, check=False)
    assert done.returncode == 10, done.stderr
    found = json.loads(done.stdout)
    (alarm,) = found["detectors"]["standing"]["alarms"]
    assert alarm["start_s"] == pytest.approx(ALARM_S + 10.0, abs=0.21)
    assert [one["detectors"] for one in found["alerts"]] == [["standing"]]
    page = (tmp_path / "page/index.html").read_text(encoding="utf-8")
    assert '<section id="standing"' in page
    assert "Does the GPS move while the vehicle stands?" in page


def test_a_weight_of_the_class_holds_unless_the_vehicle_has_another(tmp_path: Path) -> None:
    class Weighed(StandingDetector):
        WEIGHT = Weight(LikelihoodRatio(10.0, 0.6, -0.1, 5.0), sees_carry_off=True)

    part = own_part(Weighed)
    assert policy_parameters("default", [part]).fusion.further == {"standing": Weighed.WEIGHT}
    flown = {"fusion": {"further_detectors": "standing"}}
    assert from_nodes(flown, own=[part]).fusion.further == {"standing": UNCALIBRATED}
    path = tmp_path / "weighed.yaml"
    path.write_text(parameter_file("default", [part]))
    assert load_parameters(path, [part]).fusion.further == {"standing": Weighed.WEIGHT}


@pytest.mark.parametrize(
    ("section", "told"),
    [
        (
            "standing_detector: {moved: 9.0}",
            "standing_detector: unknown parameter 'moved' (known: ",
        ),
        ("standing_detector: {moved_m: 0.5}", "must be within [1.0, 1000.0] m, got 0.5"),
        ("sitting_detector: {moved_m: 9.0}", "no node 'sitting_detector' (there are: "),
        ("fusion: {further_weights: standing=1}", "further_weights"),
    ],
)
def test_what_the_file_of_a_vehicle_has_wrong_is_refused(
    section: str, told: str, tmp_path: Path
) -> None:
    path, (node, values) = tmp_path / "wrong.yaml", section.split(": ", 1)
    path.write_text(f"/**/{node}:\n  ros__parameters: {values}\n")
    given = ["--detector", f"{FILE}:StandingDetector", "--params", str(path)]
    done = CliRunner().invoke(main, ["analyze", str(ROOT / "bags/straight_3"), *given])
    assert done.exit_code == 2
    assert told in done.output
    assert str(path) in done.output


@pytest.mark.parametrize(
    ("attribute", "value", "told"),
    [
        ("NAME", "coast", "'coast', which is a name of our own"),
        ("NAME", 7, "is no detector: NAME is no text"),
        ("PARAMETERS", dict, "is no detector: PARAMETERS is no subclass of Parameters"),
        ("WEIGHT", 2.0, "is no detector: WEIGHT is no Weight"),
        ("FIGURES", "distance", "is no detector: FIGURES is no mapping"),
    ],
)
def test_an_attribute_that_cannot_be_is_refused(
    attribute: str, value: Any, told: str, tmp_path: Path
) -> None:
    path = tmp_path / "wrong.py"
    text = value.__name__ if isinstance(value, type) else repr(value)
    path.write_text(f"{FILE.read_text()}\n\nStandingDetector.{attribute} = {text}\n")
    done = CliRunner().invoke(main, ["params", "--detector", f"{path}:StandingDetector"])
    assert done.exit_code == 2
    assert told in done.output


def test_an_evaluation_has_it_among_its_methods(bag: Path) -> None:
    done = evaluate_folder(bag.parent, policy_parameters(own=[StandingDetector]))
    assert (done.methods["standing"].type_1.count, done.methods["coast"].type_1.count) == (1, 0)


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


def test_an_input_that_there_is_not_is_refused_by_the_node(tmp_path: Path) -> None:
    path = tmp_path / "wrong.py"
    path.write_text(FILE.read_text().replace('{"imu": 3.0', '{"sonar": 3.0'))
    done = subprocess.run([sys.executable, path], capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stderr
    assert "error: standing: there is no input 'sonar' (there are: imu, fix, " in done.stderr
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
