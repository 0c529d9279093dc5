# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How a node's inputs and outputs are wired: to topics, or within one process to other nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import QuaternionStamped, TwistStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, NavSatFix
from std_msgs.msg import UInt32

from hijack_detect.monitor.graph import input_names
from hijack_detect.monitor.parts import Part
from hijack_detect.nodes.qos import INTERNAL, OVERRIDES, SENSOR
from hijack_detect.streams.absence import Absence
from hijack_detect.streams.cdr import FROM_BYTES, stamp_from_bytes
from hijack_detect.streams.messages import CONVERTERS, header_stamp_ns, satellite_count
from hijack_detect.streams.receiver_clock import Passed, ReceiverClock

SATELLITES = "satellites"
"""Has no header: how its messages get a stamp depends on the order of publication."""
IMU_TOPIC = "imu/data_raw"
"""Its stamps tell the time, see `ReceiverClock`."""


PHASE_TOPIC = "flight_phase"


@dataclass(frozen=True)
class Input:
    """A subscription that feeds the stage's input of the same name.

    With `from_bytes`, which may give None, messages come as bytes and are made only if need be.
    """

    topic: str
    message_type: type
    qos: QoSProfile
    convert: Callable[[Any], Any]
    from_bytes: Callable[[bytes], Any] | None = None

    def sample(self, heard: Any) -> Any:
        """What is in a message or its bytes. Raises BadMessage."""
        found = None if self.from_bytes is None else self.from_bytes(heard)
        return self.convert(self.message(heard)) if found is None else found

    def message(self, heard: Any) -> Any:
        """The message that was heard, made from its bytes if it came as those."""
        return deserialize_message(heard, self.message_type) if self.from_bytes else heard


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
"""The inputs that a part can have, by name: sensors, and what the estimators publish."""


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


class Hearer(Protocol):
    """A node with inputs."""

    NEEDS_SOURCE_TIMES: bool
    """Whether it must be told when each message was published."""

    @property
    def node(self) -> Node:
        """The node itself."""

    def take(self, name: str, converted: Any, published_ns: int) -> None:
        """Take what a message of an input was converted to."""

    def take_over(self, name: str, outputs: Sequence[Any], passed_ns: int) -> None:
        """Take another node's outputs as an input, which brings nothing more up to a stamp."""

    def read(self, name: str, given: Input, heard: Any) -> Any:
        """What a message was converted to; None if it cannot be used, which has been told then."""

    def lacks(self, component: str) -> None:
        """Report that a component of an input is not measured. Called again while that is so."""


class Source:
    """A topic outside of the process: one subscription for all nodes in it that hear it.

    What the sender does not measure is marked here, as `read_samples` does for a bag, and then
    goes through the clock that the process has, see `ReceiverClock`.
    """

    def __init__(self, hearer: Hearer, name: str, given: Input, clock: ReceiverClock) -> None:
        """Begin with one node and the name of its input."""
        self.given = given
        self.hearers = [(hearer, name)]
        self._absence = Absence()
        self._clock = clock

    @property
    def timed(self) -> bool:
        """Whether a node must know when its messages were published."""
        return any(hearer.NEEDS_SOURCE_TIMES for hearer, _ in self.hearers)

    def hear(self, heard: Any, published_ns: int = 0) -> None:
        """Convert a message once, and give it to all; the first of them tells of a bad one."""
        first, own_name = self.hearers[0]
        sample = first.read(own_name, self.given, heard)
        marked = None if sample is None else self._absence(sample)
        for component in self._absence.names:
            first.lacks(component)
        if marked is not None:
            give(self._clock.push(own_name, marked, (self, published_ns)))
            tell(self._clock, first.node)

    def give(self, sample: Any, published_ns: int) -> None:
        """Give a sample to all."""
        for hearer, name in self.hearers:
            hearer.take(name, sample, published_ns)


def give(passed: Iterable[Passed]) -> None:
    """Give what a clock let through to those that hear it."""
    for _, sample, (source, published_ns) in passed:
        source.give(sample, published_ns)


def tell(clock: ReceiverClock, node: Node) -> None:
    """Log what a clock found."""
    while clock.said:
        node.get_logger().warning(clock.said.pop(0))


class Wiring(Protocol):
    """What a node's inputs come from, and where its outputs go beside their topics."""

    @property
    def rate_hz(self) -> float | None:
        """Largest rate of an intermediate topic, Hz; None publishes every output."""

    def listen(self, hearer: Hearer, name: str, given: Input) -> None:
        """Give a node one of its inputs."""

    def hear_time(self, hearer: Hearer) -> None:
        """See to it that the IMU's stamps are known to a node that has GPS but no IMU."""

    def offer(self, topic: str) -> None:
        """Note that the outputs of a node will be handed over under a topic's full name."""

    def hand_over(self, topic: str, outputs: Sequence[Any], passed_ns: int) -> None:
        """Give outputs to the nodes that have them as an input.

        Args:
            topic: What was offered.
            outputs: What follows from a message; may be nothing.
            passed_ns: No later output will have a stamp up to this one, nanoseconds.
        """


class Topics:
    """Every node by itself: it subscribes to each of its inputs, and only publishes."""

    rate_hz: float | None = None

    def __init__(self) -> None:
        """Start without inputs."""
        self._clock = ReceiverClock()

    def listen(self, hearer: Hearer, name: str, given: Input) -> None:
        """See Wiring."""
        source = Source(hearer, name, given, self._clock)

        def heard_with_time(message: Any, info: Mapping[str, Any]) -> None:
            source.hear(message, info["source_timestamp"])

        subscribe(hearer.node, given, heard_with_time if source.timed else source.hear)

    def hear_time(self, hearer: Hearer) -> None:
        """See Wiring; only the stamps of the messages are read."""
        node = hearer.node

        def heard(data: bytes) -> None:
            stamp_ns = stamp_from_bytes(data)
            if stamp_ns is None:
                stamp_ns = header_stamp_ns(deserialize_message(data, Imu))
            give(self._clock.note_reference(stamp_ns))
            tell(self._clock, node)

        node.create_subscription(
            Imu, IMU_TOPIC, heard, SENSOR, raw=True, qos_overriding_options=OVERRIDES
        )

    def offer(self, topic: str) -> None:
        """See Wiring; nobody is there to take it."""

    def hand_over(self, topic: str, outputs: Sequence[Any], passed_ns: int) -> None:
        """See Wiring; nobody is there to take it."""


def subscribe(node: Node, given: Input, callback: Callable[..., None]) -> None:
    """Make an input's subscription; parameters `qos_overrides` of the node can change its QoS."""
    node.create_subscription(
        given.message_type,
        given.topic,
        callback,
        given.qos,
        raw=given.from_bytes is not None,
        qos_overriding_options=OVERRIDES,
    )
