# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Stamps in UTC from PX4's clock, which counts from its start or follows the agent's."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

UTC_FROM_US = 1_000_000_000_000_000
"""A time from here on (September 2001) is UTC: no autopilot has been on for 31 years."""
ALIGN_US = 1_000_000
"""PX4's time over which the least delay is taken as the offset. Chosen: a hundred messages of an
IMU, of which one is fast."""
BACK_US = 1_000_000
"""A topic whose time goes back further has a clock that was restarted. Chosen, not swept; above
any disorder of DDS."""
FAR_NS = 1_000_000_000
"""Stamps that are further from the system clock are reported. Chosen: far above any delay."""


class Kind(Enum):
    """What PX4's timestamps count from."""

    UNKNOWN = "not known yet"
    BOOT = "start of PX4"
    UTC = "UTC of the agent"


class Px4Clock:
    """Gives each sample the time at which it was taken, as the system clock would have it.

    Times that the agent has synchronised are UTC and stay as they are. Those that count from PX4's
    start get one constant offset, so that they keep PX4's spacing: the one with which, in the
    first second, the message that was fastest needed no time at all. What comes in that second is
    used for nothing else. A clock that goes back, or turns from one kind into the other, is
    restarted.

    Attributes:
        kind: What the timestamps count from.
        restarts: Number of restarts.
        offset_ns: Stamp less the time since PX4's start; None while it is not known.
        late_ns: By how much the newest stamp was behind the system clock.
    """

    def __init__(self, log: Callable[[str], None], warn: Callable[[str], None]) -> None:
        """Begin without an offset; `log` takes findings, `warn` problems."""
        self.kind = Kind.UNKNOWN
        self.restarts = 0
        self.offset_ns: int | None = None
        self.late_ns = 0
        self._log, self._warn = log, warn
        self._newest_us: dict[str, int] = {}
        self._first_us = 0
        self._least_ns = 0

    def stamp_ns(self, topic: str, time_us: int, arrived_ns: int) -> int | None:
        """Stamp of a sample, nanoseconds; None while the offset is being found.

        Args:
            topic: Where it came from: each topic has its times in order.
            time_us: PX4's time of it, microseconds.
            arrived_ns: When it arrived by the system clock.
        """
        kind = Kind.UTC if time_us >= UTC_FROM_US else Kind.BOOT
        back_us = self._newest_us.get(topic, 0) - time_us
        if self.kind is Kind.UNKNOWN:
            self._begin(kind, time_us, arrived_ns)
        elif kind is not self.kind:
            self._restart(f"PX4's clock changes from {self.kind.value} to {kind.value}")
            self._begin(kind, time_us, arrived_ns)
        elif back_us > BACK_US:
            self._restart(f"PX4's clock goes back by {back_us * 1e-6:.1f} s: it was restarted")
            self._begin(kind, time_us, arrived_ns)
        self._newest_us[topic] = max(time_us, self._newest_us.get(topic, 0))
        if kind is Kind.BOOT and self.offset_ns is None and not self._align(time_us, arrived_ns):
            return None
        stamp_ns = time_us * 1000 + (self.offset_ns or 0)
        self.late_ns = arrived_ns - stamp_ns
        return stamp_ns

    def report(self) -> tuple[bool, str, dict[str, str]]:
        """Whether all is well, a sentence, and values for /diagnostics."""
        values = {
            "timestamps count from": self.kind.value,
            "offset s": "" if self.offset_ns is None else f"{self.offset_ns * 1e-9:.6f}",
            "behind the system clock s": f"{self.late_ns * 1e-9:.3f}",
            "restarts": str(self.restarts),
        }
        text = f"PX4's timestamps count from: {self.kind.value}"
        if abs(self.late_ns) <= FAR_NS:
            return True, text, values
        return False, f"{text}; stamps are {self.late_ns * 1e-9:.1f} s behind this clock", values

    def _begin(self, kind: Kind, time_us: int, arrived_ns: int) -> None:
        self.kind, self._first_us = kind, time_us
        self._least_ns = arrived_ns - time_us * 1000
        if kind is Kind.BOOT:
            self._log(
                "PX4's timestamps count from its start (UXRCE_DDS_SYNCT is 0, or the agent has not "
                f"synchronised yet): listening for {ALIGN_US * 1e-6:g} s to set them to the system "
                "clock"
            )
            return
        self._log("PX4's timestamps are UTC, synchronised by the agent: they stay as they are")
        if abs(self._least_ns) > FAR_NS:
            self._warn(
                f"PX4's timestamps are {self._least_ns * 1e-9:.1f} s behind this system clock: "
                "does the agent run on a machine with another clock?"
            )

    def _align(self, time_us: int, arrived_ns: int) -> bool:
        """Take one more delay; whether the offset is known."""
        self._least_ns = min(self._least_ns, arrived_ns - time_us * 1000)
        if time_us - self._first_us < ALIGN_US:
            return False
        self.offset_ns = self._least_ns
        self._log(
            f"PX4 started at {self.offset_ns * 1e-9:.3f} s of the system clock; this offset stays"
        )
        return True

    def _restart(self, why: str) -> None:
        self._warn(f"{why}; everything begins afresh")
        self.restarts += 1
        self.offset_ns = None
        self._newest_us.clear()
