# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which system on a link is the autopilot."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from hijack_detect.mavlink.commands import Delivery, Kind, Order, Outcome
from hijack_detect.streams.samples import NANOSECONDS

ATTEMPTS, TIMEOUT_NS = 4, NANOSECONDS // 2
"""Requests of a rate, and the timeout of each. Chosen, not swept."""
IMUS = ("HIGHRES_IMU", "SCALED_IMU", "RAW_IMU")
MICROSECONDS = 1e6


class Rates:
    """MAV_CMD_SET_MESSAGE_INTERVAL for each message; the next IMU only if the one before fails."""

    def __init__(self, imu_rate_hz: float, gps_rate_hz: float, mavlink: ModuleType) -> None:
        """Ask for nothing yet; a rate of 0 is never asked for."""
        self._mavlink = mavlink
        self._imu_hz, self._gps_hz = imu_rate_hz, gps_rate_hz
        self._queue: deque[tuple[str, float]] = deque()
        self._name, self._hz = "", 0.0
        self._delivery: Delivery | None = None

    @property
    def busy(self) -> bool:
        """Whether something has still to be asked for."""
        return bool(self._queue) or self._delivery is not None

    def restart(self) -> None:
        """Ask for everything, from the beginning."""
        self._queue.clear()
        if self._imu_hz:
            self._queue.append((IMUS[0], self._imu_hz))
        if self._gps_hz:
            self._queue.extend((("GPS_RAW_INT", self._gps_hz), ("SCALED_PRESSURE", self._gps_hz)))
        self._delivery = None

    def due(self, now_ns: int) -> tuple[Order, int] | None:
        """The order to send now, and its confirmation."""
        if self._delivery is None and self._queue:
            self._name, self._hz = self._queue.popleft()
            number = getattr(self._mavlink, f"MAVLINK_MSG_ID_{self._name}")
            params = (float(number), MICROSECONDS / self._hz, 0.0, 0.0, 0.0, 0.0, 0.0)
            order = Order(
                f"{self._name} at {self._hz:g} Hz",
                self._mavlink.MAV_CMD_SET_MESSAGE_INTERVAL,
                params,
            )
            self._delivery = Delivery(order, ATTEMPTS, TIMEOUT_NS)
        if self._delivery is None:
            return None
        confirmation = self._delivery.due(now_ns)
        return None if confirmation is None else (self._delivery.order, confirmation)

    def acknowledge(self, command: int, result: int, now_ns: int) -> None:
        """Take a COMMAND_ACK."""
        if self._delivery is not None:
            self._delivery.acknowledge(command, result, now_ns)

    def news(self) -> str:
        """What came of the message that was asked for last, once; empty for nothing new."""
        delivery = self._delivery
        if delivery is None or delivery.outcome is Outcome.PENDING:
            return ""
        self._delivery = None
        if delivery.outcome is not Outcome.DONE and self._name in IMUS[:-1]:
            self._queue.appendleft((IMUS[IMUS.index(self._name) + 1], self._hz))
        return delivery.text


ADDRESS = tuple[int, int]
"""System and component."""


@dataclass
class Vehicle:
    """The autopilot: its address, its kind, and the time of its newest heartbeat (ns)."""

    address: ADDRESS
    kind: Kind
    heartbeat_ns: int
    lost: int = 0
    last_sequence: int | None = None

    def count(self, sequence: int) -> None:
        """Count the messages that are missing before one; late ones are no gap."""
        if self.last_sequence is not None:
            gap = (sequence - self.last_sequence - 1) % 256
            if gap >= 128:
                return
            self.lost += gap
        self.last_sequence = sequence


class Search:
    """The search for the autopilot: a sender of its heartbeats that also sends an IMU.

    The first is kept for good. One that comes later, or has another system id, gets no command,
    and its messages are ignored.
    """

    def __init__(self, wanted: int, mavlink: ModuleType) -> None:
        """Accept this system only; 0 takes the first."""
        self._wanted, self._mavlink = wanted, mavlink
        self._candidates: dict[ADDRESS, tuple[Kind, int]] = {}
        self.found: Vehicle | None = None

    @property
    def likely(self) -> ADDRESS | None:
        """The address that is asked for an IMU: the one found, or the first with a heartbeat."""
        if self.found is not None:
            return self.found.address
        return next(filter(self._is_wanted, self._candidates), None)

    def heartbeat(self, message: Any, now_ns: int) -> ADDRESS | None:
        """Take a HEARTBEAT; return its sender if that is another autopilot than the one found."""
        none, station = self._mavlink.MAV_AUTOPILOT_INVALID, self._mavlink.MAV_TYPE_GCS
        if message.autopilot == none or message.type == station:
            return None
        address = address_of(message)
        kind = Kind(int(message.autopilot), int(message.type))
        if self.found is not None and address == self.found.address:
            self.found.kind, self.found.heartbeat_ns = kind, now_ns
            return None
        self._candidates[address] = (kind, now_ns)
        return address if self.found is not None or not self._is_wanted(address) else None

    def imu(self, message: Any) -> bool:
        """Take a message with an IMU; whether it has made its sender the one that is found."""
        address = address_of(message)
        if self.found is not None or address not in self._candidates:
            return False
        if not self._is_wanted(address):
            return False
        self.found = Vehicle(address, *self._candidates[address])
        return True

    def _is_wanted(self, address: ADDRESS) -> bool:
        return self._wanted in (0, address[0])


def address_of(message: Any) -> ADDRESS:
    """Sender of a message."""
    return message.get_srcSystem(), message.get_srcComponent()
