# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Several nodes in one process, which hand each other samples instead of messages."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import traceback
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.utilities import ok

from hijack_detect.nodes.running import SPIN_S
from hijack_detect.nodes.wiring import Hearer, Input, Source, subscribe
from hijack_detect.streams.receiver_clock import ReceiverClock

SWITCH_S = 0.0005
"""A tenth of Python's own: a GPS message waits for this several times until it is received, while
the other thread is busy with IMU messages."""


class Composition:
    """Wires nodes of one process to each other, and subscribes once to what none of them offers.

    Decisions are made on stamps alone, so they are those of the same nodes as processes. A node
    that offers an output is made before those that have it as an input. All nodes run in the
    thread of one executor. The messages whose time of publication a node must know are received
    in a thread of their own, since an events executor cannot hand that out, and passed on to it.
    """

    def __init__(self, executor: Executor, rate_hz: float | None) -> None:
        """Start without nodes.

        Args:
            executor: Runs the nodes.
            rate_hz: Largest rate of an intermediate topic, Hz; None publishes every output.
        """
        self.rate_hz = rate_hz
        self._executor = executor
        self._offered: dict[str, list[tuple[Hearer, str]]] = {}
        self._sources: dict[str, Source] = {}
        self._clock = ReceiverClock()

    def offer(self, topic: str) -> None:
        """See Wiring."""
        self._offered[topic] = []

    def listen(self, hearer: Hearer, name: str, given: Input) -> None:
        """See Wiring."""
        topic = hearer.node.resolve_topic_name(given.topic)
        if topic in self._offered:
            self._offered[topic].append((hearer, name))
        elif topic in self._sources:
            self._sources[topic].hearers.append((hearer, name))
        else:
            self._sources[topic] = Source(hearer, name, given, self._clock)

    def hear_time(self, hearer: Hearer) -> None:
        """See Wiring; the attitude estimator hears the IMU for all."""

    def hand_over(self, topic: str, outputs: Sequence[Any], passed_ns: int) -> None:
        """See Wiring."""
        for hearer, name in self._offered[topic]:
            hearer.take_over(name, outputs, passed_ns)

    def connect(self, timed: Node) -> None:
        """Subscribe to what the nodes hear from outside, once all of them are made.

        Args:
            timed: Node that receives the messages whose time of publication is asked for.
        """
        for source in self._sources.values():
            if source.timed:
                subscribe(timed, source.given, self._passed_on(source))
            else:
                subscribe(source.hearers[0][0].node, source.given, source.hear)
        sys.setswitchinterval(SWITCH_S)
        threading.Thread(target=self._receive, args=(timed,)).start()

    def _passed_on(self, source: Source) -> Any:
        def heard(message: Any, info: Mapping[str, Any]) -> None:
            self._executor.create_task(deliver, message, info["source_timestamp"])

        def deliver(message: Any, published_ns: int) -> None:
            with _failing_loudly():
                source.hear(message, published_ns)

        return heard

    def _receive(self, timed: Node) -> None:
        """Receive messages with their times until ROS ends."""
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
