# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A mission manager that acts on alerts and on silence of the monitor.

    python examples/mission_manager.py

Subscribes hijack_alert and landed (Bool). Publishes mission/command (String): `land` on an alert,
`hold` while the monitor is silent, `go on` when it publishes again. After landing it takes the
alert back with fusion/reset, the acknowledgement that it was seen.

Copy what you need: `Guard` decides and knows nothing of ROS, `MissionManager` wires it.
"""

from __future__ import annotations

import sys
import time

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger

from hijack_detect.nodes.qos import ALERT, STATE

SILENT_S = 2.5
"""The alert is repeated every second: two repetitions are missing."""
START_S = 30.0
"""The monitor may take this long to start."""
GO_ON, HOLD, LAND = "go on", "hold", "land"


class Guard:
    """Decision from the monitor's messages and from their absence. Times in seconds."""

    def __init__(self, now_s: float) -> None:
        """Begin; the monitor has START_S to publish."""
        self._silent_from_s = now_s + START_S
        self.command = GO_ON

    def received(self, now_s: float, *, alert: bool) -> str:
        """A message of `hijack_alert` was received."""
        self._silent_from_s = now_s + SILENT_S
        if alert:
            self.command = LAND
        elif self.command == HOLD:
            self.command = GO_ON
        return self.command

    def waited(self, now_s: float) -> str:
        """Time has passed. A landing goes on whatever the monitor does."""
        if now_s > self._silent_from_s and self.command != LAND:
            self.command = HOLD
        return self.command

    def acknowledged(self) -> None:
        """The vehicle has landed and the alert was taken back."""
        self.command = GO_ON


class MissionManager(Node):
    """Asks the guard whenever something happens, and at least five times a second."""

    def __init__(self) -> None:
        """Subscribe and advertise."""
        super().__init__("mission_manager")
        self._guard = Guard(time.monotonic())
        self._published = ""
        self._commands = self.create_publisher(String, "mission/command", STATE)
        # DDS reports a missing repetition and a hanging node; the timer alone would do as well.
        events = SubscriptionEventCallbacks(
            deadline=lambda _: self.get_logger().warning("the monitor is late"),
            liveliness=self._liveliness,
        )
        self.create_subscription(Bool, "hijack_alert", self._alert, ALERT, event_callbacks=events)
        self.create_subscription(Bool, "landed", self._landed, 1)
        self._reset = self.create_client(Trigger, "fusion/reset")
        # A clock that cannot be set or paused, not even by a simulation.
        self.create_timer(0.2, self._wait, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _liveliness(self, change: object) -> None:
        alive = getattr(change, "alive_count", 0)
        self.get_logger().info(f"{alive} monitors are alive")

    def _alert(self, message: Bool) -> None:
        self._command(self._guard.received(time.monotonic(), alert=message.data))

    def _wait(self) -> None:
        self._command(self._guard.waited(time.monotonic()))

    def _landed(self, message: Bool) -> None:
        if message.data and self._guard.command == LAND and self._reset.service_is_ready():
            self._reset.call_async(Trigger.Request()).add_done_callback(
                lambda _: self._guard.acknowledged()
            )

    def _command(self, command: str) -> None:
        if command != self._published:
            self._published = command
            self.get_logger().info(f"command: {command}")
            self._commands.publish(String(data=command))


def main() -> None:
    """Run it until Ctrl-C."""
    rclpy.init(args=sys.argv)
    try:
        rclpy.spin(MissionManager())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
