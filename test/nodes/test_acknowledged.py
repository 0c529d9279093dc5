"""Acknowledged delivery behind gps_spoofer: subscribers that come late, and one that is killed."""

from __future__ import annotations

import signal
from typing import Any

from geometry_msgs.msg import QuaternionStamped
from live import stamp_ns
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from ros import ROOT, Graph
from sensor_msgs.msg import NavSatFix
from spoofer_link import START_NS, STEP_NS, Link

from hijack_detect.nodes.qos import SENSOR, remembered


def test_late_and_best_effort_subscribers(graph: Graph) -> None:
    link = Link(graph, mode="hard", keep=4)
    quick = graph.listen(NavSatFix, "gps/fix", SENSOR)
    graph.spin_until(
        lambda: len(graph.node.get_subscriptions_info_by_topic("/gps/fix")) == 2, "both"
    )
    link.send(6)
    late = graph.listen(NavSatFix, "gps/fix", remembered(100))
    graph.spin_until(lambda: len(late.messages) >= 4, "what is kept")
    link.send(1)
    graph.spin_until(lambda: len(late.messages) >= 5, "what comes")
    fixes = link.heard["fix"].messages
    assert late.messages == fixes[2:]
    graph.spin_until(lambda: quick.messages[-1:] == fixes[-1:], "the last one, best effort")
    assert link.node.interrupt() == 0


def test_an_analyser_that_is_killed_misses_nothing(graph: Graph) -> None:
    """gps_angle is killed, and started again; one beside it runs through."""
    acknowledged = ("--params-file", str(ROOT / "config/acknowledged.yaml"))
    steady = graph.listen(QuaternionStamped, "steady")
    courses = graph.listen(QuaternionStamped, "gps/course")
    link = Link(graph)

    def until_known(*analysers: str) -> None:
        """Wait until new reports come: who sends them knows this node's older subscriptions."""
        seen = len(link.diagnostics.messages)
        wanted = {f"/{analyser}: inputs" for analyser in analysers}
        graph.spin_until(
            lambda: (
                wanted
                <= {one.name for each in link.diagnostics.messages[seen:] for one in each.status}
            ),
            "reports of the analysers",
        )

    link.node.signal(signal.SIGSTOP)  # so that no course is lost before this node is known
    graph.start("gps_angle", *acknowledged, "-r", "__node:=steady", "-r", "gps/course:=steady")
    analyser = graph.start("gps_angle", *acknowledged)
    until_known("steady", "gps_angle")
    link.node.signal(signal.SIGCONT)
    link.send(20)
    assert link.change(mode="hard") == ""
    link.send(20)
    graph.spin_until(lambda: len(courses.messages) >= 40, "courses of the first")
    analyser.signal(signal.SIGKILL)
    assert analyser.wait() == -signal.SIGKILL
    link.send(20)
    link.report(unacknowledged="gps/fix")
    link.node.signal(signal.SIGSTOP)
    again = graph.start("gps_angle", *acknowledged)
    until_known("gps_angle")
    link.node.signal(signal.SIGCONT)
    link.send(20)
    graph.spin_until(
        lambda: len(steady.messages) >= 80 and len(courses.messages) >= 120, "every course again"
    )
    graph.spin_until_quiet()
    assert [stamp_ns(one) for one in steady.messages] == [
        START_NS + index * STEP_NS for index in range(80)
    ]
    assert courses.messages[:40] == steady.messages[:40]
    assert courses.messages[40:] == steady.messages
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
