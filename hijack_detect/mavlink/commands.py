# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command of an alert: which it is, whether it was taken, and saying so."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from types import ModuleType

from hijack_detect.contract import Level, Log
from hijack_detect.mavlink.parameters import BridgeParameters
from hijack_detect.streams.samples import NANOSECONDS


class Commander:
    """Holds one command at a time."""

    def __init__(self, parameters: BridgeParameters, mavlink: ModuleType, log: Log) -> None:
        """Use `command` of the parameters; send nothing with `none`."""
        self._parameters, self._mavlink, self._log = parameters, mavlink, log
        self._kind: Kind | None = None
        self._begun = False
        self._delivery: Delivery | None = None
        self.result = "none was needed" if self.wanted else "none is enabled"

    @property
    def wanted(self) -> bool:
        """Whether an alert leads to a command."""
        return self._parameters.command != "none"

    @property
    def failed(self) -> bool:
        """Whether the newest command was not carried out."""
        done = self._delivery.outcome if self._delivery else Outcome.PENDING
        return done in (Outcome.REFUSED, Outcome.LOST) or self.result.startswith("cannot")

    def introduce(self, kind: Kind) -> None:
        """Take the kind of the autopilot; log what an alert will lead to."""
        self._kind = kind
        if not self.wanted:
            self._log("info", "an alert is told to the ground station; no command is enabled")
            return
        try:
            made = order(self._parameters.command, kind, self._mavlink)
        except ValueError as error:
            self._log("error", f"an alert will lead to no command: {error}")
            return
        how = "would be commanded (dry run)" if self._parameters.dry_run else "is commanded"
        self._log("info", f"on an alert {made.what} {how}")
        if made.danger:
            self._log("warning", f"{made.what} {made.danger}: docs/mavlink.md")

    def begin(self) -> None:
        """Begin an alert: command, as soon as the autopilot is there."""
        self._begun, self._delivery = True, None
        self.result = "waits for the autopilot"

    def withdraw(self) -> None:
        """End the alert: an order that was not acknowledged is not sent again."""
        self._begun = False
        if self._delivery is not None and self._delivery.outcome is Outcome.PENDING:
            self.result = f"{self._delivery.text}; withdrawn, the alert is over"
            self._delivery = None

    def due(self, now_ns: int) -> Iterator[tuple[Order, int]]:
        """The order to send to the autopilot now, and its confirmation."""
        if self._begun and self._kind is not None:
            self._begun = False
            self._make(self._kind)
        delivery = self._delivery
        if delivery is None or delivery.outcome is not Outcome.PENDING:
            return
        confirmation = delivery.due(now_ns)
        if confirmation is not None:
            if not confirmation:
                self._log("warning", f"commands {delivery.order.what}")
            yield delivery.order, confirmation
        self._note(delivery)

    def acknowledge(self, command: int, result: int, now_ns: int) -> None:
        """Take a COMMAND_ACK of the autopilot."""
        delivery = self._delivery
        if delivery is not None and delivery.acknowledge(command, result, now_ns):
            self._note(delivery)

    def _make(self, kind: Kind) -> None:
        try:
            made = order(self._parameters.command, kind, self._mavlink)
        except ValueError as error:
            self.result = f"cannot be commanded: {error}"
            self._log("error", self.result)
            return
        if self._parameters.dry_run:
            numbers = ", ".join(f"{one:g}" for one in made.params)
            self.result = f"dry run: {made.what}, MAV_CMD {made.command} ({numbers}) is not sent"
            self._log("warning", self.result)
            return
        timeout_ns = round(self._parameters.ack_timeout_s * NANOSECONDS)
        self._delivery = Delivery(made, self._parameters.command_attempts, timeout_ns)

    def _note(self, delivery: Delivery) -> None:
        """Log its outcome once."""
        if delivery.outcome is not Outcome.PENDING and self.result != delivery.text:
            level: Level = "info" if delivery.outcome is Outcome.DONE else "error"
            self._log(level, f"the command {delivery.text}")
        self.result = delivery.text


COPTERS = (
    "QUADROTOR", "COAXIAL", "HELICOPTER", "HEXAROTOR", "OCTOROTOR", "TRICOPTER", "DODECAROTOR",
    "DECAROTOR",
)  # fmt: skip
PX4_AUTO, PX4_AUTO_LOITER = 4, 3
"""Custom main mode and sub mode of PX4 (px4_custom_mode.h)."""
COPTER_ALT_HOLD, PLANE_CIRCLE, ROVER_HOLD = 2, 1, 4
"""Custom modes of ArduPilot that use no GPS."""
FOLLOWS = "follows a false GPS"


@dataclass(frozen=True)
class Order:
    """A COMMAND_LONG.

    Attributes:
        what: For people.
        command: Its number.
        params: Parameters 1 to 7.
        danger: What a false GPS does to it; empty for nothing.
    """

    what: str
    command: int
    params: tuple[float, ...]
    danger: str = ""


@dataclass(frozen=True)
class Kind:
    """Autopilot and vehicle of a HEARTBEAT."""

    autopilot: int
    vehicle: int


def order(name: str, kind: Kind, mavlink: ModuleType) -> Order:
    """The order for a value of the parameter `command`.

    Raises:
        ValueError: This kind of vehicle has none; the text has the remedy.
    """
    if name == "user_1":
        return Order("MAV_CMD_USER_1, parameter 1 = 1", mavlink.MAV_CMD_USER_1, _params(1.0))
    if name == "rtl":
        return Order("return to launch", mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH, _params(), FOLLOWS)
    if name == "land":
        if kind.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA and not _copter(kind, mavlink):
            raise ValueError("ArduPilot lands only copters on this command: choose hold or rtl")
        danger = f"{FOLLOWS} sideways while it descends"
        return Order("land", mavlink.MAV_CMD_NAV_LAND, _params(), danger)
    return _hold(kind, mavlink)


def _hold(kind: Kind, mavlink: ModuleType) -> Order:
    """Stay without the GPS where the autopilot can do that without a pilot."""
    if kind.autopilot == mavlink.MAV_AUTOPILOT_PX4:
        return _mode("Hold", mavlink, PX4_AUTO, PX4_AUTO_LOITER, danger=FOLLOWS)
    if kind.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA:
        if _copter(kind, mavlink):
            return _mode("ALT_HOLD", mavlink, COPTER_ALT_HOLD)
        if kind.vehicle == mavlink.MAV_TYPE_FIXED_WING:
            return _mode("CIRCLE", mavlink, PLANE_CIRCLE)
        if kind.vehicle in (mavlink.MAV_TYPE_GROUND_ROVER, mavlink.MAV_TYPE_SURFACE_BOAT):
            return _mode("HOLD", mavlink, ROVER_HOLD)
    raise ValueError(
        f"there is no hold for vehicle type {kind.vehicle} of autopilot {kind.autopilot}: choose "
        "rtl, land or user_1"
    )


def _mode(name: str, mavlink: ModuleType, main: int, sub: int = 0, *, danger: str = "") -> Order:
    params = _params(float(mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED), float(main), float(sub))
    return Order(f"mode {name}", mavlink.MAV_CMD_DO_SET_MODE, params, danger)


def _copter(kind: Kind, mavlink: ModuleType) -> bool:
    return kind.vehicle in {getattr(mavlink, f"MAV_TYPE_{name}") for name in COPTERS}


def _params(*first: float) -> tuple[float, ...]:
    return (*first, *[0.0] * (7 - len(first)))


PROGRESS_NS = 30 * NANOSECONDS
"""Timeout of a command in progress without another acknowledgement. Chosen, not swept."""
ACCEPTED, REJECTED_NOW, IN_PROGRESS = 0, 1, 5
"""Values of MAV_RESULT that do not end in a refusal."""
RESULTS = (
    "accepted", "temporarily rejected", "denied", "unsupported", "failed", "in progress",
    "cancelled", "only as COMMAND_LONG", "only as COMMAND_INT",
)  # fmt: skip


class Outcome(Enum):
    """How far a command has come."""

    PENDING = "not answered yet"
    DONE = "accepted"
    REFUSED = "refused"
    LOST = "not acknowledged"


class Delivery:
    """A command, its tries, and its outcome."""

    def __init__(self, order: Order, attempts: int, timeout_ns: int) -> None:
        """Send `attempts` times at most, `timeout_ns` apart."""
        self.order = order
        self.outcome = Outcome.PENDING
        self.result = ""
        self.sent = 0
        self._attempts, self._timeout_ns = attempts, timeout_ns
        self._next_ns: int | None = None

    @property
    def text(self) -> str:
        """Its outcome, for people."""
        times = "once" if self.sent == 1 else f"{self.sent} times"
        result = f": {self.result}" if self.result else ""
        return f"{self.order.what}, sent {times}, {self.outcome.value}{result}"

    def due(self, now_ns: int) -> int | None:
        """The number of the confirmation with which to send it now; None if it is not time."""
        if self.outcome is not Outcome.PENDING or now_ns < (self._next_ns or now_ns):
            return None
        if self.sent >= self._attempts:
            self.outcome = Outcome.LOST
            return None
        self._next_ns = now_ns + self._timeout_ns
        self.sent += 1
        return self.sent - 1

    def acknowledge(self, command: int, result: int, now_ns: int) -> bool:
        """Take a COMMAND_ACK; whether it was of this command."""
        if command != self.order.command or not self.sent or self.outcome is not Outcome.PENDING:
            return False
        self.result = RESULTS[result] if result < len(RESULTS) else f"result {result}"
        if result == ACCEPTED:
            self.outcome, self.result = Outcome.DONE, ""
        elif result == IN_PROGRESS:
            self._next_ns = now_ns + PROGRESS_NS
        elif result != REJECTED_NOW:
            self.outcome = Outcome.REFUSED
        return True
