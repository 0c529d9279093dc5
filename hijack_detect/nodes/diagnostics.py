# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a node says of itself on /diagnostics."""

from __future__ import annotations

from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

from hijack_detect.nodes.messages import status


class Diagnostics:
    """Publishes the statuses of one node, stamped with the time of its clock."""

    def __init__(self, node: Node) -> None:
        """Advertise."""
        self._node = node
        self._output = node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def tell(self, subject: str, level: bytes, text: str, values: Mapping[str, str]) -> None:
        """Publish a status with the name `NODE: SUBJECT`."""
        self.publish(subject, status("", level, text, values))

    def publish(self, subject: str, told: DiagnosticStatus) -> None:
        """Publish a status that is made already, under the name `NODE: SUBJECT`."""
        told.name = f"{self._node.get_fully_qualified_name()}: {subject}"
        message = DiagnosticArray(status=[told])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._output.publish(message)
