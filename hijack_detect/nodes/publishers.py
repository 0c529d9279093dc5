# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Tells when somebody else publishes on a topic that should have one publisher."""

from __future__ import annotations

from collections.abc import Sequence

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from hijack_detect.nodes.diagnostics import Diagnostics

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
        self._diagnostics.tell("publishers", level, text, values)
