# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Bytes to messages and back (pymavlink): both framings, all messages of both autopilots, signing.

The dialect ardupilotmega holds that of PX4 (common). Only the messages of pymavlink are used, not
its connections: those wait, print, and answer to every sender.
"""

from __future__ import annotations

import importlib
import time
from collections import Counter
from pathlib import Path
from types import ModuleType
from typing import Any

V2 = 253
"""First byte of a frame of MAVLink 2."""
KEY_BYTES = 32
SIGNING_EPOCH_S = 1_420_070_400
"""1 January 2015, from which the time in signatures counts, in tens of microseconds."""
TEXT_BYTES = 50
"""Longest text of a STATUSTEXT (MAVLink: char[50])."""


def dialect(version: str) -> ModuleType:
    """The messages of MAVLink v10, which have no extensions, or of v20.

    Raises:
        ValueError: pymavlink is not installed.
    """
    try:
        return importlib.import_module(f"pymavlink.dialects.{version}.ardupilotmega")
    except ModuleNotFoundError as error:
        raise ValueError(
            "this needs pymavlink, which is not installed; it comes with the extra 'mavlink': "
            "pip install '.[mavlink]'"
        ) from error


def read_key(path: str) -> bytes:
    """The key of a file for MAVLink 2 signing.

    Raises:
        ValueError: It cannot be read, or is no key.
    """
    try:
        data = Path(path).expanduser().read_bytes()
    except OSError as error:
        raise ValueError(f"signing_key_file: {path}: {error.strerror}") from error
    if len(data) == KEY_BYTES:
        return data
    try:
        key = bytes.fromhex(data.decode("ascii").strip())
    except ValueError:
        key = b""
    if len(key) != KEY_BYTES:
        raise ValueError(
            f"signing_key_file: {path}: has {len(data)} bytes; a key is 32 bytes, or 64 "
            "hexadecimal digits: head -c 32 /dev/urandom > FILE"
        )
    return key


class Codec:
    """Packs and parses for one link.

    Attributes:
        mavlink: The dialect, with its constants.
        bad: Count of rejected frames, by reason.
    """

    def __init__(self, own_component: int, key: bytes | None = None) -> None:
        """Begin; with a key everything is signed, and nothing unsigned is taken.

        Raises:
            ValueError: pymavlink is not installed.
        """
        self.mavlink = self._spoken = dialect("v20")
        self.bad: Counter[str] = Counter()
        self._mav = self.mavlink.MAVLink(None, srcSystem=1, srcComponent=own_component)
        self._mav.robust_parsing = True
        if key is not None:
            signing = self._mav.signing
            signing.secret_key, signing.sign_outgoing = key, True
            signing.timestamp = max(0, round((time.time() - SIGNING_EPOCH_S) * 1e5))

    @property
    def own(self) -> tuple[int, int]:
        """System and component as which messages are sent."""
        return self._mav.srcSystem, self._mav.srcComponent

    def send_as(self, system: int) -> None:
        """Set the system as which messages are sent."""
        self._mav.srcSystem = system

    def speak(self, message: Any) -> None:
        """Send in the version of MAVLink of a message that was received; signing is of 2 only."""
        second = message.get_msgbuf()[0] == V2 or self._mav.signing.sign_outgoing
        self._spoken = self.mavlink if second else dialect("v10")

    def restart(self) -> None:
        """Forget half a message: the link was lost."""
        self._mav.buf, self._mav.buf_index = bytearray(), 0

    def parse(self, data: bytes) -> list[Any]:
        """All messages that are complete with these bytes."""
        messages = []
        for message in self._mav.parse_buffer(data) or ():
            kind = message.get_type()
            if kind == "BAD_DATA":
                refused = "Invalid signature" in message.reason
                self.bad["not signed with the key" if refused else "damaged"] += 1
            elif not kind.startswith("UNKNOWN_"):
                messages.append(message)
        return messages

    def pack(self, name: str, *fields: Any) -> bytes:
        """The bytes of a message, by its name in small letters and its fields in order."""
        message = getattr(self._spoken, f"MAVLink_{name}_message")(*fields)
        data: bytes = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) % 256
        return data

    def text(self, severity: int, text: str) -> bytes:
        """A STATUSTEXT, cut off after TEXT_BYTES."""
        plain = text.replace("²", "2").encode("ascii", "replace")[:TEXT_BYTES]
        return self.pack("statustext", severity, plain)
