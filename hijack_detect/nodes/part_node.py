# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What every node of the monitor shares: parameters, outputs and diagnostics of one part."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.msg import SetParametersResult
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.utilities import ok

from hijack_detect.monitor.graph import Stage, component_of
from hijack_detect.monitor.parts import Part
from hijack_detect.nodes.diagnostics import Diagnostics
from hijack_detect.nodes.parameters import current, declare, naming, own_changes
from hijack_detect.nodes.qos import INTERNAL
from hijack_detect.parameters import ParameterError, Parameters
from hijack_detect.streams.samples import NANOSECONDS


class Outlet:
    """Publishes on an intermediate topic while somebody listens, and no faster than at a rate.

    The rate goes by stamps: the first output in each period is published, and each that `change`
    marks as news.
    """

    def __init__(self, node: Node, kind: Any, topic: str, rate_hz: float | None) -> None:
        """Advertise.

        Args:
            node: The node.
            kind: Type of the messages.
            topic: The topic.
            rate_hz: Largest rate, Hz; None publishes every output.
        """
        self._publisher: Any = node.create_publisher(kind, topic, INTERNAL)
        self._period_ns = 0 if rate_hz is None else round(NANOSECONDS / rate_hz)
        self._last: int | None = None

    def publish(self, stamp_ns: int, make: Callable[[], Any], *, change: bool = False) -> None:
        """Publish the message of an output, if it is wanted.

        Args:
            stamp_ns: Stamp of the output, nanoseconds.
            make: Makes the message.
            change: Whether it is a change, which is not left out for the rate.
        """
        if not self._publisher.get_subscription_count():
            return
        if self._period_ns:
            period = stamp_ns // self._period_ns
            if period == self._last and not change:
                return
            self._last = period
        self._publisher.publish(make())


P = TypeVar("P", bound=Parameters)

LOG_EVERY_S = 10.0
"""Bad messages of one input are logged this often; all are counted. Chosen, not swept."""


class PartNode(Node, Generic[P]):
    """The node of a part: its parameters, what it publishes, its services and diagnostics.

    An `Engine` subscribes for it, runs its stage, and hands it each output. A message that cannot
    be used is counted, logged, and reported on /diagnostics; it never ends the node. Reliability,
    durability, history and depth of each subscription can be changed with the standard
    `qos_overrides` parameters. Subclasses implement `publish_output`.
    """

    def __init__(
        self,
        part: Part,
        rate_hz: float | None = None,
        *,
        read_only: bool = False,
    ) -> None:
        """Declare parameters.

        Args:
            part: Row of the estimator, detector or fusion.
            rate_hz: Largest rate of an intermediate topic, Hz; None publishes every output.
            read_only: Whether parameters cannot change while it runs. Otherwise a change makes
                the component again, and it is NOT_READY until its windows are full again.

        Raises:
            ParameterError: A parameter is unknown or out of bounds.
        """
        super().__init__(part.node, automatically_declare_parameters_from_overrides=True)
        self.part, self._rate_hz = part, rate_hz
        self._kind: type[P] = part.parameters  # type: ignore[assignment]  # as the subclass says
        with naming(part.node):
            self._settings = declare(self, self._kind, read_only=read_only)
        self.stage = Stage(lambda: component_of(part, self._settings))
        self.rejected: Counter[str] = Counter()
        self.received: Counter[str] = Counter()
        self._newest_s: dict[str, float] = dict.fromkeys(
            self.stage.component.inputs, time.monotonic()
        )
        self._reported: Counter[str] = Counter()
        self._restarts = 0
        self._lacking: set[str] = set()
        self._logged_at: dict[str, float] = {}
        self.add_on_set_parameters_callback(self._check_change)
        self.add_post_set_parameters_callback(self._apply_change)
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

    def outlet(self, kind: Any, topic: str) -> Outlet:
        """Advertise an intermediate topic, at the rate of this node; see Outlet."""
        return Outlet(self, kind, topic, self._rate_hz)

    def publish_output(self, output: Any) -> None:
        """Publish one output of the stage."""
        raise NotImplementedError

    def publish(self, output: Any) -> None:
        """Publish one output of the stage; an internal error is reported and the node goes on."""
        try:
            self.publish_output(output)
        except Exception as error:
            if not ok():  # publishing while ROS shuts down is no mistake
                raise
            self.reject(self.part.name, lambda: repr(output), f"internal error: {error!r}")

    def silent(self, seconds: float) -> list[str]:
        """Inputs from which nothing has come for so long, by a clock that nobody sets."""
        now_s = time.monotonic()
        return [name for name, newest_s in self._newest_s.items() if now_s - newest_s > seconds]

    def ended(self) -> None:
        """The process was asked to end: nothing that should survive a crash survives that."""

    def lack(self, component: str) -> None:
        """Report that a component of an input is not measured: once, then on /diagnostics."""
        if component not in self._lacking:
            self._lacking.add(component)
            self.log.info(f"the {component} is not measured: it is not used")

    def note(self, name: str) -> None:
        """Count a sample of an input."""
        self.received[name] += 1
        self._newest_s[name] = time.monotonic()

    def reject(self, name: str, what: Callable[[], str], why: str, topic: str = "") -> None:
        """Count a message of an input that cannot be used, and log it now and then."""
        self.rejected[f"{name}: bad message"] += 1
        now = time.monotonic()
        if now - self._logged_at.get(name, -LOG_EVERY_S) >= LOG_EVERY_S:
            self._logged_at[name] = now
            place = self.resolve_topic_name(topic) if topic else name
            self.log.warning(f"{place}: {what()} left out: {why}")

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
        new = refused - self._reported
        for reason in new.keys() - self._reported.keys():
            self.log.warning(f"left out: {reason}")
        self._reported = refused
        if self.stage.restarts > self._restarts:
            self.log.warning("a clock ran backwards: everything before that is forgotten")
        self._restarts = self.stage.restarts
        text = "; ".join(f"{reason} ({count})" for reason, count in new.items())
        values = {f"received {name}": str(count) for name, count in self.received.items()}
        values |= {f"left out, {reason}": str(count) for reason, count in refused.items()}
        values |= {f"{component}": "not measured" for component in sorted(self._lacking)}
        values["restarts"] = str(self.stage.restarts)
        level = DiagnosticStatus.WARN if new else DiagnosticStatus.OK
        self.diagnostics.report("inputs", level, text or "all messages used", values)
