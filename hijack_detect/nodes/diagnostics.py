# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Statuses of a node on /diagnostics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

from hijack_detect.contract import Level
from hijack_detect.nodes.messages import status

STATUS_LEVELS: Mapping[Level, bytes] = {
    "info": DiagnosticStatus.OK,
    "warning": DiagnosticStatus.WARN,
    "error": DiagnosticStatus.ERROR,
}


def log(node: Node, level: Level, text: str) -> None:
    """Write a line into the log of a node."""
    # rclpy wants one severity for each line that logs.
    if level == "error":
        node.get_logger().error(text)
    elif level == "warning":
        node.get_logger().warning(text)
    else:
        node.get_logger().info(text)


EVERY_S = 1.0
OTHERS = "an attacker's, or of a process that died"


class PublisherWatch:
    """Counts the publishers of topics once a second; more than one is a warning.

    It changes no verdict: those depend on stamped messages alone.
    """

    def __init__(self, node: Node, diagnostics: Diagnostics, topics: Sequence[str]) -> None:
        """Watch topics, named as the node resolves them."""
        self._node, self._diagnostics = node, diagnostics
        self._counts = {node.resolve_topic_name(topic): 0 for topic in topics}
        node.create_timer(EVERY_S, self._count)

    def _count(self) -> None:
        crowded = []
        for topic, before in self._counts.items():
            count = self._counts[topic] = self._node.count_publishers(topic)
            if count > 1:
                text = f"{count} publishers on {topic}: one may be {OTHERS}"
                crowded.append(text)
                if count > before:
                    self._node.get_logger().warning(text)
        level = DiagnosticStatus.WARN if crowded else DiagnosticStatus.OK
        text = "; ".join(crowded) or "no topic has two publishers"
        values = {topic: str(count) for topic, count in self._counts.items()}
        self._diagnostics.report("publishers", level, text, values)


class Diagnostics:
    """Publishes the statuses of one node, stamped with the time of its clock."""

    def __init__(self, node: Node) -> None:
        """Advertise."""
        self._node = node
        self._output = node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def report(self, subject: str, level: bytes, text: str, values: Mapping[str, str]) -> None:
        """Publish a status with the name `NODE: SUBJECT`."""
        self.publish(subject, status("", level, text, values))

    def publish(self, subject: str, status: DiagnosticStatus) -> None:
        """Publish a status that is made already, under the name `NODE: SUBJECT`."""
        status.name = f"{self._node.get_fully_qualified_name()}: {subject}"
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._output.publish(message)
