# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The inputs that a part of the monitor can have: topic, message type, QoS and conversion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import QuaternionStamped, TwistStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, NavSatFix
from std_msgs.msg import UInt32

from hijack_detect.monitor.graph import input_names
from hijack_detect.monitor.parts import Part
from hijack_detect.monitor.verdict_messages import verdict_from
from hijack_detect.nodes.qos import INTERNAL, OVERRIDES, SENSOR
from hijack_detect.streams.cdr import FROM_BYTES
from hijack_detect.streams.messages import CONVERTERS, satellite_count
from hijack_detect.streams.satellites import SATELLITES

IMU_TOPIC = "imu/data_raw"
"""Its stamps tell the time, see `ReceiverClock`."""
PHASE_TOPIC = "flight_phase"


@dataclass(frozen=True)
class Input:
    """A subscription that brings one input of a part.

    With `from_bytes`, which may give None, messages come as bytes and are made only if need be.
    """

    topic: str
    message_type: type
    qos: QoSProfile
    convert: Callable[[Any], Any]
    from_bytes: Callable[[bytes], Any] | None = None

    def sample(self, received: Any) -> Any:
        """Convert a message or its bytes. Raises BadMessage."""
        found = None if self.from_bytes is None else self.from_bytes(received)
        return self.convert(self.message(received)) if found is None else found

    def message(self, received: Any) -> Any:
        """The message, made from its bytes if it came as those."""
        return deserialize_message(received, self.message_type) if self.from_bytes else received

    def subscribe(self, node: Node, callback: Callable[..., None]) -> None:
        """Subscribe as a node, whose parameters `qos_overrides` can change the QoS."""
        node.create_subscription(
            self.message_type,
            self.topic,
            callback,
            self.qos,
            raw=self.from_bytes is not None,
            qos_overriding_options=OVERRIDES,
        )


def _input(name: str, topic: str, message_type: type, qos: QoSProfile) -> Input:
    """An input converted by the converter of its name."""
    return Input(topic, message_type, qos, CONVERTERS[name], FROM_BYTES.get(name))


INPUTS: Mapping[str, Input] = {
    "imu": _input("imu", IMU_TOPIC, Imu, SENSOR),
    "fix": _input("fix", "gps/fix", NavSatFix, SENSOR),
    "velocity": _input("velocity", "gps/vel", TwistStamped, SENSOR),
    SATELLITES: Input("gps/satellites", UInt32, SENSOR, satellite_count),
    "mag": _input("mag", "mag", MagneticField, SENSOR),
    "pressure": _input("pressure", "pressure", FluidPressure, SENSOR),
    "phase": _input("phase", PHASE_TOPIC, DiagnosticArray, INTERNAL),
    "attitude": _input("attitude", "imu/data", Imu, INTERNAL),
    "course": _input("course", "gps/course", QuaternionStamped, INTERNAL),
}
"""By name: sensors, and what the estimators publish. A detector's name is its verdicts."""


def inputs_of(part: Part) -> Mapping[str, Input]:
    """The inputs of an estimator or detector.

    Raises:
        ValueError: It has one that there is not.
    """
    names = input_names(part)
    if unknown := {*names} - {*INPUTS}:
        raise ValueError(
            f"{part.name}: there is no input '{min(unknown)}' (there are: {', '.join(INPUTS)})"
        )
    return {name: INPUTS[name] for name in names}


def verdict_topic(detector: str) -> str:
    """Topic of the verdicts of a detector."""
    return f"{detector}/verdict"


def verdict_input(detector: str) -> Input:
    """The verdicts of a detector as an input of the fusion."""
    return Input(verdict_topic(detector), DiagnosticArray, INTERNAL, verdict_from)
