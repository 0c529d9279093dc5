# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Keeps a journal of the flight, and a bag of what was around each alert.

Subscribes the inputs imu/data_raw, gps/fix, gps/vel, mag, pressure and gps/satellites,
DETECTOR/verdict of every detector and of those that further_detectors names, fusion/verdict,
hijack_alert, and spoof_active where there is a ground truth. imu/data and gps/course are not
recorded: they follow from the inputs.
Publishes ~/snapshot (String, latched: the path of the newest snapshot) and /diagnostics.

Writes FOLDER/journal.sqlite3, read by `hijack-detect journal`, and FOLDER/snapshots/alert_TIME,
read by `hijack-detect analyze` and rosbag2. A disk that is full or cannot be written is reported;
nothing else stops.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from std_msgs.msg import String

from hijack_detect import __version__
from hijack_detect.bags.topics import OWN_TOPICS, TYPES
from hijack_detect.contract import Level
from hijack_detect.monitor.parts import DETECTORS
from hijack_detect.monitor.verdict_messages import verdict_from
from hijack_detect.nodes.diagnostics import STATUS_LEVELS, Diagnostics, log
from hijack_detect.nodes.messages import message_class
from hijack_detect.nodes.parameters import declare, naming
from hijack_detect.nodes.qos import INTERNAL, OVERRIDES, SENSOR, STATE
from hijack_detect.nodes.running import run
from hijack_detect.recording.black_box import FUSION, Source
from hijack_detect.recording.parameters import RecorderParameters
from hijack_detect.recording.recorder import Recorder

JOURNALED = ("fix", "velocity", "satellites")
FLAGS = ("hijack_alert", "spoof_active")
BOOL, VERDICT = "std_msgs/msg/Bool", "diagnostic_msgs/msg/DiagnosticArray"
EVERY_STATE = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=500,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""As STATE, but for a consumer of all messages and not only of the newest."""
TICK_S = 0.1
REPORT_S = 1.0


class RecorderNode(Node):
    """Hands raw messages to a `Recorder`. Parameters are read-only: files would change."""

    def __init__(self) -> None:
        """Open the folder and subscribe; a folder that cannot be used is reported, not raised.

        Raises:
            ParameterError: A parameter is unknown or out of bounds.
        """
        super().__init__("recorder", automatically_declare_parameters_from_overrides=True)
        with naming("recorder"):
            parameters = declare(self, RecorderParameters, read_only=True)
        self._path = self.create_publisher(String, "~/snapshot", STATE)
        self._diagnostics = Diagnostics(self)
        name = self.get_fully_qualified_name()
        self._recorder = Recorder(parameters, name, __version__, self._tell, self._announce)
        for name, topic in OWN_TOPICS.items():
            decode = _decoder(TYPES[name]) if name in JOURNALED else None
            self._record(name, topic, TYPES[name], SENSOR, decode, stamped=name != "satellites")
        for name in (*DETECTORS, *parameters.further_detectors.split()):
            self._record(name, f"{name}/verdict", VERDICT, INTERNAL, _verdict)
        self._record(FUSION, f"{FUSION}/verdict", VERDICT, INTERNAL, _decoder(VERDICT))
        for name in FLAGS:
            self._record(name, name, BOOL, EVERY_STATE, None, stamped=False)
        wall = Clock(clock_type=ClockType.STEADY_TIME)  # a disk knows no simulated time
        self.create_timer(TICK_S, self._tick, clock=wall)
        self.create_timer(REPORT_S, self._report, clock=wall)

    def destroy_node(self) -> None:
        """Finish snapshot and journal too."""
        self._recorder.close()
        super().destroy_node()

    def _record(
        self,
        name: str,
        topic: str,
        msgtype: str,
        qos: QoSProfile,
        decode: Callable[[bytes], Any] | None,
        *,
        stamped: bool = True,
    ) -> None:
        """Subscribe a topic as bytes."""
        source = Source(name, self.resolve_topic_name(topic), msgtype, stamped, decode)

        def received(data: bytes) -> None:
            try:
                self._recorder.receive(source, data)
            except Exception as error:  # what is recorded must not end the recorder
                self._recorder.refuse(source, error)

        self.create_subscription(
            message_class(msgtype),
            topic,
            received,
            qos,
            raw=True,
            qos_overriding_options=OVERRIDES,
        )

    def _tick(self) -> None:
        try:
            self._recorder.tick()
        except Exception as error:  # log and count an internal error; keep running
            self.get_logger().error(f"internal error: {error!r}", throttle_duration_sec=10.0)

    def _tell(self, level: Level, text: str) -> None:
        log(self, level, text)

    def _announce(self, path: Path) -> None:
        if self.context.ok():
            self._path.publish(String(data=str(path)))

    def _report(self) -> None:
        """Publish on /diagnostics how the recorder is doing, once a second."""
        report = self._recorder.report()
        self._diagnostics.report(
            "recorder", STATUS_LEVELS[report.level], report.text, report.values
        )


def _decoder(msgtype: str) -> Callable[[bytes], Any]:
    kind = message_class(msgtype)
    return lambda data: deserialize_message(data, kind)


def _verdict(data: bytes) -> Any:
    return verdict_from(deserialize_message(data, DiagnosticArray))


def main() -> None:
    """Run the node."""
    run(RecorderNode, __doc__ or "")


if __name__ == "__main__":
    main()
