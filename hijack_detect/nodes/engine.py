# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One process of the monitor: subscriptions, the monitor itself, and the nodes of its parts."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import traceback
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import QuaternionStamped, TwistStamped
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rclpy.utilities import ok
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, NavSatFix
from std_msgs.msg import UInt32

from hijack_detect.monitor.graph import Monitor, input_names
from hijack_detect.monitor.parts import Part, load
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.monitor.verdict_messages import verdict_from
from hijack_detect.nodes.part_node import PartNode
from hijack_detect.nodes.qos import INTERNAL, OVERRIDES, SENSOR
from hijack_detect.nodes.running import SPIN_S, run
from hijack_detect.streams.cdr import FROM_BYTES, stamp_from_bytes
from hijack_detect.streams.messages import (
    CONVERTERS,
    Absence,
    BadMessage,
    header_stamp_ns,
    satellite_count,
)
from hijack_detect.streams.receiver_clock import REFERENCE, STAMPED
from hijack_detect.streams.satellites import SATELLITES, SatelliteStamps

IMU_TOPIC = "imu/data_raw"
"""Its stamps are the time, see `ReceiverClock`."""
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


def input_of(part: Part, name: str) -> Input:
    """An input of a part: a sensor or an estimator, or for the fusion the verdicts of a detector.

    Raises:
        ValueError: There is no such input.
    """
    if name in INPUTS:
        return INPUTS[name]
    if part.weight is not None:
        raise ValueError(
            f"{part.name}: there is no input '{name}' (there are: {', '.join(INPUTS)})"
        )
    return Input(verdict_topic(name), DiagnosticArray, INTERNAL, verdict_from)


def verdict_topic(detector: str) -> str:
    """Topic of the verdicts of a detector."""
    return f"{detector}/verdict"


TIMED = (*STAMPED, SATELLITES)
"""Inputs of which the time of publication is asked for, where a part counts satellites."""
SWITCH_S = 0.0005
"""A tenth of Python's own: a GPS message waits for this several times until it is received, while
the other thread is busy with IMU messages."""


class Engine:
    """Subscribes once to each input of its parts, runs the monitor, and publishes by its nodes.

    A message is converted once, pushed into the `Monitor` that an offline run has, and every output
    goes to the node of its part. Decisions are made on stamps alone, so they are the same whether a
    process has one part or all of them, and the same as offline.
    """

    def __init__(self, nodes: Sequence[PartNode[Any]]) -> None:
        """Connect nodes; those whose outputs others take come first.

        Raises:
            ValueError: Two of them have an input of one name from different topics.
        """
        self._nodes = {node.part.name: node for node in nodes}
        self._order = {name: -row for row, name in enumerate(self._nodes)}
        self._readers: dict[str, list[PartNode[Any]]] = defaultdict(list)
        for node in nodes:
            for name in node.stage.component.inputs:
                self._readers[name].append(node)
        parameters = MonitorParameters(
            {node.part.name: node.parameters for node in nodes}, tuple(node.part for node in nodes)
        )
        stages = {node.part.name: node.stage for node in nodes}
        self._monitor = Monitor(parameters, stages)
        self._monitor.on_error = self._report_error
        self._inputs = self._outer_inputs()
        self._absence = {name: Absence() for name in self._inputs}
        self._stamps = SatelliteStamps() if SATELLITES in self._inputs else None

    @property
    def _first(self) -> PartNode[Any]:
        """The node that speaks for the process."""
        return next(iter(self._nodes.values()))

    def _outer_inputs(self) -> Mapping[str, Input]:
        """The inputs that no part here puts out."""
        found: dict[str, Input] = {}
        for name, readers in self._readers.items():
            if name in self._nodes:
                continue
            found[name] = given = input_of(readers[0].part, name)
            topics: dict[str, PartNode[Any]] = {}
            for one in readers:
                topics.setdefault(one.resolve_topic_name(given.topic), one)
            if len(topics) > 1:
                both = " and ".join(f"{topic} ({one.get_name()})" for topic, one in topics.items())
                raise ValueError(
                    f"input '{name}' comes from {both}: one process has one topic for it; remap it "
                    "for all nodes, or start that node by itself"
                )
        return found

    def connect(self, executor: Executor | None = None, timed: Node | None = None) -> None:
        """Subscribe.

        An events executor cannot hand out the time of publication, so messages whose time a part
        needs are then received in a thread of their own and passed on to it.

        Args:
            executor: The executor of the nodes, if it hands out no times of publication.
            timed: Receives the messages that need one, if an executor is given.
        """
        for name, given in self._inputs.items():
            node, take = self._readers[name][0], partial(self.take, name)
            if self._stamps is None or name not in TIMED:
                given.subscribe(node, take)
            elif executor is None or timed is None:
                given.subscribe(node, partial(_with_time, take))
            else:
                given.subscribe(timed, partial(_passed_on, executor, take))
        if {*STAMPED} & {*self._inputs} and REFERENCE not in self._inputs:
            self._subscribe_to_time()
        if timed is not None:
            sys.setswitchinterval(SWITCH_S)
            threading.Thread(target=receive, args=(timed,)).start()

    def _subscribe_to_time(self) -> None:
        """Subscribe to the IMU for its stamps alone, see `ReceiverClock`."""
        self._first.create_subscription(
            Imu, IMU_TOPIC, self._take_time, SENSOR, raw=True, qos_overriding_options=OVERRIDES
        )

    def _take_time(self, data: bytes) -> None:
        try:
            stamp_ns = stamp_from_bytes(data)
            if stamp_ns is None:
                stamp_ns = header_stamp_ns(deserialize_message(data, Imu))
        except Exception:  # bytes that are no message: the nodes that use the IMU report it
            return
        self._publish(self._monitor.note_time(stamp_ns))

    def take(self, name: str, received: Any, published_ns: int = 0) -> None:
        """Take a message of an input, or its bytes, and publish all that follows from it.

        Args:
            name: The input.
            received: The message.
            published_ns: Source time of the message, where one is needed.
        """
        sample = self._converted(name, received)
        if sample is None:
            return
        try:
            self._push(name, sample, published_ns)
        except Exception as error:
            if not ok():
                raise
            why, topic = f"internal error: {error!r}", self._inputs[name].topic
            self._readers[name][0].reject(name, lambda: repr(sample), why, topic)

    def _push(self, name: str, sample: Any, published_ns: int) -> None:
        readers = self._readers[name]
        for reader in readers:
            reader.note(name)
        absence = self._absence[name]
        marked = absence(sample)
        for component in absence.names:
            readers[0].lack(component)
        if marked is None:
            return
        if self._stamps is None:
            self._publish(self._monitor.push(name, (marked,)))
            return
        for of, one in self._stamps.samples(name, published_ns, marked):
            self._publish(self._monitor.push(of, (one,)))

    def _converted(self, name: str, received: Any) -> Any:
        """The sample of a message; None, and a report by the first node, if it cannot be used."""
        given = self._inputs[name]
        try:
            return given.sample(received)
        except BadMessage as error:
            why = str(error)
        except Exception as error:  # rclpy raises whatever the bytes lead it to
            why = f"internal error: {error!r}"
        first = self._readers[name][0]
        first.received[name] += 1
        first.reject(name, lambda: f"message{_stamped(given, received)}", why, given.topic)
        return None

    def _publish(self, outputs: Sequence[tuple[str, Any]]) -> None:
        for part, _ in outputs:
            for reader in self._readers.get(part, ()):
                reader.note(part)
        # What decides most goes out first: the alert does not wait for the verdicts behind it.
        for part, output in sorted(outputs, key=lambda one: self._order[one[0]]):
            self._nodes[part].publish(output)
        while self._monitor.clock.findings:
            self._first.log.warning(self._monitor.clock.findings.pop(0))

    def _report_error(
        self, part: str, source: str, samples: Sequence[Any], error: Exception
    ) -> None:
        """Have the node of a part report what went wrong in it."""
        if not ok():
            raise error
        what = repr(samples[0]) if len(samples) == 1 else f"{len(samples)} samples"
        self._nodes[part].reject(source, lambda: what, f"internal error: {error!r}")


def run_part(part: Part, summary: str) -> None:
    """Run the node of a part until it is interrupted; `--help` prints the summary."""

    def make() -> Node:
        node: PartNode[Any] = load(part.face)(part)
        Engine([node]).connect()
        return node

    timed = SATELLITES in input_names(part)
    run(make, summary, SingleThreadedExecutor if timed else EventsExecutor)


def _with_time(take: Any, received: Any, info: Mapping[str, Any]) -> None:
    take(received, info["source_timestamp"])


def _passed_on(executor: Executor, take: Any, received: Any, info: Mapping[str, Any]) -> None:
    executor.create_task(_deliver, take, received, info["source_timestamp"])


def _deliver(take: Any, received: Any, published_ns: int) -> None:
    with _failing_loudly():
        take(received, published_ns)


def receive(timed: Node) -> None:
    """Receive messages with their times of publication until ROS ends."""
    executor = SingleThreadedExecutor()
    executor.add_node(timed)
    with _failing_loudly():
        while ok():
            executor.spin_once(timeout_sec=SPIN_S)
    executor.shutdown()
    timed.destroy_node()


@contextlib.contextmanager
def _failing_loudly() -> Iterator[None]:
    """End the process with exit code 1 at an exception, unless ROS is shutting down.

    Half of a monitor is worse than none, which launch starts again; and the events executor of
    Jazzy crashes when a task raises.
    """
    try:
        yield
    except Exception:
        if ok():
            traceback.print_exc()
            sys.stderr.flush()
            os._exit(1)


def _stamped(given: Input, received: Any) -> str:
    """The stamp of a message in words; empty if it has none or its bytes are no message."""
    try:
        stamp = given.message(received).header.stamp
    except Exception:  # rclpy raises whatever the bytes lead it to
        return ""
    return f" stamped {stamp.sec}.{stamp.nanosec:09d}"
