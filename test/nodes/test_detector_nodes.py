# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a detector's node says beside its verdict: a Bool for managers, Float64 for plots."""

from __future__ import annotations

import dataclasses
import math

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from feed import GPS_NS, SATELLITES, VELOCITY, Fed, fix, satellites, velocity
from live import SECOND, values_of
from rclpy.qos import qos_profile_sensor_data
from ros import Graph
from sensor_msgs.msg import NavSatFix
from std_msgs.msg import Bool, Float64, UInt8
from std_srvs.srv import Trigger

FIGURES = {
    "correlation": ("coefficient", "mean_difference"),
    "date": ("delta_ax", "delta_ay"),
    "kld": ("divergence",),
    "coast": ("score", "threshold", "acceleration", "direction", "smallest_visible"),
    "gnss": ("jump", "freeze", "velocity_mismatch", "velocity_mismatch_limit"),
    "altitude": ("difference",),
    "heading": ("difference",),
    "drag": ("wind_change",),
}
LEAST = {"coast": 10, "drag": 10}
"""Verdicts of 6 s where there is not one for each fix."""
NODE_NAMES = {"gnss": "gnss_sanity"}
"""Nodes that are not called DETECTOR_detector."""


@pytest.mark.parametrize("detector", FIGURES)
def test_every_verdict_has_its_flag_and_figures(graph: Graph, detector: str) -> None:
    fed = Fed(graph, NODE_NAMES.get(detector, f"{detector}_detector"))
    hijacked = fed.listen(Bool, f"{detector}/hijacked")
    figures = {
        name: fed.listen(Float64, f"{detector}/{name}") for name in ("margin", *FIGURES[detector])
    }
    fed.good(30)
    graph.spin_until(lambda: len(fed.output.messages) >= LEAST.get(detector, 28), "verdicts")
    verdicts = fed.output.messages
    for listener in (hijacked, *figures.values()):
        graph.spin_until(lambda heard=listener: len(heard.messages) == len(verdicts), "figures")
    assert not any(one.data for one in hijacked.messages)
    for name, listener in figures.items():
        told = [float(values_of(one).get(name, math.nan)) for one in verdicts]
        heard = [one.data for one in listener.messages]
        assert [repr(one) for one in heard] == [repr(one) for one in told]
        assert math.isnan(heard[0]) or name in ("margin", "score", "threshold")
    assert values_of(verdicts[0])["state"] in ("not_ready", "not_observable")
    assert fed.process.interrupt() == 0


def test_hijacked_is_true_while_date_alarms(graph: Graph) -> None:
    fed = Fed(graph, "date_detector")
    hijacked = fed.listen(Bool, "date/hijacked")
    fed.good(120)  # the limit is learnt for 20 s
    fed.inputs = [one for one in fed.inputs if one is not VELOCITY]
    began_ns = fed.stamp_ns
    for _ in range(15):  # the reported velocity gains 4 m/s each second, the vehicle does not
        stamp_ns = fed.stamp_ns + GPS_NS
        fed.send(VELOCITY, velocity(stamp_ns, 5.0 + 4.0 * (stamp_ns - began_ns) / SECOND))
        fed.good(1)
    graph.spin_until(lambda: any(one.data for one in hijacked.messages), "date/hijacked")
    alarms = [one for one in fed.output.messages if values_of(one)["state"] == "alarm"]
    assert alarms[0].status[0].level == DiagnosticStatus.ERROR
    assert fed.process.interrupt() == 0
    lines = [line for line in fed.process.output.splitlines() if "[date_detector]" in line]
    states = [line.split("]: ")[1].split()[0] for line in lines if " margin " in line]
    assert states == ["not_ready", "normal", "suspicious", "alarm"]


def test_kld_says_111_from_the_alarm_on_until_it_is_reset(graph: Graph) -> None:
    fed = Fed(graph, "kld_detector")
    codes = fed.listen(UInt8, "kld/code")
    fed.good(25)
    graph.spin_until(lambda: codes.messages, "codes")
    assert {one.data for one in codes.messages} == {110}

    fed.inputs = [one for one in fed.inputs if one is not SATELLITES]
    for step in range(20):  # the number of satellites changes as no sky does
        fed.good(1)
        fed.send(SATELLITES, satellites(0, 9 + 10 * (step % 2)))
        fed.until_received()
    graph.spin_until(lambda: codes.messages[-1].data == 111, "code 111")
    alarms = [one for one in fed.output.messages if values_of(one)["state"] == "alarm"]
    assert "satellites" in alarms[0].status[0].message
    values = values_of(alarms[0])
    total = float(values["satellites.forward"]) + float(values["satellites.backward"])
    assert total > 6.0

    fed.inputs.append(SATELLITES)
    fed.good(45)
    graph.spin_until(lambda: "kept for" in fed.output.messages[-1].status[0].message, "the latch")
    assert codes.messages[-1].data == 111
    assert graph.call(Trigger, "kld_detector/reset").success
    fed.good(3)
    graph.spin_until(lambda: codes.messages[-1].data == 110, "code 110")
    assert fed.process.interrupt() == 0


def test_a_second_publisher_of_fixes_is_told_within_seconds(graph: Graph) -> None:
    fed = Fed(graph, "gnss_sanity")
    report = graph.listen(DiagnosticArray, "/diagnostics")

    def told() -> DiagnosticStatus | None:
        found = [s for each in report.messages for s in each.status if "publishers" in s.name]
        return found[-1] if found else None

    def at(level: bytes) -> bool:
        last = told()
        return last is not None and last.level == level

    graph.spin_until(lambda: at(DiagnosticStatus.OK), "one publisher")
    second = graph.node.create_publisher(NavSatFix, "gps/fix", qos_profile_sensor_data)
    graph.spin_until(lambda: at(DiagnosticStatus.WARN), "two publishers")
    last = told()
    assert last is not None
    assert "2 publishers on /gps/fix" in last.message
    graph.node.destroy_publisher(second)
    graph.spin_until(lambda: at(DiagnosticStatus.OK), "one publisher again")
    assert fed.process.interrupt() == 0
    assert (
        "2 publishers on /gps/fix: one may be an attacker's, or of a process that died"
        in fed.process.output
    )


def test_a_poor_receiver_is_told_on_diagnostics_and_in_the_reason(graph: Graph) -> None:
    fed = Fed(graph, "gnss_sanity")

    def claims_9_m(stamp_ns: int) -> NavSatFix:
        message = fix(stamp_ns)
        message.position_covariance = [81.0, 0.0, 0.0, 0.0, 81.0, 0.0, 0.0, 0.0, 81.0]
        message.position_covariance_type = NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
        return message

    def told(level: bytes) -> list[DiagnosticStatus]:
        found = [one for message in fed.diagnostics.messages for one in message.status]
        return [one for one in found if one.name == "/gnss_sanity: receiver" and one.level == level]

    fed.good(10)
    graph.spin_until(lambda: told(DiagnosticStatus.OK), "a word about a good receiver")
    fed.inputs = [
        dataclasses.replace(one, good=claims_9_m) if one.name == "fix" else one
        for one in fed.inputs
    ]
    fed.good(40)
    graph.spin_until(lambda: told(DiagnosticStatus.WARN), "a word about a poor one")
    words = "the receiver is poor by its own word: claims an accuracy of 9.0 m"
    assert told(DiagnosticStatus.WARN)[-1].message.startswith(words)
    assert values_of(told(DiagnosticStatus.WARN)[-1])["poor_accuracy"] == "9.0"
    poor = [one for one in fed.output.messages if words in one.status[0].message]
    assert poor
    assert {values_of(one)["state"] for one in poor} == {"normal"}
    assert fed.process.interrupt() == 0
