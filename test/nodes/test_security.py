# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Asked-for security that is not there is said at start; the policies allow what nodes have."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from ros import ROOT, Graph

from hijack_detect.nodes import COMPOSED, MONITOR, NODES
from hijack_detect.nodes.running import EXIT_BAD_INPUT, unprotected
from tools import interface

POLICIES = ROOT / "config/sros2"
BESIDE = ("recorder", "gps_spoofer", "mavlink_bridge")
ASKED = {"ROS_SECURITY_ENABLE": "true"}
Right = tuple[str, str, str]
"""Topic or service, what may be done, and its full name."""


@pytest.fixture
def keystore(tmp_path: Path) -> Path:
    (tmp_path / "enclaves/uav1/fusion").mkdir(parents=True)
    return tmp_path


def test_nothing_is_said_where_nothing_was_asked_for_or_keys_are_there(keystore: Path) -> None:
    kept = {**ASKED, "ROS_SECURITY_KEYSTORE": str(keystore)}
    arguments = ["fusion", "--ros-args", "--enclave", "/uav1/fusion"]
    assert unprotected(["fusion"], {}) == ""
    assert unprotected(arguments, kept) == ""
    assert unprotected(["fusion", "--ros-args", "-e", "/uav1/fusion"], kept) == ""
    override = {**kept, "ROS_SECURITY_ENCLAVE_OVERRIDE": "/uav1/fusion"}
    assert unprotected(["fusion"], override) == ""


def test_an_enclave_without_keys_is_named(keystore: Path) -> None:
    kept = {**ASKED, "ROS_SECURITY_KEYSTORE": str(keystore)}
    said = unprotected(["fusion", "--ros-args", "--enclave", "/uav2"], kept)
    assert said.startswith("NOT PROTECTED")
    assert str(keystore / "enclaves/uav2") in said
    assert "NOT PROTECTED" in unprotected(["fusion"], ASKED)


@pytest.mark.parametrize("strategy", ["Permissive", "Enforce"])
def test_keys_that_the_wheels_cannot_use_end_a_node_with_the_reason(
    graph: Graph, keystore: Path, monkeypatch: pytest.MonkeyPatch, strategy: str
) -> None:
    monkeypatch.setenv("ROS_SECURITY_ENABLE", "true")
    monkeypatch.setenv("ROS_SECURITY_STRATEGY", strategy)
    monkeypatch.setenv("ROS_SECURITY_KEYSTORE", str(keystore))
    process = graph.start("fusion", "--enclave", "/uav1/fusion")
    assert process.wait() == EXIT_BAD_INPUT, process.output
    assert "built without DDS security" in process.output.splitlines()[-1]
    assert "Traceback" not in process.output


def test_a_permissive_node_without_keys_says_that_it_is_not_protected(
    graph: Graph, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_SECURITY_ENABLE", "true")
    process = graph.start("fusion")
    process.wait_for("NOT PROTECTED although ROS_SECURITY_ENABLE is true")
    assert process.interrupt() == 0


def allowed(name: str, space: str) -> Iterator[tuple[str, Right]]:
    """Every node of a policy with what it may do, in a namespace."""
    root = ET.parse(POLICIES / f"{name}.policy.xml").getroot()
    assert [one.get("path") for one in root.iter("enclave")] == [f"/hijack_detect/{name}"]
    for profile in root.iter("profile"):
        node = profile.get("node", "")
        for group in profile:
            assert set(group.attrib.values()) == {"ALLOW"}
            for what, one in itertools.product(group.attrib, group):
                word = one.text or ""
                assert "*" not in word
                full = word.replace("~", f"{space}/{node}") if word[0] == "~" else word
                yield node, (one.tag, what, full if full[0] == "/" else f"{space}/{full}")


def held(graph: Graph, node: str, space: str) -> set[Right]:
    """What a node of the running graph has."""
    observer, place = graph.node, (node, space or "/")
    found = {
        ("topic", "publish"): observer.get_publisher_names_and_types_by_node(*place),
        ("topic", "subscribe"): observer.get_subscriber_names_and_types_by_node(*place),
        ("service", "reply"): observer.get_service_names_and_types_by_node(*place),
        ("service", "request"): observer.get_client_names_and_types_by_node(*place),
    }
    return {(kind, what, name) for (kind, what), some in found.items() for name, _ in some}


def test_policies_and_reference_say_what_the_running_nodes_have_and_no_more(graph: Graph) -> None:
    """The monitor's nodes, each a process, and beside them all in one process."""
    space = "/composed"
    processes = [graph.start(name) for name in (*MONITOR, *BESIDE)]
    paused = {"bag": ROOT / "bags/curved_8", "start_paused": True}
    processes.append(graph.start("bag_replay", parameters=paused))
    processes.append(graph.run("examples.mission_manager", "--ros-args"))
    processes.append(graph.run("hijack_detect.cli.main", "live", "--port", "0"))
    processes.append(graph.start(COMPOSED, "-r", f"__ns:={space}"))
    alone = (*MONITOR, *BESIDE, "bag_replay", "mission_manager", "live")
    wanted: dict[tuple[str, str], set[Right]] = {}
    for name in alone:
        for node, right in allowed(name, ""):
            wanted.setdefault((node, ""), set()).add(right)
    for node, right in allowed(COMPOSED, space):
        wanted.setdefault((node, space), set()).add(right)
    assert len(wanted) == len(alone) + len(MONITOR) + 1

    def differences() -> list[str]:
        return [
            f"{space}/{node} {right}"
            for (node, space), rights in wanted.items()
            for right in rights ^ held(graph, node, space)
        ]

    def known() -> bool:
        names = graph.node.get_node_names_and_namespaces()
        return {(node, space or "/") for node, space in wanted} <= set(names)

    graph.spin_until(known, "all nodes", 60.0)
    graph.spin_until(lambda: not differences(), "the rights of the policies", 30.0)
    written = interface.tables((ROOT / "docs/interface.md").read_text(encoding="utf-8"))
    assert written.keys() == {*NODES}
    for name in (*MONITOR, *BESIDE, "bag_replay"):
        assert written[name] == {*interface.table(interface.look(graph.node, name))}, name
    assert all(process.returncode is None for process in processes)


def test_the_reference_has_every_parameter_with_its_default() -> None:
    """What `python -m tools.interface docs/interface.md` makes of the declarations."""
    written = (ROOT / "docs/interface.md").read_text(encoding="utf-8").splitlines()
    for name in NODES:
        kind = interface.parameters_of(name)
        assert kind is not None
        assert {*interface.parameter_rows(kind)} <= {*written}, name


def test_every_node_has_a_policy_and_mission_manager_and_live_page_too() -> None:
    names = {path.name.removesuffix(".policy.xml") for path in POLICIES.iterdir()}
    assert names == {*NODES, "mission_manager", "live"}
    rights = {right for _, right in allowed("mission_manager", "")}
    assert ("topic", "subscribe", "/hijack_alert") in rights
    assert ("service", "request", "/fusion/reset") in rights
    assert ("topic", "publish", "/hijack_alert") not in rights
