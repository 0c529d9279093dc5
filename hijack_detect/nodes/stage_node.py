"""What every node of the monitor shares: parameters, inputs, one stage, diagnostics."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.msg import SetParametersResult
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message

from hijack_detect.evaluation.monitor.stage import Component, Stage
from hijack_detect.nodes.diagnostics import Diagnostics
from hijack_detect.nodes.parameters import current, declare, own_changes
from hijack_detect.nodes.qos import OVERRIDES
from hijack_detect.parameters import ParameterError, Parameters
from hijack_detect.streams.imu_bytes import FROM_BYTES
from hijack_detect.streams.messages import CONVERTERS, BadMessage

P = TypeVar("P", bound=Parameters)

LOG_EVERY_S = 10.0
"""Bad messages of one input are logged this often; all are counted."""


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
        name: str,
        parameters: type[P],
        make: Callable[[P], Component],
        inputs: Mapping[str, Input],
        *,
        read_only: bool = False,
    ) -> None:
        """Declare parameters and subscribe.

        Args:
            name: Name of the node.
            parameters: Parameter dataclass.
            make: Makes the estimator or detector from its parameters.
            inputs: Subscription of each input; the component says which inputs it has.
            read_only: Whether parameters cannot change while it runs. Otherwise a change makes
                the component afresh, and it is NOT_READY until its windows are full again.

        Raises:
            ParameterError: A parameter is unknown or out of bounds.
        """
        super().__init__(name, automatically_declare_parameters_from_overrides=True)
        self._kind, self._make_component = parameters, make
        try:
            self._settings = declare(self, parameters, read_only=read_only)
        except ParameterError as error:
            raise ParameterError(f"{name}: {error}") from error
        self.stage = Stage(lambda: self._make_component(self._settings))
        self.rejected: Counter[str] = Counter()
        self._received: Counter[str] = Counter()
        self._told: Counter[str] = Counter()
        self._logged_at: dict[str, float] = {}
        self.add_on_set_parameters_callback(self._check_change)
        self.add_post_set_parameters_callback(self._apply_change)
        for input_name, given in inputs.items():
            self.create_subscription(
                given.message_type,
                given.topic,
                self._callback(input_name, given),
                given.qos,
                raw=given.from_bytes is not None,
                qos_overriding_options=OVERRIDES,
            )
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

    def _callback(self, name: str, given: Input) -> Callable[..., None]:
        def received(heard: Any) -> None:
            self._take(name, given, heard, 0)

        def received_with_time(heard: Any, info: Mapping[str, Any]) -> None:
            self._take(name, given, heard, info["source_timestamp"])

        return received_with_time if self.NEEDS_SOURCE_TIMES else received

    def _take(self, name: str, given: Input, heard: Any, published_ns: int) -> None:
        self._received[name] += 1
        outputs: list[Any] = []
        try:
            for source, sample in self.samples(name, given.sample(heard), published_ns):
                outputs += self.stage.push(source, sample)
        except BadMessage as error:
            self._reject(name, given, heard, str(error))
        except Exception as error:  # a safety monitor outlives its own mistakes, and says so
            self._reject(name, given, heard, f"internal error: {error!r}")
        for output in outputs:
            self.publish_output(output)

    def _reject(self, name: str, given: Input, heard: Any, why: str) -> None:
        self.rejected[f"{name}: bad message"] += 1
        now = time.monotonic()
        if now - self._logged_at.get(name, -LOG_EVERY_S) < LOG_EVERY_S:
            return
        self._logged_at[name] = now
        told = f"message{_stamped(given, heard)} left out: {why}"
        self.log.warning(f"{self.resolve_topic_name(given.topic)}: {told}")

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
        text = "; ".join(f"{reason} ({count})" for reason, count in new.items())
        values = {f"received {name}": str(count) for name, count in self._received.items()}
        values |= {f"left out, {reason}": str(count) for reason, count in refused.items()}
        values["restarts"] = str(self.stage.restarts)
        level = DiagnosticStatus.WARN if new else DiagnosticStatus.OK
        self.diagnostics.tell("inputs", level, text or "all messages used", values)


def _stamped(given: Input, heard: Any) -> str:
    """The stamp of a message in words; empty if it has none or its bytes are no message."""
    try:
        stamp = given.message(heard).header.stamp
    except Exception:  # rclpy raises whatever the bytes lead it to
        return ""
    return f" stamped {stamp.sec}.{stamp.nanosec:09d}"
