# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""An autopilot that speaks MAVLink over UDP, TCP or a pseudo-terminal, in a thread of the test."""

from __future__ import annotations

import contextlib
import importlib
import os
import random
import select
import socket
import threading
import time
import tty
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol

GRAVITY = 9.80665
BOOT_US = 5_000_000
"""Time since its start when it begins."""
Schedule = Iterable[tuple[int, Any]]
"""Messages with the own time (µs) at which they are sent, in order."""


class Way(Protocol):
    def fileno(self) -> int: ...
    def put(self, data: bytes) -> None: ...
    def get(self) -> bytes: ...
    def close(self) -> None: ...


class UdpWay:
    def __init__(self, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._to = ("127.0.0.1", port)

    def fileno(self) -> int:
        return self._socket.fileno()

    def put(self, data: bytes) -> None:
        with contextlib.suppress(ConnectionRefusedError):
            self._socket.sendto(data, self._to)

    def get(self) -> bytes:
        with contextlib.suppress(BlockingIOError, ConnectionRefusedError):
            return self._socket.recv(65_535)
        return b""

    def close(self) -> None:
        self._socket.close()


class TcpWay:
    """Waits for one connection after the other."""

    def __init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self._server.setblocking(False)
        self.port = self._server.getsockname()[1]
        self.connections, self._is_cut = 0, False
        self._socket: socket.socket | None = None

    def fileno(self) -> int:
        if self._is_cut:
            self._is_cut = False
            self._end()
        return (self._socket or self._server).fileno()

    def put(self, data: bytes) -> None:
        if self._socket is not None:
            with contextlib.suppress(OSError):
                self._socket.sendall(data)

    def get(self) -> bytes:
        if self._socket is None:
            self._socket, _ = self._server.accept()
            self.connections += 1
            return b""
        with contextlib.suppress(OSError):
            if data := self._socket.recv(65_535):
                return data
        self._end()
        return b""

    def cut(self) -> None:
        """Close the connection, in the thread that uses it."""
        self._is_cut = True

    def _end(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def close(self) -> None:
        self._end()
        self._server.close()


class PtyWay:
    def __init__(self) -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._master)
        os.set_blocking(self._master, False)
        self.path = os.ttyname(self._slave)

    def fileno(self) -> int:
        return self._master

    def put(self, data: bytes) -> None:
        with contextlib.suppress(BlockingIOError):
            os.write(self._master, data)

    def get(self) -> bytes:
        return os.read(self._master, 65_535)

    def close(self) -> None:
        os.close(self._master)
        os.close(self._slave)


class Peer:
    """The autopilot; each of its messages is made by `message`, a function of its own time.

    Attributes:
        heard: Everything that was received, in order.
        results: What the next commands (not the requests for messages) are answered with; None
            is no answer. The last one stays.
        refused: Messages that it cannot send.
    """

    def __init__(
        self,
        way: Way,
        schedule: Callable[[Any], Schedule],
        *,
        dialect: str = "ardupilotmega",
        autopilot: str = "ARDUPILOTMEGA",
        v1: bool = False,
        speed: float = 1.0,
        system: int = 1,
        loss: float = 0.0,
        refused: Sequence[str] = (),
        results: Sequence[int | None] = (0,),
        key: bytes | None = None,
        answers_time: bool = True,
    ) -> None:
        version = "v10" if v1 else "v20"
        self.mavlink = importlib.import_module(f"pymavlink.dialects.{version}.{dialect}")
        self.way, self._schedule, self._speed = way, schedule, speed
        self._mav = self.mavlink.MAVLink(None, srcSystem=system, srcComponent=1)
        self._mav.robust_parsing = True
        if key is not None:
            self._mav.signing.secret_key, self._mav.signing.sign_outgoing = key, True
            self._mav.signing.timestamp = round((time.time() - 1_420_070_400) * 1e5)
        self._autopilot = getattr(self.mavlink, f"MAV_AUTOPILOT_{autopilot}")
        self.loss, self.refused, self.results = loss, list(refused), list(results)
        self.answers_time = answers_time
        self.heard: list[Any] = []
        self.asked: list[str] = []
        self.sent = 0
        self.quiet = False
        self._random = random.Random(5)
        self._late: list[bytes] = []
        self._begin()
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _begin(self) -> None:
        self._start_s = time.monotonic()
        self._due = iter(self._schedule(self.mavlink))
        self._next: tuple[int, Any] | None = next(self._due, None)
        self._beat_us = 0

    @property
    def own_us(self) -> int:
        """Time since its start."""
        return BOOT_US + round((time.monotonic() - self._start_s) * self._speed * 1e6)

    def local_s(self, own_us: int) -> float:
        """The monotonic time of the machine at an own time."""
        return self._start_s + (own_us - BOOT_US) * 1e-6 / self._speed

    def reboot(self) -> None:
        """Be started again: time counts from BOOT_US once more."""
        self._wants_reboot = True

    def play(self, schedule: Callable[[Any], Schedule]) -> None:
        """Be started again, with other messages."""
        self._schedule = schedule
        self.reboot()

    @property
    def seconds(self) -> float:
        """How long the messages have been sent, by its own time."""
        return (self.own_us - BOOT_US) * 1e-6

    def texts(self) -> list[tuple[int, str]]:
        """Severity and text of each STATUSTEXT."""
        return [(one.severity, one.text) for one in self.of("STATUSTEXT")]

    def commands(self) -> list[Any]:
        """The commands that are no request for a message."""
        interval = self.mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
        return [one for one in self.of("COMMAND_LONG") if one.command != interval]

    def of(self, kind: str) -> list[Any]:
        return [one for one in list(self.heard) if one.get_type() == kind]

    def send(self, message: Any, mav: Any = None) -> None:
        """Send; lose, repeat and hold back as `loss` says."""
        mav = mav or self._mav
        data = message.pack(mav)
        mav.seq = (mav.seq + 1) % 256
        self.sent += 1
        draw = self._random.random() if self.loss else 1.0
        if draw < self.loss:
            return
        if draw < 1.25 * self.loss:
            self._late.append(data)
            return
        self.way.put(data)
        if draw < 1.5 * self.loss:
            self.way.put(data)
        while self._late and draw > 0.8:
            self.way.put(self._late.pop())

    def close(self) -> None:
        self._ends.set()
        self._thread.join()
        self.way.close()

    _wants_reboot = False

    def _run(self) -> None:
        while not self._ends.is_set():
            if self._wants_reboot:
                self._wants_reboot = False
                self._begin()
            ready, _, _ = select.select([self.way.fileno()], [], [], 0.001)
            if ready:
                for message in self._mav.parse_buffer(self.way.get()) or ():
                    self.heard.append(message)
                    self._answer(message)
            if not self.quiet:
                self._play()

    def _play(self) -> None:
        now_us = self.own_us
        if now_us >= self._beat_us:
            self._beat_us = now_us + round(500_000 * max(1.0, self._speed))
            quadrotor = self.mavlink.MAV_TYPE_QUADROTOR
            self.send(
                self.mavlink.MAVLink_heartbeat_message(quadrotor, self._autopilot, 81, 0, 4, 3)
            )
        while self._next is not None and self._next[0] <= now_us:
            self.send(self._next[1])
            self._next = next(self._due, None)

    def _answer(self, message: Any) -> None:
        kind, mavlink = message.get_type(), self.mavlink
        if kind == "TIMESYNC" and not message.tc1 and self.answers_time:
            self.send(mavlink.MAVLink_timesync_message(self.own_us * 1000, message.ts1))
        elif kind == "COMMAND_LONG":
            result: int | None
            if message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
                name = mavlink.mavlink_map[int(message.param1)].msgname
                self.asked.append(f"{name} {message.param2:g}")
                result = mavlink.MAV_RESULT_UNSUPPORTED if name in self.refused else 0
            else:
                result = self.results.pop(0) if len(self.results) > 1 else self.results[0]
            if result is not None:
                self.send(mavlink.MAVLink_command_ack_message(message.command, result))


def free_port() -> int:
    """A UDP port that nobody uses."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def ticks(rate_hz: int, seconds: float) -> range:
    """Own times of a rate, µs."""
    return range(BOOT_US, BOOT_US + round(seconds * 1e6), 1_000_000 // rate_hz)
