# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Real nodes in tests: processes over DDS, each test in a domain of its own.

A test asks for the fixture `graph`, starts nodes with it, listens, and spins until a condition
holds. Nothing waits for a fixed time, and every process is ended with the test. What a node
publishes before it knows a listener is lost to that listener, so a test that needs the first
message waits until the node knows all that the test has made::

    def test_something(graph):
        verdicts = graph.listen(DiagnosticArray, "fusion/verdict")
        node = graph.start("fusion", parameters={"policy": "any"})
        graph.until_known("fusion")
        graph.spin_until(lambda: verdicts.messages, "the first verdict")
        assert node.interrupt() == 0

Import it in the conftest.py of the folder: `from ros import graph`.
"""

from __future__ import annotations

import fcntl
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import rclpy
from rcl_interfaces.srv import GetParameters
from rclpy.context import Context
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy

DOMAINS = range(1, 101)
TIMEOUT_S = 60.0
"""Deadline of a wait. A dozen nodes that start at once on two busy cores take half of it."""
QUIET_S = 0.5
"""On a busy machine a process may have to wait for its turn for some tenths of a second."""
KNOCK_S = 0.2
"""A server that does not know its client yet drops the answer, so it is asked again."""
SPIN_S = 0.02
PERIODIC = "/diagnostics"
"""Every node publishes there once a second, so it never becomes quiet."""
READY = "ready"
"""The node that `Graph.be_ready` adds."""
KEEP_ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)
ROOT = Path(__file__).parents[1]

os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(Path(__file__).with_name("fastdds.xml"))
os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)


class RosProcess:
    """One node in a process of its own; what it prints goes to a file."""

    def __init__(
        self,
        module: str,
        arguments: list[str],
        domain: int,
        home: str,
        environment: Mapping[str, str],
    ) -> None:
        self._file = tempfile.TemporaryFile()  # noqa: SIM115, closed by close()
        own = {"ROS_DOMAIN_ID": str(domain), "PYTHONPATH": str(ROOT), "ROS_HOME": home}
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments],
            cwd=ROOT,
            env={**os.environ, **own, **environment},
            stdin=subprocess.DEVNULL,
            stdout=self._file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    @property
    def output(self) -> str:
        """Everything printed so far."""
        return os.pread(self._file.fileno(), 10_000_000, 0).decode(errors="replace")

    @property
    def returncode(self) -> int | None:
        """The exit code, None while it runs."""
        return self._process.poll()

    def wait(self, timeout_s: float = TIMEOUT_S) -> int:
        """Wait for its end and return the exit code."""
        return self._process.wait(timeout_s)

    def wait_for(self, text: str, timeout_s: float = TIMEOUT_S) -> None:
        """Wait until it has printed a text, without handling any message."""
        deadline = time.monotonic() + timeout_s
        while text not in self.output:
            if time.monotonic() > deadline:
                pytest.fail(f"{timeout_s:g} s without {text!r}; printed was:\n{self.output}")
            select.select([], [], [], 0.02)

    def signal(self, number: int) -> None:
        """Send a signal."""
        self._process.send_signal(number)

    def interrupt(self, timeout_s: float = TIMEOUT_S) -> int:
        """Press Ctrl-C and return the exit code, see interrupted."""
        self.signal(signal.SIGINT)
        return self.interrupted(timeout_s)

    def interrupted(self, timeout_s: float = TIMEOUT_S) -> int:
        """Wait for its end after Ctrl-C and return the exit code.

        Whether Fast DDS locked itself up when all was done says nothing of the node: that is 0.
        """
        code = self.wait(timeout_s)
        return 0 if code == -signal.SIGALRM else code

    def close(self) -> None:
        """End it and everything it started."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self._file.close()


class Listener:
    """Keeps every message of a topic, in order; as CDR bytes with `raw`."""

    def __init__(self, node: Node, kind: Any, topic: str, qos: QoSProfile, *, raw: bool) -> None:
        self.messages: list[Any] = []
        node.create_subscription(kind, topic, self.messages.append, qos, raw=raw)


class Graph:
    """The test's own node, and the processes beside it in the same domain."""

    def __init__(self, domain: int) -> None:
        self.domain = domain
        self.home = tempfile.TemporaryDirectory()
        """What the nodes of this graph keep for each other."""
        self.environment: dict[str, str] = {}
        """What is different in the environment of processes that are started from now on."""
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = Node("test", context=self._context, enable_rosout=False)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._processes: list[RosProcess] = []
        self._listeners: list[Listener] = []
        """Of what is not periodic."""
        self._clients: dict[str, Any] = {}
        self._further: list[Node] = []
        self._places: list[tuple[Context, Node]] = []
        self._count, self._count_since, self._idle = -1, 0.0, 0

    def start(
        self, name: str, *ros_arguments: str, parameters: Mapping[str, Any] | None = None
    ) -> RosProcess:
        """Start a node of the package; values of parameters are written as YAML would."""
        arguments = ["--ros-args", *ros_arguments]
        for key, value in (parameters or {}).items():
            text = str(value).lower() if isinstance(value, bool) else str(value)
            arguments += ["-p", f"{key}:={text}"]
        return self.run("hijack_detect.nodes", name, *arguments)

    def run(self, module: str, *arguments: str) -> RosProcess:
        """Run any module, as `python -m` does."""
        home, environment = self.home.name, self.environment
        process = RosProcess(module, list(arguments), self.domain, home, environment)
        self._processes.append(process)
        return process

    def listen(
        self, kind: Any, topic: str, qos: QoSProfile = KEEP_ALL, *, raw: bool = False
    ) -> Listener:
        """Subscribe; by default no message can be lost once the publisher is known."""
        listener = Listener(self.node, kind, topic, qos, raw=raw)
        if topic != PERIODIC:
            self._listeners.append(listener)
        return listener

    def spin_until(
        self, condition: Callable[[], object], what: str, timeout_s: float = TIMEOUT_S
    ) -> None:
        """Handle messages until the condition is true; fail the test at the deadline."""
        deadline = time.monotonic() + timeout_s
        while not condition():
            if time.monotonic() > deadline:
                printed = "\n".join(process.output for process in self._processes)
                pytest.fail(f"{timeout_s:g} s without {what}; the nodes printed:\n{printed}")
            self._executor.spin_once(timeout_sec=SPIN_S)

    def until_known(self, *nodes: str) -> None:
        """Wait until nodes are complete, and know everything that the test has made so far.

        Each answers to a request: it has discovered the requester, and the requester its server.
        Endpoints of a participant are discovered in the order in which they were made, so the node
        knows each older subscription and publisher of the test, too, and its own are all made,
        since it spins. Takes milliseconds, where a wait for /diagnostics takes up to a second.
        """
        for node in nodes:
            client = self.node.create_client(GetParameters, f"{node}/get_parameters")
            answers: list[Any] = []
            asked_s = 0.0

            def known(client: Any = client, answers: list[Any] = answers) -> bool:
                nonlocal asked_s
                if client.service_is_ready() and time.monotonic() - asked_s > KNOCK_S:
                    asked_s = time.monotonic()
                    answers.append(client.call_async(GetParameters.Request()))
                return any(one.done() for one in answers)

            self.spin_until(known, f"an answer of {node}")

    def take_place(self) -> None:
        """Take the participant number, and with it the ports, of a process that was killed.

        The middleware may keep those for unusable, and who is started next would get them.
        """
        context = Context()
        rclpy.init(context=context, domain_id=self.domain)
        self._places.append((context, Node("place", context=context, enable_rosout=False)))

    def be_ready(self) -> None:
        """Add a node to the graph: who was started to wait for READY goes on."""
        self._further.append(Node(READY, context=self._context, enable_rosout=False))

    def subscribers(self, topic: str) -> set[bytes]:
        """Identities of the subscriptions of a topic; a killed node is in the graph for 20 s."""
        found = self.node.get_subscriptions_info_by_topic(self.node.resolve_topic_name(topic))
        return {bytes(one.endpoint_gid) for one in found}

    def until_subscribed(
        self, publisher: Any, count: int = 1, dead: Collection[bytes] = frozenset()
    ) -> None:
        """Wait until a publisher of the test serves subscriptions beside those of killed nodes."""

        def served() -> bool:
            found = self.subscribers(publisher.topic_name)
            known = publisher.get_subscription_count() >= len(found)
            return known and len(found.difference(dead)) >= count

        self.spin_until(served, f"{count} subscriptions of {publisher.topic_name}")

    def spin_to_end(self, process: RosProcess, timeout_s: float = TIMEOUT_S) -> int:
        """Handle messages until a process has ended, and all it sent; return its exit code."""
        self.spin_until(lambda: process.returncode is not None, "the end of a node", timeout_s)
        self.spin_until_quiet()
        return process.wait()

    def spin_until_quiet(self) -> None:
        """Handle messages until no listener has heard anything for a while.

        A node that has not had its turn is quiet, too: wait for what is known to come instead.
        """
        self._count = -1
        self.spin_until(self._quiet, "a quiet moment")

    def _quiet(self) -> bool:
        """Whether nothing has arrived for a while, in which this process had its turns."""
        count = sum(len(listener.messages) for listener in self._listeners)
        if count != self._count:
            self._count, self._count_since, self._idle = count, time.monotonic(), 0
        self._idle += 1
        waited_s = min(time.monotonic() - self._count_since, self._idle * SPIN_S)
        return waited_s > QUIET_S

    def meet(self, kind: Any, name: str) -> Any:
        """Wait until a service and its client know each other, once; give the client.

        A server that has not discovered a client yet drops its response after 100 ms, and has done
        what was asked (rmw_fastrtps).
        """
        if name not in self._clients:
            client = self._clients[name] = self.node.create_client(kind, name)
            self.until_known(name.rpartition("/")[0])
            self.spin_until(client.service_is_ready, f"the service {name}")
        return self._clients[name]

    def call(self, kind: Any, name: str, request: Any = None) -> Any:
        """Call a service and return its response."""
        given = kind.Request() if request is None else request
        future = self.meet(kind, name).call_async(given)
        self.spin_until(future.done, f"an answer of {name}")
        return future.result()

    def close(self) -> None:
        """End everything."""
        for process in self._processes:
            process.close()
        self._executor.shutdown()
        for node in (*self._further, self.node):
            node.destroy_node()
        for context, node in self._places:
            node.destroy_node()
            context.try_shutdown()
        self._context.try_shutdown()
        self.home.cleanup()


@pytest.fixture
def domain() -> Iterator[int]:
    """A ROS domain that no other test on this machine uses, in whatever process it runs."""
    for number in DOMAINS:
        path = Path(tempfile.gettempdir(), f"hijack_detect_test_domain_{number}.lock")
        with path.open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield number
            return
    pytest.fail("every ROS domain for tests is in use")


@pytest.fixture
def graph(domain: int) -> Iterator[Graph]:
    """A graph in a fresh domain."""
    made = Graph(domain)
    yield made
    made.close()
