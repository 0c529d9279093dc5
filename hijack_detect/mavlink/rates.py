# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Asks an autopilot to send what is needed, one message after the other."""

from __future__ import annotations

from collections import deque
from types import ModuleType

from hijack_detect.mavlink.delivery import Delivery, Outcome
from hijack_detect.mavlink.orders import Order
from hijack_detect.streams.samples import NANOSECONDS

ATTEMPTS, TIMEOUT_NS = 4, NANOSECONDS // 2
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
        """What is to be sent now, and with which confirmation."""
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
