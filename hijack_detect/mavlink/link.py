# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The way to an autopilot: UDP, TCP or a serial port, read without waiting."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

Address = Any
"""Where a datagram came from; None where there is only one place."""

KINDS = ("udpin", "udp", "udpout", "tcp", "serial")
FORMS = (
    "udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, serial:DEVICE:BAUD or the path of a device"
)
CONNECT_S = 3.0
"""Timeout of a TCP connection. Chosen, not swept; a lost SYN is sent again after 1 s."""
READ_BYTES = 65_535
MOST_READS = 64
"""Reads in a row before anything else is done. Chosen, not swept."""
MOST_WAITING = 65_536
"""Bytes waiting to be sent at which a link is lost. Chosen, not swept."""
AGAIN = (errno.EAGAIN, errno.EWOULDBLOCK)


class LinkLost(OSError):
    """A link cannot be opened, or has ended; the text has the reason."""


class Link(Protocol):
    """An open link."""

    def fileno(self) -> int:
        """What to wait for with select."""

    def read(self) -> Iterator[tuple[bytes, Address]]:
        """What has arrived, and from where. Raises LinkLost."""

    def write(self, data: bytes, to: Address) -> None:
        """Send. Raises LinkLost."""

    def close(self) -> None:
        """End it."""


@dataclass(frozen=True)
class Place:
    """A connection string in its parts: HOST and PORT, or DEVICE and BAUD."""

    kind: str
    name: str
    number: int

    def __str__(self) -> str:
        return f"{self.kind}:{self.name}:{self.number}"


def place(connection: str, baud: int) -> Place:
    """Read a connection string.

    Raises:
        ValueError: It is none; the text lists the forms.
    """
    if connection.startswith("/"):
        connection = f"serial:{connection}"
    kind, _, rest = connection.partition(":")
    name, _, number = rest.rpartition(":")
    if kind == "serial" and (Path(rest).exists() or not (name and number.isdigit())):
        name, number = rest, str(baud)
    if kind not in KINDS or not name or not number.isdigit():
        raise ValueError(f"connection {connection!r} is not understood; give {FORMS}")
    if kind != "serial" and not 0 < int(number) < 65_536:
        raise ValueError(f"connection {connection!r}: there is no port {number}")
    return Place("udpin" if kind == "udp" else kind, name, int(number))


def open_link(where: Place) -> Link:
    """Open a link.

    Raises:
        LinkLost: It cannot be opened now.
        ValueError: pyserial is needed and not installed.
    """
    try:
        if where.kind == "serial":
            return _Serial(where)
        if where.kind == "tcp":
            return _Tcp(where)
        return _Udp(where)
    except OSError as error:  # pyserial's too
        raise LinkLost(f"{where}: {error.strerror or error}") from error


class _Udp:
    def __init__(self, where: Place) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._to: Address = None
            if where.kind == "udpin":
                self._socket.bind((where.name, where.number))
            else:
                self._to = (socket.gethostbyname(where.name), where.number)
            self._socket.setblocking(False)
        except OSError:
            self._socket.close()
            raise

    def fileno(self) -> int:
        return self._socket.fileno()

    def read(self) -> Iterator[tuple[bytes, Address]]:
        for _ in range(MOST_READS):
            try:
                yield self._socket.recvfrom(READ_BYTES)
            except OSError as error:
                if error.errno in AGAIN:
                    return
                if error.errno != errno.ECONNREFUSED:  # nobody is there yet
                    raise LinkLost(error.strerror) from error

    def write(self, data: bytes, to: Address) -> None:
        if (address := to or self._to) is None:
            return
        with contextlib.suppress(OSError):  # as good as lost on the way; silence is noticed
            self._socket.sendto(data, address)

    def close(self) -> None:
        self._socket.close()


class _Stream:
    """Bytes in order, to and from one place. It is read when there is something."""

    EMPTY_ENDS = True
    """Whether reading nothing, after something, is the end too."""

    def __init__(self) -> None:
        self._waiting = b""

    def fileno(self) -> int:
        raise NotImplementedError

    def read(self) -> Iterator[tuple[bytes, Address]]:
        for count in range(MOST_READS):
            try:
                data = os.read(self.fileno(), READ_BYTES)
            except OSError as error:
                if error.errno in AGAIN:
                    return
                raise LinkLost(error.strerror) from error
            if not data and count and not self.EMPTY_ENDS:
                return
            if not data:
                raise LinkLost("the other side has closed it")
            yield data, None

    def write(self, data: bytes, to: Address) -> None:
        self._waiting += data
        try:
            self._waiting = self._waiting[os.write(self.fileno(), self._waiting) :]
        except OSError as error:
            if error.errno not in AGAIN:
                raise LinkLost(error.strerror) from error
        if len(self._waiting) > MOST_WAITING:
            raise LinkLost("it takes nothing that is sent")


class _Tcp(_Stream):
    def __init__(self, where: Place) -> None:
        super().__init__()
        self._socket = socket.create_connection((where.name, where.number), CONNECT_S)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.setblocking(False)

    def fileno(self) -> int:
        return self._socket.fileno()

    def close(self) -> None:
        self._socket.close()


class _Serial(_Stream):
    EMPTY_ENDS = False

    def __init__(self, where: Place) -> None:
        super().__init__()
        try:
            import serial  # noqa: PLC0415  an extra
        except ModuleNotFoundError as error:
            raise ValueError(
                "a serial port needs pyserial, which is not installed; it comes with the extra "
                "'mavlink': pip install '.[mavlink]'"
            ) from error
        self._port = serial.Serial(where.name, where.number, timeout=0, exclusive=True)
        os.set_blocking(self._port.fileno(), False)

    def fileno(self) -> int:
        return int(self._port.fileno())

    def close(self) -> None:
        self._port.close()
