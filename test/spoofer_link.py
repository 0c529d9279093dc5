# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A gps_spoofer, and the test as the receiver before it and as all that its users hear."""

from __future__ import annotations

from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TwistStamped
from live import SECOND, values_of
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from ros import KEEP_ALL, Graph
from sensor_msgs.msg import NavSatFix
from std_msgs.msg import Bool, Float64, UInt32

from hijack_detect.nodes.messages import time_message
from hijack_detect.streams.messages import fix_sample, velocity_sample

START_NS = 1_700_000_000 * SECOND
STEP_NS = SECOND // 5
TOPICS = {"fix": "gps/fix", "velocity": "gps/vel", "satellites": "gps/satellites"}
TYPES = {"fix": NavSatFix, "velocity": TwistStamped, "satellites": UInt32}
LOSSLESS = [
    word
    for topic in TOPICS.values()
    for policy in ("reliability:=reliable", "history:=keep_all")
    for word in ("-p", f"qos_overrides./{topic}_in.subscription.{policy}")
]
SET = "gps_spoofer/set_parameters_atomically"


def true_messages(index: int) -> dict[str, Any]:
    """What a receiver says: a flight to the North-East at 5 m/s that climbs."""
    seconds = index / 5.0
    fix = NavSatFix(altitude=500.0 + seconds, position_covariance_type=2)
    fix.header.stamp = time_message(START_NS + index * STEP_NS)
    fix.header.frame_id = "antenna"
    fix.status.status, fix.status.service = 0, 5
    fix.latitude, fix.longitude = 48.0 + 4e-5 * seconds, 11.0 + 4e-5 * seconds
    fix.position_covariance = np.diag([1.0, 1.0, 4.0]).ravel()
    velocity = TwistStamped()
    velocity.header = fix.header
    velocity.twist.linear.x, velocity.twist.linear.y, velocity.twist.linear.z = 3.0, 4.4, 1.0
    velocity.twist.angular.z = 0.25
    return {"fix": fix, "velocity": velocity, "satellites": UInt32(data=12 + index % 3)}


class Link:
    """A receiver, a spoofer, and its users."""

    def __init__(self, graph: Graph, *arguments: str, **parameters: Any) -> None:
        self.graph = graph
        self.heard = {name: graph.listen(TYPES[name], topic) for name, topic in TOPICS.items()}
        self.truth = graph.listen(Bool, "spoof_active")
        self.offset = graph.listen(Float64, "gps_spoofer/offset")
        self.diagnostics = graph.listen(DiagnosticArray, "/diagnostics")
        self.node = graph.start("gps_spoofer", *LOSSLESS, *arguments, parameters=parameters)
        self.publishers = {
            name: graph.node.create_publisher(TYPES[name], f"{topic}_in", KEEP_ALL)
            for name, topic in TOPICS.items()
        }
        graph.spin_until(
            lambda: all(one.get_subscription_count() for one in self.publishers.values()),
            "the spoofer",
        )
        graph.until_known("gps_spoofer")
        self.sent: dict[str, list[Any]] = {name: [] for name in TOPICS}

    def send(self, count: int = 1, names: tuple[str, ...] = tuple(TOPICS)) -> None:
        """Send the next messages, and wait until they have come through."""
        for _ in range(count):
            messages = true_messages(len(self.sent["fix"]))
            for name in names:
                self.put(name, messages[name])

    def put(self, name: str, message: Any) -> None:
        """Send one message, and wait until it has come through."""
        self.sent[name].append(message)
        self.publishers[name].publish(message)
        self.settle()

    def settle(self) -> None:
        for name, sent in self.sent.items():
            heard = self.heard[name].messages
            self.graph.spin_until(
                lambda heard=heard, sent=sent: len(heard) >= len(sent), "everything through"
            )
        fixes = self.sent["fix"]
        for one in (self.truth, self.offset):
            self.graph.spin_until(
                lambda one=one: len(one.messages) >= len(fixes), "the ground truth"
            )

    def change(self, **values: Any) -> str:
        """Set parameters at once; return why it was refused, empty if it was not."""
        given = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        request = SetParametersAtomically.Request(parameters=given)
        result = self.graph.call(SetParametersAtomically, SET, request).result
        assert result.successful == (not result.reason)
        return str(result.reason)

    def report(self, unacknowledged: str = "") -> DiagnosticStatus:
        """The next report of the spoofer that waits for the acknowledgement of these topics."""
        before = len(self.diagnostics.messages)

        def new() -> list[DiagnosticStatus]:
            return [
                one
                for message in self.diagnostics.messages[before:]
                for one in message.status
                if one.name == "/gps_spoofer: spoofer"
                and values_of(one)["unacknowledged"] == unacknowledged
            ]

        self.graph.spin_until(new, "a report")
        return new()[-1]

    def samples(self, first: int) -> list[tuple[Any, ...]]:
        """What was heard from an index on: fix, velocity, count, truth and offset."""
        fixes, velocities, counts = (self.heard[name].messages[first:] for name in TOPICS)
        return [
            (fix_sample(fix), velocity_sample(velocity), count.data, flag.data, offset.data)
            for fix, velocity, count, flag, offset in zip(
                fixes,
                velocities,
                counts,
                self.truth.messages[first:],
                self.offset.messages[first:],
                strict=True,
            )
        ]
