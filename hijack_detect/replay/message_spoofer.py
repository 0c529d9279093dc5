# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attacks applied to the messages of a bag: what an attack forges changes, all other bytes stay."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from hijack_detect.bags.reader import RawMessage, typestore
from hijack_detect.spoofing.on_messages import SpoofedMessages
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.messages import BadMessage


class Spoofed(NamedTuple):
    """A message after the attack: CDR bytes, and whether an attack covers its stamp."""

    data: bytes
    active: bool


class MessageSpoofer:
    """Applies a scenario to the messages of a receiver, all of them from the bag's first on.

    A number of satellites has the stamp of the last fix before it in order of log time.
    """

    def __init__(
        self,
        scenario: Scenario,
        start_ns: int,
        on_refused: Callable[[RawMessage, int, str], None],
    ) -> None:
        """Apply a scenario.

        Args:
            scenario: The attacks.
            start_ns: Log time of the bag's first message, from which their times count.
            on_refused: Called with message, stamp and reason for one that holds a value which no
                receiver can mean; it passes as it is.
        """
        self._spoofer = Spoofer(scenario, start_ns)
        self._messages = SpoofedMessages(self._spoofer)
        self._refuse = on_refused

    def apply(self, raw: RawMessage, input_name: str, message: Any) -> Spoofed:
        """Return a message as it is reported; the recorded bytes if nothing changes.

        Args:
            raw: The message as it was recorded.
            input_name: One of SPOOFED_INPUTS.
            message: The same, deserialised; its fields are changed.
        """
        stamp_ns = self._messages.stamp_ns(input_name, message)
        active = stamp_ns is not None and self._spoofer.active(stamp_ns)
        try:
            changed = self._messages.apply(input_name, message)
        except BadMessage as error:
            self._refuse(raw, raw.log_ns if stamp_ns is None else stamp_ns, str(error))
            return Spoofed(raw.data, active)
        if not changed:
            return Spoofed(raw.data, active)
        return Spoofed(bytes(typestore().serialize_cdr(message, raw.msgtype)), active)
