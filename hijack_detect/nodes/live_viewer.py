# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node of the live page: it subscribes, and publishes and serves nothing."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import NavSatFix
from std_msgs.msg import Bool, Float64

from hijack_detect.bags.topics import OWN_TOPICS, PRESETS
from hijack_detect.live.picture import Picture
from hijack_detect.monitor.verdict_messages import fusion_from, verdict_from
from hijack_detect.nodes.fusion import ALERT_SUBJECT, ALERT_TOPIC
from hijack_detect.nodes.qos import STATE
from hijack_detect.streams.messages import BadMessage, fix_sample

NEWEST = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=50, reliability=ReliabilityPolicy.BEST_EFFORT
)
"""A viewer may miss a message, and must not make a publisher wait for it."""
LOG_EVERY_S = 10.0
LONGEST = 200
"""Characters of a reason; what is received may be anything. Chosen, not swept."""


class LiveViewer(Node):
    """Hands what it receives to a `Picture`.

    Attributes:
        fix_topic: Where fixes come from, as named before the namespace.
    """

    def __init__(self, picture: Picture, *, namespace: str = "", mavros: bool = False) -> None:
        """Subscribe.

        Args:
            picture: Takes what is received, of the detectors that it expects.
            namespace: Namespace of the vehicle.
            mavros: Whether fixes come from the topic of mavros.
        """
        super().__init__(
            "live",
            namespace=namespace or None,
            enable_rosout=False,
            start_parameter_services=False,
            parameter_overrides=[Parameter("start_type_description_service", value=False)],
        )
        self._picture = picture
        self._logged_at: dict[str, float] = {}
        self.fix_topic = (PRESETS["mavros"].fix if mavros else OWN_TOPICS["fix"]).lstrip("/")
        self._subscribe(
            NavSatFix, self.fix_topic, lambda message: picture.receive_fix(fix_sample(message))
        )
        for name in picture.detectors:
            self._subscribe(DiagnosticArray, f"{name}/verdict", partial(self._verdict, name))
        self._subscribe(
            DiagnosticArray, "fusion/verdict", lambda one: picture.receive_fused(fusion_from(one))
        )
        self._subscribe(Bool, ALERT_TOPIC, lambda one: picture.receive_alert(one.data), STATE)
        self._subscribe(
            Float64, "hijack_confidence", lambda one: picture.receive_confidence(one.data)
        )
        self._subscribe(DiagnosticArray, "/diagnostics", self._diagnosed)

    def _subscribe(
        self, kind: Any, topic: str, take: Callable[[Any], None], qos: QoSProfile = NEWEST
    ) -> None:
        def received(message: Any) -> None:
            try:
                take(message)
            except BadMessage as error:
                self._refuse(topic, str(error)[:LONGEST])

        self.create_subscription(kind, topic, received, qos)

    def _refuse(self, topic: str, why: str) -> None:
        """Report a message that cannot be read, on the page and now and then in the log."""
        name, now = self.resolve_topic_name(topic), time.monotonic()
        self._picture.receive_complaint(name, f"message left out: {why}")
        if now - self._logged_at.get(name, -LOG_EVERY_S) >= LOG_EVERY_S:
            self._logged_at[name] = now
            self.get_logger().warning(f"{name}: message left out: {why}")

    def _verdict(self, name: str, message: DiagnosticArray) -> None:
        self._picture.receive_verdict(name, verdict_from(message))

    def _diagnosed(self, message: DiagnosticArray) -> None:
        """Take complaints of the nodes in this namespace; others have /diagnostics too."""
        space = f"{self.get_namespace().rstrip('/')}/"
        for status in message.status:
            if not status.name.startswith(space):
                continue
            name = status.name.removeprefix(space)
            well = status.level == DiagnosticStatus.OK
            if name == f"fusion: {ALERT_SUBJECT}":
                stale = status.level == DiagnosticStatus.STALE
                self._picture.receive_stale(status.message if stale else "")
            else:
                self._picture.receive_complaint(name, "" if well else status.message)
