# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A publisher that costs nothing while nobody listens."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from hijack_detect.nodes.qos import INTERNAL
from hijack_detect.streams.samples import NANOSECONDS


class Outlet:
    """Publishes on an intermediate topic while somebody listens, and no faster than at a rate.

    The rate goes by stamps: the first output in each period is published, and each that `change`
    says is news.
    """

    def __init__(self, node: Node, kind: Any, topic: str, rate_hz: float | None) -> None:
        """Advertise.

        Args:
            node: The node.
            kind: Type of the messages.
            topic: The topic.
            rate_hz: Largest rate, Hz; None publishes every output.
        """
        self._publisher: Any = node.create_publisher(kind, topic, INTERNAL)
        self._period_ns = 0 if rate_hz is None else round(NANOSECONDS / rate_hz)
        self._last: int | None = None

    def publish(self, stamp_ns: int, make: Callable[[], Any], *, change: bool = False) -> None:
        """Publish the message of an output, if it is wanted.

        Args:
            stamp_ns: Stamp of the output, nanoseconds.
            make: Makes the message.
            change: Whether it says something new, which is not left out for the rate.
        """
        if not self._publisher.get_subscription_count():
            return
        if self._period_ns:
            period = stamp_ns // self._period_ns
            if period == self._last and not change:
                return
            self._last = period
        self._publisher.publish(make())
