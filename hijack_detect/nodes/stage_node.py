# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What every node of the monitor shares: parameters, inputs, one stage, diagnostics."""

from __future__ import annotations

import contextlib
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, Generic, TypeVar

from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.msg import SetParametersResult
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.utilities import ok

from hijack_detect.monitor.graph import component_of, input_names
from hijack_detect.monitor.parts import PARTS, Part, load
from hijack_detect.monitor.stage import Stage
from hijack_detect.nodes.diagnostics import Diagnostics
from hijack_detect.nodes.parameters import current, declare, naming, own_changes
from hijack_detect.nodes.running import run
from hijack_detect.nodes.wiring import SATELLITES, Input, Topics, Wiring
from hijack_detect.parameters import ParameterError, Parameters
from hijack_detect.streams.messages import BadMessage
from hijack_detect.streams.receiver_clock import REFERENCE, STAMPED

P = TypeVar("P", bound=Parameters)

LOG_EVERY_S = 10.0
"""Bad messages of one input are logged this often; all are counted."""


class StageNode(Node, Generic[P]):
    """A node that feeds messages to one stage and publishes what comes out.

    A message that cannot be used is counted, told in the log, and reported on /diagnostics;
    it never ends the node. Reliability, durability, history and depth of each subscription can be
    changed with the standard `qos_overrides` parameters. Subclasses implement `publish_output`.
    """

    NEEDS_SOURCE_TIMES = False
    """Whether `samples` is told when each message was published. The events executor of Jazzy
    cannot hand that out."""

    def __init__(
        self,
        part: Part,
        inputs: Mapping[str, Input] | Callable[[P], Mapping[str, Input]],
        wiring: Wiring,
        *,
        output: str = "",
        read_only: bool = False,
    ) -> None:
        """Declare parameters and subscribe.

        Args:
            part: Row of the estimator, detector or fusion.
            inputs: Subscription of each input; the component says which inputs it has. Or what
                gives them for the parameters.
            wiring: What the inputs come from, and where the outputs go.
            output: Topic under which other nodes have the outputs as an input, if any does.
            read_only: Whether parameters cannot change while it runs. Otherwise a change makes
                the component afresh, and it is NOT_READY until its windows are full again.

        Raises:
            ParameterError: A parameter is unknown or out of bounds.
        """
        super().__init__(part.node, automatically_declare_parameters_from_overrides=True)
        self._kind: type[P] = part.parameters  # type: ignore[assignment]  # as the subclass says
        with naming(part.node):
            self._settings = declare(self, self._kind, read_only=read_only)
            inputs = inputs(self._settings) if callable(inputs) else inputs
        self.stage = Stage(lambda: component_of(part, self._settings))
        self.rejected: Counter[str] = Counter()
        self._received: Counter[str] = Counter()
        self._newest_s: dict[str, float] = dict.fromkeys(inputs, time.monotonic())
        self._told: Counter[str] = Counter()
        self._restarts = 0
        self._lacking: set[str] = set()
        self._logged_at: dict[str, float] = {}
        self.add_on_set_parameters_callback(self._check_change)
        self.add_post_set_parameters_callback(self._apply_change)
        self._topics = {name: given.topic for name, given in inputs.items()}
        self._wiring, self._passed_ns = wiring, 0
        self._output = self.resolve_topic_name(output) if output else ""
        if self._output:
            wiring.offer(self._output)
        for input_name, given in inputs.items():
            wiring.listen(self, input_name, given)
        if {*STAMPED} & {*inputs} and REFERENCE not in inputs:
            wiring.hear_time(self)
        self.diagnostics = Diagnostics(self)
        self.create_timer(1.0, self._report)

    @property
    def parameters(self) -> P:
        """The parameters in force."""
        return self._settings

    @property
    def log(self) -> RcutilsLogger:
        """The node's logger."""
        logger: RcutilsLogger = Node.get_logger(self)
        return logger

    def publish_output(self, output: Any) -> None:
        """Publish one output of the stage."""
        raise NotImplementedError

    def samples(self, name: str, converted: Any, published_ns: int) -> list[tuple[str, Any]]:
        """What a converted message of an input brings: input names and samples, in order.

        Args:
            name: The input.
            converted: What its converter made of the message.
            published_ns: Source time of the message where NEEDS_SOURCE_TIMES, else 0.
        """
        return [(name, converted)]

    def silent(self, seconds: float) -> list[str]:
        """Inputs from which nothing has come for so long, by a clock that nobody sets."""
        now_s = time.monotonic()
        return [name for name, newest_s in self._newest_s.items() if now_s - newest_s > seconds]

    def ended(self) -> None:
        """The process was asked to end: nothing that should survive a crash survives that."""

    @property
    def node(self) -> Node:
        """The node itself."""
        return self

    def read(self, name: str, given: Input, heard: Any) -> Any:
        """What a message was converted to; None if it cannot be used, which has been told then."""
        try:
            return given.sample(heard)
        except BadMessage as error:
            why = str(error)
        except Exception as error:  # rclpy raises whatever the bytes lead it to
            why = f"internal error: {error!r}"
        self._received[name] += 1
        self._reject(name, lambda: f"message{_stamped(given, heard)}", why)
        return None

    def lacks(self, component: str) -> None:
        """Say once that a component of an input is not measured, and from then on /diagnostics."""
        if component not in self._lacking:
            self._lacking.add(component)
            self.log.info(f"the {component} is not measured: it is not used")

    def take(self, name: str, converted: Any, published_ns: int) -> None:
        """Take what a message of an input was converted to."""
        self._received[name] += 1
        self._newest_s[name] = time.monotonic()
        outputs: list[Any] = []
        with self._outliving(name, lambda: repr(converted)):
            for source, one in self.samples(name, converted, published_ns):
                outputs += self.stage.push(source, one)
        self._give(name, outputs)

    def take_over(self, name: str, outputs: Sequence[Any], passed_ns: int) -> None:
        """Take another node's outputs as an input, which brings nothing more up to a stamp."""
        if outputs:
            self._received[name] += len(outputs)
            self._newest_s[name] = time.monotonic()
        own: list[Any] = []
        with self._outliving(name, lambda: f"{len(outputs)} samples up to {passed_ns} ns"):
            own += self.stage.push_all(name, outputs)
            own += self.stage.advance(name, passed_ns)
        self._give(name, own)

    @contextlib.contextmanager
    def _outliving(self, name: str, what: Callable[[], str]) -> Iterator[None]:
        """A safety monitor outlives its own mistakes, and says so."""
        try:
            yield
        except Exception as error:
            if not ok():  # publishing while ROS shuts down is no mistake
                raise
            self._reject(name, what, f"internal error: {error!r}")

    def _give(self, name: str, outputs: Sequence[Any]) -> None:
        """Publish what followed from an input, and give it to the nodes that hear this one."""
        for output in outputs:
            with self._outliving(name, partial(repr, output)):
                self.publish_output(output)
        passed_ns = self.stage.passed_ns
        if self._output and (outputs or passed_ns > self._passed_ns):
            self._passed_ns = passed_ns
            self._wiring.hand_over(self._output, outputs, passed_ns)

    def _reject(self, name: str, what: Callable[[], str], why: str) -> None:
        """Count a message that cannot be used, and tell of it now and then."""
        self.rejected[f"{name}: bad message"] += 1
        now = time.monotonic()
        if now - self._logged_at.get(name, -LOG_EVERY_S) >= LOG_EVERY_S:
            self._logged_at[name] = now
            topic = self.resolve_topic_name(self._topics[name])
            self.log.warning(f"{topic}: {what()} left out: {why}")

    def _check_change(self, changes: list[Parameter]) -> SetParametersResult:
        try:
            current(self, self._kind, own_changes(self._kind, changes))
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _apply_change(self, changes: list[Parameter]) -> None:
        own = own_changes(self._kind, changes)
        if own:
            self._settings = current(self, self._kind, own)
            self.stage.restart()
            self.log.info(f"started afresh with {own}")

    def _report(self) -> None:
        """Publish what was received and what was left out, once a second."""
        refused = self.rejected + self.stage.refused
        new = refused - self._told
        for reason in new.keys() - self._told.keys():
            self.log.warning(f"left out: {reason}")
        self._told = refused
        if self.stage.restarts > self._restarts:
            self.log.warning("a clock ran backwards: everything before that is forgotten")
        self._restarts = self.stage.restarts
        text = "; ".join(f"{reason} ({count})" for reason, count in new.items())
        values = {f"received {name}": str(count) for name, count in self._received.items()}
        values |= {f"left out, {reason}": str(count) for reason, count in refused.items()}
        values |= {f"{component}": "not measured" for component in sorted(self._lacking)}
        values["restarts"] = str(self.stage.restarts)
        level = DiagnosticStatus.WARN if new else DiagnosticStatus.OK
        self.diagnostics.tell("inputs", level, text or "all messages used", values)


def row_of(node: str) -> Part:
    """The row of a node of the registry."""
    return next(part for part in PARTS if part.node == node)


def run_part(part: Part, summary: str) -> None:
    """Run the node of a part until it is interrupted; `--help` prints the summary."""
    timed = SATELLITES in input_names(part)
    executor = SingleThreadedExecutor if timed else EventsExecutor
    run(lambda: load(part.face)(part, Topics()), summary, executor)


def _stamped(given: Input, heard: Any) -> str:
    """The stamp of a message in words; empty if it has none or its bytes are no message."""
    try:
        stamp = given.message(heard).header.stamp
    except Exception:  # rclpy raises whatever the bytes lead it to
        return ""
    return f" stamped {stamp.sec}.{stamp.nanosec:09d}"
