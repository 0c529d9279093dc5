# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The example of a mission manager: decisions by hand, and the real node beside a real fusion."""

from __future__ import annotations

import signal
import time

from diagnostic_msgs.msg import DiagnosticArray
from live import SECOND
from mission_manager import GO_ON, HOLD, LAND, SILENT_S, START_S, Guard
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from ros import KEEP_ALL, Graph
from std_msgs.msg import Bool, String

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.nodes.messages import verdict_message
from hijack_detect.nodes.qos import STATE

EVERY_STATE = QoSProfile(
    history=HistoryPolicy.KEEP_ALL,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""The first command is published 0.2 s after the start, to whoever is known by then."""


def test_silence_holds_and_a_word_goes_on() -> None:
    guard = Guard(0.0)
    assert guard.waited(START_S) == GO_ON
    assert guard.waited(START_S + 0.1) == HOLD
    assert guard.received(40.0, alert=False) == GO_ON
    assert guard.waited(40.0 + SILENT_S) == GO_ON
    assert guard.waited(40.1 + SILENT_S) == HOLD


def test_an_alert_lands_whatever_comes_until_it_is_acknowledged() -> None:
    guard = Guard(0.0)
    assert guard.received(1.0, alert=True) == LAND
    assert guard.waited(100.0) == LAND
    assert guard.received(101.0, alert=False) == LAND
    guard.acknowledged()
    assert guard.received(102.0, alert=False) == GO_ON


def test_it_lands_on_an_alert_and_takes_silence_for_a_fault(graph: Graph) -> None:
    said = graph.listen(String, "mission/command", EVERY_STATE)
    landed = graph.node.create_publisher(Bool, "landed", 1)
    coast = graph.node.create_publisher(DiagnosticArray, "coast/verdict", KEEP_ALL)
    fusion = graph.start("fusion", parameters={"policy": "any"})
    manager = graph.run("examples.mission_manager")

    def until(*commands: str) -> float:
        begun = time.monotonic()
        graph.spin_until(lambda: [one.data for one in said.messages] == [*commands], commands[-1])
        return time.monotonic() - begun

    until(GO_ON)
    graph.spin_until(lambda: "1 monitors are alive" in manager.output, "signs of life")
    fusion.signal(signal.SIGSTOP)
    assert until(GO_ON, HOLD) < SILENT_S + 1.0
    fusion.signal(signal.SIGCONT)
    until(GO_ON, HOLD, GO_ON)
    fusion.signal(signal.SIGKILL)
    fusion.wait()
    assert until(GO_ON, HOLD, GO_ON, HOLD) < SILENT_S + 1.0

    dead = graph.subscribers("coast/verdict")
    fusion = graph.start("fusion", parameters={"policy": "any"})
    until(GO_ON, HOLD, GO_ON, HOLD, GO_ON)
    graph.until_subscribed(coast, dead=dead)
    # The other detectors are silent, and are waited for until the fusion's patience is over.
    for second in range(10):
        stamp_ns = (1_700_000_000 + second) * SECOND
        alarm = Verdict("coast", stamp_ns, State.ALARM, 2.0, 1.0, "says the test")
        coast.publish(verdict_message(alarm))
    until(GO_ON, HOLD, GO_ON, HOLD, GO_ON, LAND)
    alert = graph.listen(Bool, "hijack_alert", STATE)
    graph.spin_until(lambda: alert.messages and alert.messages[-1].data, "the alert")
    while not (alert.messages and alert.messages[-1].data is False):
        landed.publish(Bool(data=True))
        heard = len(alert.messages)
        graph.spin_until(lambda n=heard: len(alert.messages) > n, "the next word of the alert")
    until(GO_ON, HOLD, GO_ON, HOLD, GO_ON, LAND, GO_ON)
    assert manager.interrupt() == 0
