# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command of an alert: which it is, whether it was taken, and saying so."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

from hijack_detect.level import Level, Tell
from hijack_detect.mavlink.delivery import Delivery, Outcome
from hijack_detect.mavlink.orders import Kind, Order, order
from hijack_detect.mavlink.parameters import BridgeParameters
from hijack_detect.streams.samples import NANOSECONDS


class Commander:
    """Holds one command at a time."""

    def __init__(self, parameters: BridgeParameters, mavlink: ModuleType, say: Tell) -> None:
        """Command what the parameters say; nothing with `none`."""
        self._parameters, self._mavlink, self._say = parameters, mavlink, say
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
        """The kind of the autopilot is known: say what an alert will lead to."""
        self._kind = kind
        if not self.wanted:
            self._say("info", "an alert is told to the ground station; no command is enabled")
            return
        try:
            made = order(self._parameters.command, kind, self._mavlink)
        except ValueError as error:
            self._say("error", f"an alert will lead to no command: {error}")
            return
        how = "would be commanded (dry run)" if self._parameters.dry_run else "is commanded"
        self._say("info", f"on an alert {made.what} {how}")
        if made.danger:
            self._say("warning", f"{made.what} {made.danger}: docs/mavlink.md")

    def begin(self) -> None:
        """There is an alert: command, as soon as the autopilot is heard."""
        self._begun, self._delivery = True, None
        self.result = "waits for the autopilot"

    def withdraw(self) -> None:
        """The alert is over: what was not acknowledged is not sent again."""
        self._begun = False
        if self._delivery is not None and self._delivery.outcome is Outcome.PENDING:
            self.result = f"{self._delivery.text}; withdrawn, the alert is over"
            self._delivery = None

    def due(self, now_ns: int) -> Iterator[tuple[Order, int]]:
        """What is to be sent to the autopilot now, and with which confirmation."""
        if self._begun and self._kind is not None:
            self._begun = False
            self._make(self._kind)
        delivery = self._delivery
        if delivery is None or delivery.outcome is not Outcome.PENDING:
            return
        confirmation = delivery.due(now_ns)
        if confirmation is not None:
            if not confirmation:
                self._say("warning", f"commands {delivery.order.what}")
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
            self._say("error", self.result)
            return
        if self._parameters.dry_run:
            numbers = ", ".join(f"{one:g}" for one in made.params)
            self.result = f"dry run: {made.what}, MAV_CMD {made.command} ({numbers}) is not sent"
            self._say("warning", self.result)
            return
        timeout_ns = round(self._parameters.ack_timeout_s * NANOSECONDS)
        self._delivery = Delivery(made, self._parameters.command_attempts, timeout_ns)

    def _note(self, delivery: Delivery) -> None:
        """Say once what became of it."""
        if delivery.outcome is not Outcome.PENDING and self.result != delivery.text:
            level: Level = "info" if delivery.outcome is Outcome.DONE else "error"
            self._say(level, f"the command {delivery.text}")
        self.result = delivery.text
