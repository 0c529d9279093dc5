# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How bad something is: in the log, and on /diagnostics."""

from __future__ import annotations

from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from hijack_detect.level import Level

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
