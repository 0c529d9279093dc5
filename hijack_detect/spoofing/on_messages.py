# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attacks on the messages of a GPS receiver, whether they come from rclpy or from rosbags."""

from __future__ import annotations

from typing import Any

from hijack_detect.spoofing.live import LiveSpoofer
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.messages import (
    Absence,
    fix_sample,
    header_stamp_ns,
    satellite_count,
    velocity_sample,
    write_change,
)
from hijack_detect.streams.samples import SatelliteSample

SPOOFED_INPUTS = ("fix", "velocity", "satellites")
"""Inputs that an attack changes."""


class SpoofedMessages:
    """Writes what a spoofer reports into messages.

    A `std_msgs/UInt32` with a number of satellites has no stamp: it belongs to the last usable
    fix before it. Before the first fix it stays as it is. What the receiver does not measure, an
    attack does not report either.
    """

    def __init__(self, spoofer: Spoofer | LiveSpoofer) -> None:
        """Apply a spoofer, which has to see the messages from the first on."""
        self._spoofer, self._absence = spoofer, Absence()
        self._fix_ns: int | None = None

    def stamp_ns(self, input_name: str, message: Any) -> int | None:
        """Stamp of a message, nanoseconds; None for a number of satellites before any fix."""
        return self._fix_ns if input_name == "satellites" else header_stamp_ns(message)

    def apply(self, input_name: str, message: Any) -> bool:
        """Change a message into the reported one; return whether it changed.

        Args:
            input_name: One of SPOOFED_INPUTS.
            message: A message of that input; its fields are changed.

        Raises:
            BadMessage: It holds a value that no receiver can mean; it is left as it is.
        """
        if input_name == "fix":
            fix = self._absence(fix_sample(message))
            assert fix is not None
            self._fix_ns = fix.stamp_ns
            return write_change(message, fix, self._spoofer.fix(fix))
        if input_name == "velocity":
            velocity = self._absence(velocity_sample(message))
            assert velocity is not None
            return write_change(message, velocity, self._spoofer.velocity(velocity))
        count = self._absence(satellite_count(message))
        if self._fix_ns is None or count is None:
            return False
        number = SatelliteSample(self._fix_ns, count)
        return write_change(message, number, self._spoofer.satellites(number))
