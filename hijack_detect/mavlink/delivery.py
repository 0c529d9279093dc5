# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One command on its way: sent again until it is acknowledged, and not for ever."""

from __future__ import annotations

from enum import Enum

from hijack_detect.mavlink.orders import Order
from hijack_detect.streams.samples import NANOSECONDS

PROGRESS_NS = 30 * NANOSECONDS
"""So long a command may be in progress without another word."""
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
    """A command, its tries, and what became of it."""

    def __init__(self, order: Order, attempts: int, timeout_ns: int) -> None:
        """Send at most so often, each time so long after the one before."""
        self.order = order
        self.outcome = Outcome.PENDING
        self.result = ""
        self.sent = 0
        self._attempts, self._timeout_ns = attempts, timeout_ns
        self._next_ns: int | None = None

    @property
    def text(self) -> str:
        """What became of it, for people."""
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
