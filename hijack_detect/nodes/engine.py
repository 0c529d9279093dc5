# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One process of the monitor: subscriptions, the monitor itself, and the nodes of its parts."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import traceback
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.utilities import ok
from sensor_msgs.msg import Imu

from hijack_detect.monitor.graph import Monitor, MonitorParameters, input_names
from hijack_detect.monitor.parts import Part, load
from hijack_detect.nodes.part_node import IMU_TOPIC, Input, PartNode
from hijack_detect.nodes.qos import OVERRIDES, SENSOR
from hijack_detect.nodes.running import SPIN_S, run
from hijack_detect.streams.absence import Absence
from hijack_detect.streams.cdr import stamp_from_bytes
from hijack_detect.streams.messages import header_stamp_ns
from hijack_detect.streams.receiver_clock import REFERENCE, STAMPED
from hijack_detect.streams.satellites import SATELLITES, SatelliteStamps

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
        self._readers: dict[str, list[PartNode[Any]]] = defaultdict(list)
        for node in nodes:
            for name in node.inputs:
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

    def _outer_inputs(self) -> Mapping[str, Input]:
        """The inputs that no part here puts out."""
        found: dict[str, Input] = {}
        for name, readers in self._readers.items():
            if name in self._nodes:
                continue
            found[name] = readers[0].inputs[name]
            topics = {one.resolve_topic_name(one.inputs[name].topic): one for one in readers}
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
        node = next(iter(self._nodes.values()))
        node.create_subscription(
            Imu, IMU_TOPIC, self._take_time, SENSOR, raw=True, qos_overriding_options=OVERRIDES
        )

    def _take_time(self, data: bytes) -> None:
        stamp_ns = stamp_from_bytes(data)
        if stamp_ns is None:
            stamp_ns = header_stamp_ns(deserialize_message(data, Imu))
        self._publish(self._monitor.note_time(stamp_ns))

    def take(self, name: str, received: Any, published_ns: int = 0) -> None:
        """Take a message of an input, or its bytes, and publish all that follows from it.

        Args:
            name: The input.
            received: The message.
            published_ns: Source time of the message, where one is needed.
        """
        readers = self._readers[name]
        sample = readers[0].converted(name, received)
        if sample is None:
            return
        absence = self._absence[name]
        marked = absence(sample)
        for component in absence.names:
            readers[0].lack(component)
        for reader in readers:
            reader.note(name)
        if marked is None:
            return
        if self._stamps is None:
            self._publish(self._monitor.push(name, (marked,)))
            return
        for of, one in self._stamps.samples(name, published_ns, marked):
            self._publish(self._monitor.push(of, (one,)))

    def _publish(self, outputs: Sequence[tuple[str, Any]]) -> None:
        for part, output in outputs:
            for reader in self._readers.get(part, ()):
                reader.note(part)
            self._nodes[part].publish(output)
        while self._monitor.clock.said:
            first = next(iter(self._nodes.values()))
            first.log.warning(self._monitor.clock.said.pop(0))

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
