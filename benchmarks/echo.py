# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The least that a node can do: it receives the inputs, and answers each fix at once."""

from __future__ import annotations

from geometry_msgs.msg import TwistStamped
from rclpy.node import Node
from sensor_msgs.msg import Imu, NavSatFix
from std_msgs.msg import Bool

from hijack_detect.nodes.qos import INTERNAL, SENSOR
from hijack_detect.nodes.running import run


class Echo(Node):
    """Receives without looking; the answer to a fix makes a round trip of two hops."""

    def __init__(self) -> None:
        """Subscribe and advertise."""
        super().__init__("echo")
        self._answer = self.create_publisher(Bool, "echo", INTERNAL)
        for kind, topic in ((Imu, "imu/data_raw"), (TwistStamped, "gps/vel")):
            self.create_subscription(kind, topic, lambda _: None, SENSOR, raw=True)
        self.create_subscription(
            NavSatFix, "gps/fix", lambda _: self._answer.publish(Bool()), SENSOR, raw=True
        )


if __name__ == "__main__":
    run(Echo, __doc__ or "")
