# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attacks the GPS on its way from a receiver to its users: the attack simulator on a live stream.

Subscribes gps/fix_in, gps/vel_in (ENU) and gps/satellites_in. Publishes gps/fix, gps/vel and
gps/satellites, as they came but for what the attack forges; spoof_active (Bool, latched) with every
fix: whether an attack covers it; ~/offset (Float64, metres) with every fix; and /diagnostics.

The parameter mode selects the attack: none, soft, hard (Basan 2022, section 3.1), model, scenario.
It and what describes the attack can change at any time, several at once with
set_parameters_atomically; an attack begins with the next fix.

The outputs are reliable and remembered: a subscriber that asks for it (config/acknowledged.yaml) is
sent everything again that it has missed, also after a restart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import TwistStamped
from rcl_interfaces.msg import SetParametersResult
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import NavSatFix
from std_msgs.msg import Bool, Float64, UInt32

from hijack_detect.bags.topics import OWN_TOPICS
from hijack_detect.nodes.diagnostics import Diagnostics
from hijack_detect.nodes.parameters import current, declare, naming, own_changes
from hijack_detect.nodes.qos import INTERNAL, OVERRIDES, SENSOR, STATE, remembered
from hijack_detect.nodes.running import run
from hijack_detect.spoofing.live import USED, LiveSpoofer, SpooferParameters, chosen_attack
from hijack_detect.spoofing.on_messages import SPOOFED_INPUTS, SpoofedMessages
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.streams.messages import BadMessage

TYPES = {"fix": NavSatFix, "velocity": TwistStamped, "satellites": UInt32}
NOW = Duration(nanoseconds=0)


class GpsSpoofer(Node):
    """Passes messages through a `LiveSpoofer`, each as soon as it arrives."""

    def __init__(self) -> None:
        """Subscribe and advertise.

        Raises:
            ValueError: A parameter or the scenario is refused.
        """
        super().__init__("gps_spoofer", automatically_declare_parameters_from_overrides=True)
        with naming("gps_spoofer"):
            self._settings = declare(self, SpooferParameters, read_only=False)
            self._live = LiveSpoofer(chosen_attack(self._settings))
        self._messages = SpoofedMessages(self._live)
        self._checked: tuple[SpooferParameters, Scenario] | None = None
        self._counts: Counter[str] = Counter()
        self._refused: Counter[str] = Counter()
        self._onset_ns: int | None = None
        self._truth = self.create_publisher(Bool, "spoof_active", STATE)
        self._offset = self.create_publisher(Float64, "~/offset", INTERNAL)
        self._diagnostics = Diagnostics(self)
        qos = remembered(self._settings.keep)
        self._outputs = {
            name: self.create_publisher(TYPES[name], OWN_TOPICS[name], qos)
            for name in SPOOFED_INPUTS
        }
        for name in SPOOFED_INPUTS:
            self.create_subscription(
                TYPES[name],
                f"{OWN_TOPICS[name]}_in",
                self._callback(name),
                SENSOR,
                qos_overriding_options=OVERRIDES,
            )
        self.add_on_set_parameters_callback(self._check_change)
        self.add_post_set_parameters_callback(self._apply_change)
        self.create_timer(1.0, self._report)
        self.get_logger().info(f"mode {self._settings.mode}")

    def _callback(self, name: str) -> Callable[[Any], None]:
        return lambda message: self._received(name, message)

    def _received(self, name: str, message: Any) -> None:
        """Publish a message as the attack reports it."""
        try:
            forged = self._messages.apply(name, message)
        except BadMessage as error:
            forged = False
            self._refuse(name, str(error))
        self._counts[f"{'forged' if forged else 'passed'} {name}"] += 1
        if name == "fix":
            self._tell_truth(message, forged)
        self._outputs[name].publish(message)

    def _tell_truth(self, fix: NavSatFix, forged: bool) -> None:
        """Publish the ground truth of a fix, and log when an attack begins or ends."""
        stamp_ns = self._messages.stamp_ns("fix", fix)
        self._truth.publish(Bool(data=stamp_ns is not None and self._live.active(stamp_ns)))
        self._offset.publish(Float64(data=self._live.offset_m if forged else 0.0))
        before, self._onset_ns = self._onset_ns, self._live.onset_ns
        if self._onset_ns != before:
            what = "ended" if self._onset_ns is None else f"began at {self._onset_ns} ns"
            self.get_logger().warning(f"mode {self._settings.mode}: attack {what}")

    def _refuse(self, name: str, why: str) -> None:
        """Count a message that could not be read; log the first of each input."""
        self._refused[name] += 1
        if self._refused[name] == 1:
            topic = self.resolve_topic_name(f"{OWN_TOPICS[name]}_in")
            self.get_logger().warning(f"{topic}: passed on as it is: {why} (told once)")

    def _check_change(self, changes: list[Parameter]) -> SetParametersResult:
        own = own_changes(SpooferParameters, changes)
        try:
            settings = current(self, SpooferParameters, own)
            self._checked = (settings, chosen_attack(settings, own))
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _apply_change(self, changes: list[Parameter]) -> None:
        """Begin the attack that was checked, unless it is not of the mode that was changed."""
        own = own_changes(SpooferParameters, changes)
        if not own or self._checked is None:
            return
        self._settings, attack = self._checked
        if "mode" in own or own.keys() & USED[self._settings.mode]:
            self._live.set(attack)
            self.get_logger().info(f"mode {self._settings.mode} from the next fix on, set by {own}")

    def _report(self) -> None:
        """Publish mode and counts on /diagnostics, once a second."""
        waiting = [
            OWN_TOPICS[name]
            for name, output in self._outputs.items()
            if not output.wait_for_all_acked(NOW)
        ]
        values = {
            "mode": self._settings.mode,
            "onset_ns": "" if self._onset_ns is None else str(self._onset_ns),
            "times count from_ns": "" if self._live.start_ns is None else str(self._live.start_ns),
            **{f"{what} {name}": "0" for what in ("passed", "forged") for name in SPOOFED_INPUTS},
            **{key: str(count) for key, count in self._counts.items()},
            **{f"refused {name}": str(self._refused[name]) for name in SPOOFED_INPUTS},
            "restarts": str(self._live.restarts),
            "unacknowledged": " ".join(waiting),
        }
        level = DiagnosticStatus.OK if self._onset_ns is None else DiagnosticStatus.WARN
        text = "GPS passes as it is" if self._onset_ns is None else "GPS is being forged"
        self._diagnostics.report("spoofer", level, text, values)


def main() -> None:
    """Run the node."""
    run(GpsSpoofer, __doc__ or "")


if __name__ == "__main__":
    main()
