# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Connects the monitor to an autopilot that speaks MAVLink, without mavros.

Publishes imu/data_raw, gps/fix, gps/vel, gps/satellites, mag and pressure from the autopilot's
messages, stamped with the time of measurement (TIMESYNC), and /diagnostics. The z of gps/vel is
NaN: MAVLink has no vertical velocity of the receiver. Subscribes hijack_alert and fusion/verdict:
an alert goes to the ground station (STATUSTEXT) and, if the parameter command is set, leads to
one command to the autopilot (none, land, rtl, hold, user_1). Needs the extra mavlink (pymavlink,
pyserial).
"""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from std_msgs.msg import Bool

from hijack_detect.bags.encoding import encode_sample
from hijack_detect.bags.topics import OWN_TOPICS, TYPES
from hijack_detect.contract import Level
from hijack_detect.logs.logged import Logged
from hijack_detect.mavlink.alarm import cause_of
from hijack_detect.mavlink.bridge import Bridge
from hijack_detect.mavlink.codec import Codec, read_key
from hijack_detect.mavlink.link import Address, place
from hijack_detect.mavlink.parameters import BridgeParameters
from hijack_detect.mavlink.report import INPUTS, Reporter
from hijack_detect.mavlink.worker import Worker
from hijack_detect.monitor.verdict_messages import fusion_from
from hijack_detect.nodes.diagnostics import STATUS_LEVELS, Diagnostics, log
from hijack_detect.nodes.messages import message_class
from hijack_detect.nodes.parameters import declare, naming
from hijack_detect.nodes.qos import INTERNAL, OVERRIDES
from hijack_detect.nodes.running import run
from hijack_detect.nodes.state_file import Commanded
from hijack_detect.streams.messages import BadMessage

NEWS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=100, reliability=ReliabilityPolicy.RELIABLE
)
"""Volatile: an alert that was left latched by somebody is not taken, a repetition is."""
REPORT_S = 1.0


class MavlinkBridge(Node):
    """Hands bytes and alerts to a `Bridge`, in the thread of its `Worker`.

    Parameters are read-only: a change would be another link or another promise.
    """

    def __init__(self) -> None:
        """Subscribe, advertise and begin; a link that cannot be opened is tried again.

        Raises:
            ValueError: A parameter is refused, or pymavlink is not installed.
        """
        super().__init__("mavlink_bridge", automatically_declare_parameters_from_overrides=True)
        with naming("mavlink_bridge"):
            parameters = declare(self, BridgeParameters, read_only=True)
            where = place(parameters.connection, parameters.baud)
            key = read_key(parameters.signing_key_file) if parameters.signing_key_file else None
        self._where = where
        self._no_link = "the link is not open yet"
        codec = Codec(parameters.own_component, key)
        memory = Commanded(self.get_fully_qualified_name())
        self._bridge = Bridge(parameters, codec, memory, self, time.monotonic_ns)
        self._reporter = Reporter(self._bridge, codec)
        self._diagnostics = Diagnostics(self)
        self._outputs = {
            name: self.create_publisher(message_class(TYPES[name]), OWN_TOPICS[name], INTERNAL)
            for name in INPUTS
        }
        self._worker = Worker(where, self)
        self._alert, self._verdict = False, b""
        self.create_subscription(
            DiagnosticArray,
            "fusion/verdict",
            self._keep_verdict,
            INTERNAL,
            raw=True,
            qos_overriding_options=OVERRIDES,
        )
        self.create_subscription(
            Bool, "hijack_alert", self._hear, NEWS, qos_overriding_options=OVERRIDES
        )
        wall = Clock(clock_type=ClockType.STEADY_TIME)  # a link knows no simulated time
        self.create_timer(REPORT_S, lambda: self._worker.do(self._report), clock=wall)
        self.get_logger().info(f"connects to {where}")
        self._worker.start()

    def destroy_node(self) -> None:
        """End the link too."""
        self._worker.stop()
        super().destroy_node()

    def _hear(self, message: Bool) -> None:
        self._alert = message.data
        if not self._alert:
            self._verdict = b""
        elif self._verdict:
            self._explain(self._verdict)
        self._worker.do(lambda: self._bridge.receive_alert(alert=message.data))

    def _keep_verdict(self, data: bytes) -> None:
        """Read a verdict in an alert only: there are fifty in a second."""
        self._verdict = data
        if self._alert:
            self._explain(data)

    def _explain(self, data: bytes) -> None:
        try:
            fused = fusion_from(deserialize_message(data, DiagnosticArray))
        except BadMessage as error:
            self.get_logger().warning(f"fusion/verdict: {error}", throttle_duration_sec=10.0)
            return
        cause = cause_of(fused)
        self._worker.do(lambda: self._bridge.alarm.explain(cause))

    # What follows is called in the worker's thread.

    def connected(self) -> None:
        """See Handler."""
        self._no_link = ""
        self.get_logger().info(f"{self._where} is open")
        self._bridge.connected()

    def lost(self, why: str) -> None:
        """See Handler; logged once, and not for each try."""
        if why != self._no_link:
            self.get_logger().error(f"no link: {why}; it is tried again")
        self._no_link = why

    def receive(self, data: bytes, source: Address) -> None:
        """See Handler."""
        self._bridge.receive(data, source)

    def tick(self) -> None:
        """See Handler."""
        self._bridge.tick()

    def failed(self, error: Exception) -> None:
        """See Handler."""
        if self.context.ok():
            self.get_logger().error(f"internal error: {error!r}", throttle_duration_sec=10.0)

    def send(self, data: bytes, to: Address) -> None:
        """See Outside."""
        self._worker.send(data, to)

    def publish(self, reading: Logged) -> None:
        """See Outside."""
        assert not isinstance(reading.value, tuple)
        _, data = encode_sample(reading.value)
        if self.context.ok():
            self._outputs[reading.name].publish(data)

    def say(self, level: Level, text: str) -> None:
        """See Outside."""
        log(self, level, text)

    def _report(self) -> None:
        """Publish on /diagnostics how the link is doing, once a second."""
        report = self._reporter.report(time.monotonic_ns(), self._no_link)
        values = {"connection": str(self._where), **report.values}
        self._diagnostics.report("mavlink", STATUS_LEVELS[report.level], report.text, values)


def main() -> None:
    """Run the node."""
    run(MavlinkBridge, __doc__ or "")


if __name__ == "__main__":
    main()
