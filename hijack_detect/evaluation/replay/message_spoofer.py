"""Attacks applied to the messages of a bag: fixes and velocities change, all other bytes stay."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from hijack_detect.bags.reader import RawMessage, typestore
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.messages import CONVERTERS, BadMessage, header_stamp_ns

SPOOFED_INPUTS = ("fix", "velocity")
"""Inputs that an attack changes."""


class Spoofed(NamedTuple):
    """A message after the attack: CDR bytes, and whether an attack covers its stamp."""

    data: bytes
    active: bool


class MessageSpoofer:
    """Applies a scenario to fixes and velocities, which it has to see from the bag's first on."""

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
            on_refused: Called with message, header stamp and reason for one that holds a value
                which no receiver can mean; it passes as it is.
        """
        self._spoofer = Spoofer(scenario, start_ns)
        self._refuse = on_refused

    def apply(self, raw: RawMessage, input_name: str, message: Any) -> Spoofed:
        """Return a fix or velocity as it is reported; the recorded bytes if nothing changes.

        Args:
            raw: The message as it was recorded.
            input_name: `fix` or `velocity`.
            message: The same, deserialised; its fields are changed.
        """
        stamp_ns = header_stamp_ns(message)
        active = self._spoofer.active(stamp_ns)
        try:
            sample = CONVERTERS[input_name](message)
        except BadMessage as error:
            self._refuse(raw, stamp_ns, str(error))
            return Spoofed(raw.data, active)
        if input_name == "fix":
            fix = self._spoofer.fix(sample)
            if fix == sample:
                return Spoofed(raw.data, active)
            message.latitude, message.longitude = fix.latitude_deg, fix.longitude_deg
            message.altitude = fix.altitude_m
        else:
            velocity = self._spoofer.velocity(sample)
            if velocity == sample:
                return Spoofed(raw.data, active)
            linear = message.twist.linear
            linear.x, linear.y, linear.z = velocity.velocity
        return Spoofed(bytes(typestore().serialize_cdr(message, raw.msgtype)), active)
