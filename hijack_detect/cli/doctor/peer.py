# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One of two processes of `doctor` that test DDS: `publish TOPIC` or `subscribe TOPIC`."""

from __future__ import annotations

import json
import os
import statistics
import sys
import time
from typing import Any

import rclpy
from rclpy.node import Node
from std_msgs.msg import Int64

from hijack_detect.nodes.qos import INTERNAL

ENOUGH = 20
"""Messages for a median. Chosen, not swept."""
EVERY_S = 0.02
LONGEST_S = 30.0
"""Safety net behind the timeout of `doctor`, TALK_S. Chosen: more than twice that."""


def main(role: str, topic: str) -> None:
    """Publish the time, or subscribe to it and print its median latency in milliseconds."""
    rclpy.init()
    node = Node(f"hijack_detect_doctor_{role}", enable_rosout=False, start_parameter_services=False)
    late_ms: list[float] = []
    if role == "publish":
        publisher = node.create_publisher(Int64, topic, INTERNAL)
        node.create_timer(EVERY_S, lambda: publisher.publish(Int64(data=time.monotonic_ns())))
    else:

        def receive(message: Any) -> None:
            late_ms.append((time.monotonic_ns() - message.data) / 1e6)

        node.create_subscription(Int64, topic, receive, INTERNAL)
    end_s = time.monotonic() + LONGEST_S
    while rclpy.ok() and len(late_ms) < ENOUGH and time.monotonic() < end_s:
        rclpy.spin_once(node, timeout_sec=0.1)
    if role == "subscribe":
        # The first ones may have waited until the other side was discovered.
        print(json.dumps(statistics.median(late_ms) if late_ms else None), flush=True)
    os._exit(0)  # Fast DDS can lock itself up at shutdown


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
