# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How a node's inputs and outputs are wired: to topics, or within one process to other nodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message

from hijack_detect.nodes.qos import OVERRIDES
from hijack_detect.streams.absence import Absence
from hijack_detect.streams.imu_bytes import FROM_BYTES
from hijack_detect.streams.messages import CONVERTERS


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


def sensor_input(name: str, topic: str, message_type: type, qos: QoSProfile) -> Input:
    """An input converted by the converter of its name."""
    return Input(topic, message_type, qos, CONVERTERS[name], FROM_BYTES.get(name))


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

    What the sender does not measure is marked here, as `read_samples` does for a bag.
    """

    def __init__(self, hearer: Hearer, name: str, given: Input) -> None:
        """Begin with one node and the name of its input."""
        self.given = given
        self.hearers = [(hearer, name)]
        self._absence = Absence()

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
            for hearer, name in self.hearers:
                hearer.take(name, marked, published_ns)


class Wiring(Protocol):
    """What a node's inputs come from, and where its outputs go beside their topics."""

    @property
    def rate_hz(self) -> float | None:
        """Largest rate of an intermediate topic, Hz; None publishes every output."""

    def listen(self, hearer: Hearer, name: str, given: Input) -> None:
        """Give a node one of its inputs."""

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

    def listen(self, hearer: Hearer, name: str, given: Input) -> None:
        """See Wiring."""
        source = Source(hearer, name, given)

        def heard_with_time(message: Any, info: Mapping[str, Any]) -> None:
            source.hear(message, info["source_timestamp"])

        subscribe(hearer.node, given, heard_with_time if source.timed else source.hear)

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
