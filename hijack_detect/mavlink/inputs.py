# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Messages of one autopilot to samples: which IMU, and which stamps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from hijack_detect.logs import mavlink
from hijack_detect.logs.logged import Logged
from hijack_detect.mavlink.clock import AutopilotClock, InOrder
from hijack_detect.streams.samples import NANOSECONDS

RANKS = ("HIGHRES_IMU", "SCALED_IMU", "RAW_IMU")
"""Messages with an IMU, the best first."""
KINDS = frozenset((*RANKS, "GPS_RAW_INT", "SCALED_PRESSURE", "SYSTEM_TIME"))
CHOICE_NS = NANOSECONDS
"""Wait for a better IMU at first. Chosen, not swept."""
GONE_NS = 2 * NANOSECONDS
"""Silence after which an IMU is replaced by another. Chosen, not swept; below SILENT_NS."""
APART_US = 10_000_000
"""A GPS whose time is further from that of the IMU has another clock. Chosen: far above any delay
of a fix, far below a time since 1970."""
LATE, STRANGE, WAITING = "late or repeated", "of an impossible time", "before the clock was known"


class Inputs:
    """Chooses, stamps, and leaves out what comes late or twice.

    Attributes:
        taken: The message that the IMU is taken from; empty before the first.
        received_ns: When its newest came, by the steady clock; None before the first.
        shift_ns: Stamps less local time.
        dropped: Count of rejected readings, by reason.
        published: Readings, by input.
    """

    def __init__(
        self, clock: AutopilotClock, log: Callable[[str], None], shift_ns: Callable[[], int]
    ) -> None:
        """Use a clock, which observes each message.

        Args:
            clock: The clock.
            log: Takes a line on each choice.
            shift_ns: Time of the system less local time, now. It is asked for when the stamps
                begin, so that setting the clock of the system moves no stamp in between.
        """
        self._clock, self._log, self._ask_shift_ns = clock, log, shift_ns
        self.shift_ns = shift_ns()
        self._order = InOrder()
        self._seen: dict[str, int] = {}
        self._first_ns: int | None = None
        self._epoch = clock.epoch
        self._logged: set[str] = set()
        self.taken = ""
        self.received_ns: int | None = None
        self.dropped: Counter[str] = Counter()
        self.published: Counter[str] = Counter()

    def take(self, message: Any, now_ns: int, *, raw_is_scaled: bool) -> Iterator[Logged]:
        """The readings of a message of KINDS, stamped in time of the system.

        Args:
            message: The message.
            now_ns: When it came, by the steady clock.
            raw_is_scaled: Whether RAW_IMU has the units of SCALED_IMU, as of ArduPilot.
        """
        kind = message.get_type()
        if kind in RANKS and not self._is_first(message):
            return
        if kind == "RAW_IMU" and not raw_is_scaled:
            self._once("its RAW_IMU has no known units and is not used")
            return
        if kind == "SCALED_PRESSURE" and self.taken == "HIGHRES_IMU":
            return
        own_us = mavlink.own_time_us(message)
        if kind == "GPS_RAW_INT":
            own_us = self._gps_time_us(message, own_us)
        elif not self._clock.observe(own_us * 1000, now_ns):
            self.dropped[STRANGE] += 1
            return
        if self._clock.epoch != self._epoch:
            self._epoch = self._clock.epoch
            self._order.restart()
            self.shift_ns = self._ask_shift_ns()
        if kind == "SYSTEM_TIME" or (kind in RANKS and not self._chosen(kind, now_ns)):
            return
        local_ns = self._clock.stamp_ns(own_us * 1000)
        if local_ns is None:
            self.dropped[WAITING] += 1
            return
        stamp_ns = local_ns + self.shift_ns
        if not self._order.passes(_stream(kind), own_us, stamp_ns):
            self.dropped[LATE] += 1
        else:
            for reading in _convert(kind, message, stamp_ns):
                self.published[reading.name] += 1
                yield reading

    def _chosen(self, kind: str, now_ns: int) -> bool:
        """Whether the IMU is taken from this message; chooses."""
        self._seen[kind] = now_ns
        if self._first_ns is None:
            self._first_ns = now_ns
        gone = bool(self.taken) and now_ns - self._seen[self.taken] > GONE_NS
        better = bool(self.taken) and RANKS.index(kind) < RANKS.index(self.taken)
        waited = kind == RANKS[0] or now_ns - self._first_ns >= CHOICE_NS
        if better or gone or (not self.taken and waited):
            fresh = [one for one in RANKS if now_ns - self._seen.get(one, -GONE_NS) < GONE_NS]
            before, self.taken = self.taken, fresh[0] if fresh else kind
            if self.taken != before:
                self._log(
                    f"the IMU is {self.taken}" + (f", not {before} any more" if before else "")
                )
        if kind == self.taken:
            self.received_ns = now_ns
        return kind == self.taken

    def _gps_time_us(self, message: Any, own_us: int) -> int:
        """Own time of a fix. Without one there is none, and a receiver may count otherwise."""
        newest_ns = self._clock.newest_ns
        if newest_ns is None:
            return own_us
        if not mavlink.has_fix(message):
            return newest_ns // 1000
        if abs(own_us - newest_ns // 1000) > APART_US:
            self._once("its GPS has another clock than its IMU: fixes are stamped as they arrive")
            return newest_ns // 1000
        return own_us

    def _is_first(self, message: Any) -> bool:
        """Whether a message is of the first IMU; some number theirs."""
        return "id" not in message.fieldnames or message.id == 0

    def _once(self, text: str) -> None:
        if text not in self._logged:
            self._logged.add(text)
            self._log(text)


def _stream(kind: str) -> str:
    """Name of a stream with stamps in order: an IMU goes on from the one before it."""
    return "imu" if kind in RANKS else kind


def _convert(kind: str, message: Any, stamp_ns: int) -> Iterator[Logged]:
    if kind in RANKS:
        return mavlink.imu(message, stamp_ns)
    convert = mavlink.gps if kind == "GPS_RAW_INT" else mavlink.pressure
    return convert(message, stamp_ns)
