# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What every node of the monitor shares: parameters, outputs and diagnostics of one part."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import QuaternionStamped, TwistStamped
from rcl_interfaces.msg import SetParametersResult
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rclpy.utilities import ok
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, NavSatFix
from std_msgs.msg import UInt32

from hijack_detect.monitor.graph import Stage, component_of, input_names
from hijack_detect.monitor.parts import Part
from hijack_detect.monitor.verdict_messages import verdict_from
from hijack_detect.nodes.diagnostics import Diagnostics
from hijack_detect.nodes.parameters import current, declare, naming, own_changes
from hijack_detect.nodes.qos import INTERNAL, OVERRIDES, SENSOR
from hijack_detect.parameters import ParameterError, Parameters
from hijack_detect.streams.cdr import FROM_BYTES
from hijack_detect.streams.messages import CONVERTERS, BadMessage, satellite_count
from hijack_detect.streams.samples import NANOSECONDS
from hijack_detect.streams.satellites import SATELLITES


class Outlet:
    """Publishes on an intermediate topic while somebody listens, and no faster than at a rate.

    The rate goes by stamps: the first output in each period is published, and each that `change`
    says is news.
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
            change: Whether it says something new, which is not left out for the rate.
        """
        if not self._publisher.get_subscription_count():
            return
        if self._period_ns:
            period = stamp_ns // self._period_ns
            if period == self._last and not change:
                return
            self._last = period
        self._publisher.publish(make())


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


P = TypeVar("P", bound=Parameters)

LOG_EVERY_S = 10.0
"""Bad messages of one input are logged this often; all are counted."""


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
        inputs: Callable[[P], Mapping[str, Input]] | None = None,
        read_only: bool = False,
    ) -> None:
        """Declare parameters.

        Args:
            part: Row of the estimator, detector or fusion.
            rate_hz: Largest rate of an intermediate topic, Hz; None publishes every output.
            inputs: Makes the inputs from the parameters; None takes those of the row.
            read_only: Whether parameters cannot change while it runs. Otherwise a change makes
                the component anew, and it is NOT_READY until its windows are full again.

        Raises:
            ParameterError: A parameter is unknown or out of bounds.
            ValueError: It has an input that there is not.
        """
        super().__init__(part.node, automatically_declare_parameters_from_overrides=True)
        self.part, self.rate_hz = part, rate_hz
        self._kind: type[P] = part.parameters  # type: ignore[assignment]  # as the subclass says
        with naming(part.node):
            self._settings = declare(self, self._kind, read_only=read_only)
            self.inputs = inputs_of(part) if inputs is None else inputs(self._settings)
        self.stage = Stage(lambda: component_of(part, self._settings))
        self.rejected: Counter[str] = Counter()
        self._received: Counter[str] = Counter()
        self._newest_s: dict[str, float] = dict.fromkeys(self.inputs, time.monotonic())
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

    def converted(self, name: str, received: Any) -> Any:
        """Convert a message of an input; None, and a report, if it cannot be used."""
        given = self.inputs[name]
        try:
            return given.sample(received)
        except BadMessage as error:
            why = str(error)
        except Exception as error:  # rclpy raises whatever the bytes lead it to
            why = f"internal error: {error!r}"
        self._received[name] += 1
        self.reject(name, lambda: f"message{_stamped(given, received)}", why)
        return None

    def lack(self, component: str) -> None:
        """Report that a component of an input is not measured: once, then on /diagnostics."""
        if component not in self._lacking:
            self._lacking.add(component)
            self.log.info(f"the {component} is not measured: it is not used")

    def note(self, name: str) -> None:
        """Count a sample of an input."""
        self._received[name] += 1
        self._newest_s[name] = time.monotonic()

    def reject(self, name: str, what: Callable[[], str], why: str) -> None:
        """Count a message that cannot be used, and log it now and then."""
        self.rejected[f"{name}: bad message"] += 1
        now = time.monotonic()
        if now - self._logged_at.get(name, -LOG_EVERY_S) >= LOG_EVERY_S:
            self._logged_at[name] = now
            topic = name
            if name in self.inputs:
                topic = self.resolve_topic_name(self.inputs[name].topic)
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
        new = refused - self._reported
        for reason in new.keys() - self._reported.keys():
            self.log.warning(f"left out: {reason}")
        self._reported = refused
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


def _stamped(given: Input, received: Any) -> str:
    """The stamp of a message in words; empty if it has none or its bytes are no message."""
    try:
        stamp = given.message(received).header.stamp
    except Exception:  # rclpy raises whatever the bytes lead it to
        return ""
    return f" stamped {stamp.sec}.{stamp.nanosec:09d}"
