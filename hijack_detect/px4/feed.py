# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One topic of PX4 on its way to ours, with counts of its messages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from hijack_detect.bags.topics import NEEDED
from hijack_detect.logs.px4 import readings, stamp_us
from hijack_detect.px4.clock import Px4Clock
from hijack_detect.px4.topics import MISSING, Px4Topic
from hijack_detect.streams.messages import BadMessage, check
from hijack_detect.streams.samples import Sample


class OtherVersion(BadMessage):
    """A message was written by another px4_msgs than the one that is installed."""


PADDING = 4
"""Encoders may fill up the last word of a message, or not."""
SILENT_S = 3.0
"""Silence after which a topic is reported. Chosen: no receiver is slower than 1 Hz."""


@dataclass
class Feed:
    """Turns messages of one topic into samples.

    Attributes:
        topic: The topic.
        size: Bytes of a message as the installed px4_msgs writes it; all of these types have one
            size.
        received: Messages so far.
        left_out: Messages, or parts of one, that could not be used, by reason.
        stamp_ns: The newest stamp, nanoseconds; None before the first.
    """

    topic: Px4Topic
    size: int
    received: int = 0
    left_out: Counter[str] = field(default_factory=Counter)
    stamp_ns: int | None = None
    _reported: tuple[int, int] = (0, 0)
    _silent_s: float = 0.0

    def check_size(self, data: bytes) -> None:
        """Hold the size of a message to that of the installed type.

        Raises:
            OtherVersion: They differ.
        """
        if abs(len(data) - self.size) >= PADDING:
            raise OtherVersion(
                f"it has {len(data)} bytes, {self.topic.msgtype} here has {self.size}: px4_msgs is "
                "of another version than the firmware"
            )

    def take(self, message: Any, clock: Px4Clock, arrived_ns: int) -> Iterator[tuple[str, Sample]]:
        """Input and sample of each reading in a message; nothing while the clock is being found.

        Args:
            message: A message of the topic's type.
            clock: The clock of this PX4.
            arrived_ns: When it arrived by the system clock, nanoseconds.

        Raises:
            BadMessage: It, or the next part of it, has a value that no sensor can measure.
        """
        name = self.topic.name
        time_us = stamp_us(name, message)
        stamp_ns = clock.stamp_ns(self.topic.topic, time_us, arrived_ns)
        if stamp_ns is None:
            return
        for one in readings(name, message, stamp_ns):
            assert not isinstance(one.value, tuple)  # an attitude: no message that is read has one
            check(one.value)
            self.stamp_ns = stamp_ns
            yield one.name, one.value

    def report(self, seconds: float, publishers: int) -> tuple[bool, str, dict[str, str]]:
        """Whether all is well, a sentence, and values for /diagnostics.

        Args:
            seconds: Since the last report.
            publishers: How many the topic has.
        """
        refused = sum(self.left_out.values())
        came, bad = self.received - self._reported[0], refused - self._reported[1]
        self._reported = (self.received, refused)
        self._silent_s = 0.0 if came else self._silent_s + seconds
        values = {
            "publishers": str(publishers),
            "rate Hz": f"{came / seconds:.1f}",
            "received": str(self.received),
            "last stamp": "" if self.stamp_ns is None else f"{self.stamp_ns * 1e-9:.6f}",
            **{f"left out, {reason}": str(count) for reason, count in self.left_out.items()},
        }
        if publishers == 0:
            well = self.topic.name not in NEEDED
            return well, f"nobody publishes it: {MISSING[self.topic.name]}", values
        if bad:
            return False, f"left out since the last report: {bad} of {came} messages", values
        if self._silent_s >= SILENT_S:
            return False, "there is a publisher, and nothing comes", values
        return True, f"{came / seconds:.1f} Hz", values
