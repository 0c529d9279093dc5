# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The layouts for Foxglove and PlotJuggler: their structure, and what they show is in the graph."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Callable, Iterator
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from live import values_of
from ros import ROOT, Graph

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.parts import DETECTORS
from hijack_detect.nodes.messages import fusion_message, message_class, verdict_message
from tools import layouts

FOXGLOVE: dict[str, Any] = json.loads((ROOT / "config/foxglove_layout.json").read_text())
PLOTJUGGLER = ET.parse(ROOT / "config/plotjuggler_layout.xml").getroot()
PANELS: dict[str, dict[str, Any]] = FOXGLOVE["configById"]
NEEDED = {
    "Plot": {"paths", "xAxisVal", "isSynced", "showLegend"},
    "map": {"layer", "followTopic", "disabledTopics", "topicColors"},
    "Indicator": {"path", "style", "rules", "fallbackColor", "fallbackLabel"},
    "RawMessages": {"topicPath"},
    "StateTransitions": {"paths"},
    "DiagnosticSummary": {"topicToRender"},
    "Tab": {"tabs", "activeTabIdx"},
}
"""Panel types of Foxglove, as its layouts name them, and what their configurations must have."""
PATH = re.compile(r"(?P<topic>/[\w/]+)(?P<fields>\..+)")
KEY = re.compile(r'\.status\[0\]\.values\[:\]\{key=="(?P<key>\w+)"\}\.value')


def of(kind: str) -> list[dict[str, Any]]:
    """The configurations of all panels of a type."""
    return [config for name, config in PANELS.items() if name.startswith(f"{kind}!")]


def leaves(node: Any) -> Iterator[str]:
    """The panels of an arrangement, with those in tabs."""
    if isinstance(node, str):
        yield node
        for tab in PANELS[node].get("tabs", []):
            yield from leaves(tab["layout"])
        return
    assert node["direction"] in ("row", "column")
    assert 0 < node["splitPercentage"] < 100
    yield from leaves(node["first"])
    yield from leaves(node["second"])


def foxglove_paths() -> list[str]:
    """Every path to a value in the layout; a number is a line at that height."""
    plotted = [one["value"] for kind in ("Plot", "StateTransitions") for panel in of(kind)
               for one in panel["paths"]]  # fmt: skip
    return [*(one for one in plotted if one != "1"), *(one["path"] for one in of("Indicator"))]


def plotjuggler_curves() -> list[str]:
    return [curve.attrib["name"] for curve in PLOTJUGGLER.iter("curve")]


def message(topic: str) -> Any:
    """A message as it is published on a topic of verdicts."""
    verdict = Verdict("coast", 1, State.NORMAL, 0.5, 1.0, "calm")
    if topic == "/fusion/verdict":
        return fusion_message(
            FusionResult(1, State.NORMAL, False, None, 0.5, "", {"coast": verdict}, ())
        )
    return verdict_message(verdict)


def test_foxglove_has_every_panel_once_with_what_its_type_needs() -> None:
    assert set(FOXGLOVE) == {
        "configById",
        "globalVariables",
        "userNodes",
        "playbackConfig",
        "layout",
    }
    assert sorted(leaves(FOXGLOVE["layout"])) == sorted(PANELS)
    for name, config in PANELS.items():
        kind, _, own = name.partition("!")
        assert own
        assert NEEDED[kind] <= set(config), name
    for panel in of("Plot"):
        for path in panel["paths"]:
            assert path["enabled"]
            assert path["timestampMethod"] in ("receiveTime", "headerStamp")
    for panel in of("Indicator"):
        for rule in panel["rules"]:
            assert rule["operator"] == "="
            assert {"rawValue", "color", "label"} <= set(rule)


def test_margins_have_a_limit_and_all_detectors_live_and_in_a_bag() -> None:
    for name in ("Plot!margins", "Plot!recorded"):
        limit, *rest = PANELS[name]["paths"]
        assert limit["value"] == "1"
        assert [one["label"] for one in rest] == list(DETECTORS)
    curves = plotjuggler_curves()
    assert [f"/{name}/margin/data" in curves for name in DETECTORS] == [True] * len(DETECTORS)
    assert {f"/{name}/verdict/{name}/margin" for name in DETECTORS} <= set(curves)
    told = {rule["rawValue"] for rule in PANELS["Indicator!state"]["rules"]}
    assert told == {state.value for state in State}


@pytest.mark.parametrize(
    ("name", "made"),
    [(layouts.FOXGLOVE, layouts.foxglove), (layouts.PLOTJUGGLER, layouts.plotjuggler)],
)
def test_the_detectors_in_it_are_those_of_the_registry(
    name: str, made: Callable[[str], str]
) -> None:
    text = (ROOT / "config" / name).read_text(encoding="utf-8")
    assert made(text) == text
    assert made(text.replace("correlation", "another")) == text


def test_every_key_of_a_verdict_that_a_layout_names_is_in_it() -> None:
    keyed = 0
    for path in foxglove_paths():
        found = PATH.fullmatch(path)
        assert found, path
        key = KEY.fullmatch(found["fields"])
        if key:
            keyed += 1
            assert key["key"] in values_of(message(found["topic"])), path
    assert keyed > len(DETECTORS)
    for curve in plotjuggler_curves():
        detector, kind, *rest = curve.strip("/").split("/")
        if kind == "verdict":
            told = message(f"/{detector}/verdict")
            assert rest[0] == detector
            assert rest[1] in values_of(told), curve
            assert told.status[0].hardware_id == ""  # which would be a part of the name


def test_every_topic_of_the_layouts_is_in_a_running_graph(graph: Graph) -> None:
    process = graph.start("all")
    wanted = {found["topic"]: found["fields"] for found in map(PATH.fullmatch, foxglove_paths())}
    wanted |= {f"/{'/'.join(one.split('/')[1:-1])}": ".data" for one in plotjuggler_curves()
               if one.endswith("/data")}  # fmt: skip
    for panel in (*of("RawMessages"), *of("DiagnosticSummary")):
        wanted[panel.get("topicPath") or panel["topicToRender"]] = ".status"
    streamed = PLOTJUGGLER.find("Plugins/plugin/selected_topics")
    assert streamed is not None
    assert set(streamed.attrib["value"].split(";")) <= set(wanted)
    assert len(wanted) == 2 * len(DETECTORS) + 4
    graph.spin_until(lambda: all(map(graph.node.count_publishers, wanted)), "the topics")
    (track,) = of("map")
    graph.spin_until(lambda: graph.node.count_subscribers(track["followTopic"]), "gps/fix")
    kinds = dict(graph.node.get_topic_names_and_types())
    assert kinds[track["followTopic"]] == ["sensor_msgs/msg/NavSatFix"]
    for topic, fields in wanted.items():
        first = re.split(r"\W", fields.removeprefix("."))[0]
        assert first in message_class(kinds[topic][0]).get_fields_and_field_types(), topic
        if topic.endswith("/margin"):
            assert kinds[topic] == ["std_msgs/msg/Float64"]
    assert process.interrupt() == 0


@pytest.mark.parametrize("name", ["foxglove_layout.json", "plotjuggler_layout.xml"])
def test_the_command_of_the_docs_puts_a_namespace_in(name: str) -> None:
    found = re.search(r"sed -e '(.+)'", (ROOT / "docs/viewers.md").read_text())
    assert found is not None
    command = ["sed", "-e", found[1], str(ROOT / "config" / name)]
    moved = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    before = (ROOT / "config" / name).read_text()
    topic = re.compile(r'(?<=["; ])/(?=\w)[\w/]+')
    wanted = topic.sub(lambda one: one[0] if one[0] == "/diagnostics" else f"/uav1{one[0]}", before)
    assert moved == wanted
    assert moved.count("/uav1/") > 2 * len(DETECTORS)
