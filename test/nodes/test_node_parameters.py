# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of every node: refused at start, changed while it runs, described."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.parameter import Parameter
from ros import ROOT, Graph, RosProcess

from hijack_detect.monitor.graph import input_names
from hijack_detect.monitor.parts import PARTS
from hijack_detect.nodes import COMPOSED, NODES
from hijack_detect.nodes.engine import input_of
from hijack_detect.nodes.running import EXIT_BAD_INPUT
from hijack_detect.parameters import Parameters

FLOATS = {
    "attitude_estimator": ("gps_lag_s", 1.5, "[0.0, 1.0] s"),
    "gps_angle": ("min_speed", -1.0, "[0.0, 50.0] m/s"),
    "flight_phase": ("takeoff_height", 0.0, "[0.3, 50.0] m"),
    "correlation_detector": ("mu_deg", 200.0, "[0.1, 180.0] deg"),
    "date_detector": ("threshold", 0.0, "[0.05, 50.0] m/s²"),
    "coast_detector": ("longest_s", 37.0, "[3.0, 36.0] s"),
    "gnss_sanity": ("jump_alarm_m", 0.0, "[0.5, 10000.0] m"),
    "altitude_detector": ("wander_m", 0.0, "[0.1, 100.0] m"),
    "heading_detector": ("course_deg", 181.0, "[1.0, 180.0] deg"),
    "drag_detector": ("least_limit", 51.0, "[0.5, 50.0] m/s"),
    "fusion": ("stale_s", 601.0, "[0.1, 600.0] s"),
}
FIXED = ("attitude_estimator", "fusion")


def declared(node: str) -> Parameters:
    return next(part.parameters for part in PARTS if part.node == node)()


def refused(process: RosProcess) -> str:
    """The one line that a node ends with."""
    assert process.wait() == EXIT_BAD_INPUT, process.output
    lines = [line for line in process.output.splitlines() if line.startswith("error: ")]
    assert len(lines) == 1, process.output
    assert "Traceback" not in process.output
    return lines[0]


def change(graph: Graph, node: str, **values: Any) -> list[Any]:
    request = SetParameters.Request(
        parameters=[
            Parameter(name, value=value).to_parameter_msg() for name, value in values.items()
        ]
    )
    return list(graph.call(SetParameters, f"{node}/set_parameters", request).results)


def value_of(graph: Graph, node: str, name: str) -> Any:
    request = GetParameters.Request(names=[name])
    (value,) = graph.call(GetParameters, f"{node}/get_parameters", request).values
    return Parameter.from_parameter_msg(ParameterMessage(name=name, value=value)).value


def test_a_value_out_of_bounds_ends_every_node_with_code_2_and_the_bounds(graph: Graph) -> None:
    started = {
        node: graph.start(node, parameters={name: value})
        for node, (name, value, _) in FLOATS.items()
    }
    for node, process in started.items():
        name, value, bounds = FLOATS[node]
        line = refused(process)
        assert line == f"error: {node}: parameter '{name}' must be within {bounds}, got {value}"


def test_an_unknown_name_ends_every_node_with_code_2_and_the_known_names(graph: Graph) -> None:
    started = {node: graph.start(node, parameters={"treshold": 1.0}) for node in FLOATS}
    for node, process in started.items():
        line = refused(process)
        assert line.startswith(f"error: {node}: unknown parameter 'treshold' (known: ")
        assert FLOATS[node][0] in line


def test_a_wrong_type_ends_every_node_with_code_2(graph: Graph) -> None:
    started = {
        node: graph.start(node, parameters={name: "fast"}) for node, (name, *_) in FLOATS.items()
    }
    for node, process in started.items():
        name = FLOATS[node][0]
        assert refused(process) == f"error: {node}: parameter '{name}' must be float, got 'fast'"


@pytest.mark.parametrize("file", ["default.yaml", "paper.yaml"])
def test_the_parameter_files_are_accepted_and_every_parameter_is_described(
    graph: Graph, file: str
) -> None:
    arguments = [
        word
        for name in (file, "replay.yaml")
        for word in ("--params-file", str(ROOT / "config" / name))
    ]
    names = FLOATS if file == "default.yaml" else [COMPOSED]
    started = {node: graph.start(node, *arguments) for node in names}
    for node in FLOATS:
        fields = dataclasses.fields(declared(node))
        request = DescribeParameters.Request(names=[field.name for field in fields])
        answer = graph.call(DescribeParameters, f"{node}/describe_parameters", request)
        for field, described in zip(fields, answer.descriptors, strict=True):
            meta = field.metadata
            assert meta["doc"] in described.description
            assert described.description.endswith(f"[{meta['unit']}]" if meta["unit"] else ".")
            assert described.read_only == (node in FIXED)
            told = (*described.floating_point_range, *described.integer_range)
            ranges = [(one.from_value, one.to_value) for one in told]
            assert ranges == ([] if meta["low"] is None else [(meta["low"], meta["high"])])
            assert all(choice in described.additional_constraints for choice in meta["choices"])
    for process in started.values():
        assert process.interrupt() == 0
        assert "WARN" not in process.output


def test_the_policy_of_the_file_is_in_force(graph: Graph) -> None:
    graph.start("fusion", "--params-file", str(ROOT / "config/paper.yaml"))
    assert value_of(graph, "fusion", "policy") == "paper"


def test_a_detector_takes_a_change_while_it_runs(graph: Graph) -> None:
    node = graph.start("correlation_detector")
    (result,) = change(graph, "correlation_detector", mu_deg=15.0)
    assert result.successful, result.reason
    assert value_of(graph, "correlation_detector", "mu_deg") == 15.0
    graph.spin_until(lambda: "started afresh with {'mu_deg': 15.0}" in node.output, "a log line")

    (result,) = change(graph, "correlation_detector", mu_deg=200.0)
    assert not result.successful
    assert "mu_deg" in result.reason
    assert "180" in result.reason
    for wrong in ({"mu_deg": "wide"}, {"mu": 1.0}):
        (result,) = change(graph, "correlation_detector", **wrong)
        assert not result.successful
        assert result.reason

    both = [Parameter("window_s", value=3.0), Parameter("epsilon", value=2.0)]
    request = SetParametersAtomically.Request(parameters=[one.to_parameter_msg() for one in both])
    service = "correlation_detector/set_parameters_atomically"
    assert not graph.call(SetParametersAtomically, service, request).result.successful
    assert value_of(graph, "correlation_detector", "window_s") == 2.0
    assert value_of(graph, "correlation_detector", "mu_deg") == 15.0
    assert node.interrupt() == 0
    assert node.output.count("started afresh") == 1


@pytest.mark.parametrize(("node", "name", "value"), [
    ("attitude_estimator", "gps_lag_s", 0.2), ("fusion", "stale_s", 5.0)
])  # fmt: skip
def test_what_must_not_be_lost_in_flight_cannot_change(
    graph: Graph, node: str, name: str, value: float
) -> None:
    process = graph.start(node)
    before = value_of(graph, node, name)
    (result,) = change(graph, node, **{name: value})
    assert not result.successful
    assert "read-only" in result.reason
    assert value_of(graph, node, name) == before
    assert process.interrupt() == 0
    assert "started afresh" not in process.output


def test_help_says_what_each_node_does(graph: Graph) -> None:
    started = {node: graph.start(node, "--help") for node in NODES}
    for node, process in started.items():
        assert process.wait() == 0, process.output
        for word in TOPICS.get(node) or own_topics(node):
            assert word in process.output
        assert "--params-file" in process.output


def own_topics(node: str) -> list[str]:
    """Topics of the detectors whose nodes are made from their rows alone."""
    part = next(part for part in PARTS if part.node == node)
    inputs = [input_of(part, name).topic for name in input_names(part)]
    figures = ("verdict", "hijacked", "margin", *part.figures)
    return [*inputs, *(f"{part.name}/{figure}" for figure in figures)]


TOPICS = {
    "attitude_estimator": ("imu/data_raw", "gps/fix", "gps/vel", "mag", "imu/data", "yaw"),
    "gps_angle": ("gps/fix", "gps/course", "gps_angle"),
    "flight_phase": ("imu/data_raw", "pressure", "gps/vel", "gps/fix", "flight_phase"),
    "all": ("imu/data_raw", "gps/satellites", "hijack_alert", "publish_rate"),
    "correlation_detector": (
        "imu/data",
        "gps/course",
        "correlation/verdict",
        "correlation/hijacked",
        "correlation/margin",
        "correlation/coefficient",
        "correlation/mean_difference",
    ),
    "date_detector": (
        "imu/data",
        "gps/fix",
        "gps/vel",
        "date/verdict",
        "date/hijacked",
        "date/margin",
        "date/delta_ax",
        "date/delta_ay",
    ),
    "recorder": (
        "imu/data_raw",
        "gps/satellites",
        "DETECTOR/verdict",
        "fusion/verdict",
        "hijack_alert",
        "spoof_active",
        "~/snapshot",
        "/diagnostics",
        "journal.sqlite3",
    ),
    "kld_detector": (
        "gps/fix",
        "gps/vel",
        "gps/satellites",
        "kld/verdict",
        "kld/hijacked",
        "kld/margin",
        "kld/divergence",
        "kld/code",
        "~/reset",
    ),
    "coast_detector": (
        "imu/data_raw",
        "gps/fix",
        "gps/vel",
        "mag",
        "coast/verdict",
        "coast/hijacked",
        "coast/margin",
        "coast/score",
        "coast/acceleration",
        "coast/direction",
        "coast/smallest_visible",
    ),
    "gnss_sanity": (
        "gps/fix",
        "gps/vel",
        "gps/satellites",
        "gnss/verdict",
        "gnss/hijacked",
        "gnss/margin",
        "gnss/jump",
        "gnss/freeze",
        "gnss/velocity_mismatch",
        "gnss/velocity_mismatch_limit",
        "/diagnostics",
    ),
    "altitude_detector": (
        "imu/data",
        "pressure",
        "gps/vel",
        "gps/fix",
        "altitude/verdict",
        "altitude/hijacked",
        "altitude/margin",
        "altitude/difference",
    ),
    "heading_detector": (
        "imu/data_raw",
        "mag",
        "gps/fix",
        "gps/vel",
        "imu/data",
        "heading/verdict",
        "heading/hijacked",
        "heading/margin",
        "heading/difference",
    ),
    "drag_detector": (
        "imu/data",
        "gps/fix",
        "gps/vel",
        "drag/verdict",
        "drag/hijacked",
        "drag/margin",
        "drag/wind_change",
    ),
    "fusion": (
        "DETECTOR/verdict",
        "hijack_alert",
        "hijack_confidence",
        "fusion/verdict",
        "/diagnostics",
        "~/reset",
    ),
    "bag_replay": ("/clock", "spoof_active", "~/position", "~/pause", "scenario"),
    "gps_spoofer": ("gps/fix_in", "gps/vel_in", "gps/satellites_in", "~/offset", "mode", "soft"),
    "mavlink_bridge": (
        "imu/data_raw",
        "gps/fix",
        "gps/satellites",
        "mag",
        "pressure",
        "/diagnostics",
        "hijack_alert",
        "fusion/verdict",
        "STATUSTEXT",
        "user_1",
    ),
    "px4_bridge": ("sensor_combined", "vehicle_gps_position", "gps/satellites", "pressure", "_v1"),
}


@pytest.mark.parametrize("content", [None, "fusion: [", "fusion: 3"])
def test_a_broken_parameter_file_is_named(
    graph: Graph, tmp_path: Path, content: str | None
) -> None:
    path = tmp_path / "broken.yaml"
    if content is not None:
        path.write_text(content)
    process = graph.start("fusion", "--params-file", str(path))
    assert str(path) in refused(process)
