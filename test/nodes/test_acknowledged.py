# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Acknowledged delivery behind gps_spoofer: subscribers that come late, and one that is killed."""

from __future__ import annotations

import signal
from collections.abc import Collection
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import QuaternionStamped
from live import stamp_ns
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from ros import KEEP_ALL, ROOT, Graph
from sensor_msgs.msg import NavSatFix
from spoofer_link import START_NS, STEP_NS, Link

from hijack_detect.nodes.messages import phase_message
from hijack_detect.nodes.qos import SENSOR, remembered
from hijack_detect.streams.samples import Phase, PhaseSample


def test_late_and_best_effort_subscribers(graph: Graph) -> None:
    link = Link(graph, mode="hard", keep=4)
    quick = graph.listen(NavSatFix, "gps/fix", SENSOR)
    graph.until_known("gps_spoofer")
    link.send(6)
    late = graph.listen(NavSatFix, "gps/fix", remembered(100))
    graph.spin_until(lambda: len(late.messages) >= 4, "what is kept")
    link.send(1)
    graph.spin_until(lambda: len(late.messages) >= 5, "what comes")
    fixes = link.heard["fix"].messages
    assert late.messages == fixes[2:]
    graph.spin_until(lambda: quick.messages[-1:] == fixes[-1:], "the last one, best effort")
    assert link.node.interrupt() == 0


@pytest.mark.parametrize(
    ("node", "kind", "topic", "behind"),
    [
        ("gps_angle", QuaternionStamped, "gps/course", 0),
        # What it says of a fix waits for the number of satellites, and that for the next fix.
        ("kld_detector", DiagnosticArray, "kld/verdict", 1),
    ],
)
def test_an_analyser_that_is_killed_misses_nothing(
    graph: Graph, node: str, kind: type, topic: str, behind: int
) -> None:
    """It is killed in an attack, and started again; one beside it runs through."""
    acknowledged = ("--params-file", str(ROOT / "config/acknowledged.yaml"))
    beside = ("-r", "__node:=steady", "-r", f"{topic}:=steady")
    steady, outputs = graph.listen(kind, "steady"), graph.listen(kind, topic)
    link = Link(graph)
    phases = graph.node.create_publisher(DiagnosticArray, "flight_phase", KEEP_ALL)

    def fly(*analysers: str, dead: Collection[bytes] = frozenset()) -> None:
        """Say that no phase comes before the fixes are over: nothing has to wait for one."""
        graph.until_known(*analysers)
        if node == "kld_detector":
            graph.until_subscribed(phases, len(analysers), dead)
            over_ns = START_NS + 1000 * STEP_NS
            phases.publish(phase_message(PhaseSample(over_ns, Phase.FLYING, over_ns, "flies")))

    link.node.signal(signal.SIGSTOP)  # so that no output is lost before this node is known
    # The parameters of the file are those of the node's own name.
    patience = ("-p", "patience_s:=3600.0") if node == "kld_detector" else ()
    graph.start(node, *acknowledged, *patience, *beside)
    analyser = graph.start(node, *acknowledged)
    fly("steady", node)
    link.node.signal(signal.SIGCONT)
    link.send(20)
    assert link.change(mode="hard") == ""
    link.send(20)
    first = 40 - behind
    graph.spin_until(lambda: len(outputs.messages) >= first, "outputs of the first")
    dead = graph.subscribers("flight_phase")
    analyser.signal(signal.SIGKILL)
    assert analyser.wait() == -signal.SIGKILL
    link.send(20)
    unacknowledged = "gps/fix" if node == "gps_angle" else "gps/fix gps/vel gps/satellites"
    link.report(unacknowledged=unacknowledged)
    link.node.signal(signal.SIGSTOP)
    again = graph.start(node, *acknowledged)
    fly(node, dead=dead)
    link.node.signal(signal.SIGCONT)
    link.send(20)
    everything = 80 - behind
    graph.spin_until(
        lambda: len(steady.messages) >= everything and len(outputs.messages) >= first + everything,
        "every output again",
    )
    graph.spin_until_quiet()
    assert [stamp_ns(one) for one in steady.messages] == [
        START_NS + index * STEP_NS for index in range(everything)
    ]
    assert outputs.messages[:first] == steady.messages[:first]
    assert outputs.messages[first:] == steady.messages
    assert again.interrupt() == 0


def test_acknowledged_delivery_reaches_every_analyser(graph: Graph) -> None:
    analysers = {"attitude_estimator", "date_detector", "gps_angle", "kld_detector"}
    file = str(ROOT / "config/acknowledged.yaml")
    for node in analysers:
        graph.start(node, "--params-file", file)

    def hears() -> dict[str, Any]:
        found = graph.node.get_subscriptions_info_by_topic("/gps/fix")
        return {one.node_name: one.qos_profile for one in found}

    graph.spin_until(lambda: analysers <= hears().keys(), "every analyser")
    for profile in hears().values():
        assert profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        assert profile.reliability == ReliabilityPolicy.RELIABLE
