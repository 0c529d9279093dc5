# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Subscriber of the monitor and the replay, as a mission manager is one."""

from __future__ import annotations

from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from std_msgs.msg import Bool, Float64

from hijack_detect.detectors.verdict import Verdict
from hijack_detect.monitor.parts import DETECTORS
from hijack_detect.monitor.verdict_messages import verdict_from
from hijack_detect.nodes.qos import INTERNAL, STATE


class Listener(Node):
    """Keeps every verdict, and the newest of everything else."""

    def __init__(self) -> None:
        """Subscribe."""
        super().__init__("demo_listener")
        self.verdicts: dict[str, list[Verdict]] = {name: [] for name in DETECTORS}
        self.alert_ns: int | None = None
        """Stamp of the alert, from fusion/verdict."""
        self.cause = ""
        self.alert = False
        """The newest hijack_alert."""
        self.confidence = 0.0
        self.position_s = 0.0
        """Position of the replay, seconds from the bag's first message."""
        self.spoofed = False
        self.finished = False
        for name in DETECTORS:
            topic = f"{name}/verdict"
            self.create_subscription(DiagnosticArray, topic, self._keeper(name), INTERNAL)
        self.create_subscription(DiagnosticArray, "fusion/verdict", self._fused, INTERNAL)
        self.create_subscription(Bool, "hijack_alert", self._alerted, STATE)
        self.create_subscription(Bool, "spoof_active", self._spoofing, STATE)
        self.create_subscription(Float64, "bag_replay/position", self._moved, 10)
        self.create_subscription(Bool, "bag_replay/finished", self._ended, STATE)

    def _keeper(self, name: str) -> Callable[[DiagnosticArray], None]:
        def keep(message: DiagnosticArray) -> None:
            self.verdicts[name].append(verdict_from(message))

        return keep

    def _fused(self, message: DiagnosticArray) -> None:
        values = {pair.key: pair.value for pair in message.status[0].values}
        self.confidence = float(values["confidence"])
        if values["alert_since_ns"] and self.alert_ns is None:
            self.alert_ns = int(values["alert_since_ns"])
            self.cause = message.status[0].message

    def _alerted(self, message: Bool) -> None:
        self.alert = message.data

    def _spoofing(self, message: Bool) -> None:
        self.spoofed = message.data

    def _moved(self, message: Float64) -> None:
        self.position_s = message.data

    def _ended(self, message: Bool) -> None:
        self.finished = message.data
