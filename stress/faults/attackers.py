# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attackers that can publish on the ROS graph."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import NavSatFix
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.nodes.messages import verdict_message
from hijack_detect.nodes.qos import ALERT, INTERNAL
from hijack_detect.streams.samples import NANOSECONDS
from stress.faults.flight import END_S, Sent

FIX, IMU = "/gps/fix", "/imu/data_raw"
FOREIGN = 0.002
"""Degrees of latitude between two receivers: 220 m."""
COPIES = 50
"""Of each message of the IMU: 10,000 a second."""
AHEAD_NS = 3600 * NANOSECONDS


class Attacker(Protocol):
    """Acts beside the flight, while the fault lasts."""

    def __call__(self, one: Sent) -> None:
        """A message of the flight was published."""
        ...


MakeAttacker = Callable[[Node], Attacker]


def second_receiver(node: Node) -> Attacker:
    """Publishes fixes from elsewhere."""
    outlet = node.create_publisher(NavSatFix, FIX, qos_profile_sensor_data)

    def act(one: Sent) -> None:
        if one.topic == FIX:
            fix = deserialize_message(one.data, NavSatFix)
            fix.latitude += FOREIGN
            outlet.publish(fix)

    return act


def forged_bool(topic: str, *, value: bool) -> MakeAttacker:
    """Says with every fix on a topic that there is, or is not, a hijack."""

    def make(node: Node) -> Attacker:
        outlet = node.create_publisher(Bool, topic, ALERT)

        def act(one: Sent) -> None:
            if one.topic == FIX:
                outlet.publish(Bool(data=value))

        return act

    return make


def forged_verdict(detector: str, state: State, *, ahead_ns: int = 1) -> MakeAttacker:
    """Publishes with every fix a forged verdict of a detector, stamped after that fix."""

    def make(node: Node) -> Attacker:
        outlet = node.create_publisher(DiagnosticArray, f"{detector}/verdict", INTERNAL)

        def act(one: Sent) -> None:
            if one.topic == FIX and one.stamp_ns is not None:
                score = 5.0 if state is State.ALARM else 0.0
                forged = Verdict(detector, one.stamp_ns + ahead_ns, state, score, 1.0, "forged")
                outlet.publish(verdict_message(forged))

        return act

    return make


def flood(topic: str, kind: type, qos: QoSProfile = qos_profile_sensor_data) -> MakeAttacker:
    """Publishes empty messages, 10,000 a second."""

    def make(node: Node) -> Attacker:
        outlet = node.create_publisher(kind, topic, qos)
        message = kind()

        def act(one: Sent) -> None:
            if one.topic == IMU:
                for _ in range(COPIES):
                    outlet.publish(message)

        return act

    return make


def false_reset(node: Node) -> Attacker:
    """Takes the alert back, once, in the middle of the fault."""
    client = node.create_client(Trigger, "fusion/reset")
    asked = False

    def act(one: Sent) -> None:
        nonlocal asked
        if not asked and one.at_s > END_S - 2.0 and client.service_is_ready():
            asked = True
            client.call_async(Trigger.Request())

    return act
