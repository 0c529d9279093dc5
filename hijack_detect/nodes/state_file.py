# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a node keeps beyond the end of its process, and not beyond that of the machine."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from hijack_detect.detectors.fusion import Latched

BOOT = Path("/proc/sys/kernel/random/boot_id")


class StateFile:
    """A small file of one node. After a start of the machine it counts no more.

    Attributes:
        path: Where it is: by what it keeps, ROS domain and full name of the node.
    """

    def __init__(self, what: str, node: str) -> None:
        """Name the file."""
        home = Path(os.environ.get("ROS_HOME") or Path.home() / ".ros")
        domain = os.environ.get("ROS_DOMAIN_ID") or "0"
        self.path = home / "hijack_detect" / f"{what}-{domain}{node.replace('/', '-')}.json"

    def write(self, kept: Mapping[str, Any]) -> None:
        """Replace what is kept, at once.

        Raises:
            OSError: It cannot be written.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        part = self.path.with_suffix(".part")
        part.write_text(json.dumps({"boot": _boot_id(), **kept}) + "\n", encoding="utf-8")
        part.replace(self.path)

    def read(self) -> dict[str, Any] | None:
        """What is kept; None if there is nothing, or nothing of this start of the machine."""
        try:
            kept = json.loads(self.path.read_text(encoding="utf-8"))
            return dict(kept) if kept["boot"] == _boot_id() else None
        except (OSError, ValueError, LookupError, TypeError, RecursionError):
            return None

    def forget(self) -> None:
        """Take the file away."""
        self.path.unlink(missing_ok=True)


def _boot_id() -> str:
    """Which start of the machine this is; empty where that is not known."""
    return BOOT.read_text(encoding="ascii").strip() if BOOT.is_file() else ""


class Survivor:
    """A file with the latched alert of one fusion node.

    It holds when the node was last alive, in the time since the machine was started, which no
    clock that is set can change. A node that starts within `survive_s` of that keeps the alert.
    """

    def __init__(self, node: str, survive_s: float) -> None:
        """Name the file by ROS domain and node.

        Args:
            node: Full name of the node.
            survive_s: Longest time between the last sign of life and a new start, s.
        """
        self._file = StateFile("alert", node)
        self.path = self._file.path
        self._survive_s = survive_s

    def write(self, alert: Latched) -> None:
        """Note the alert, and that the node is alive.

        Raises:
            OSError: The file cannot be written.
        """
        self._file.write({"alive_s": _uptime_s(), "alert": asdict(alert)})

    def read(self) -> Latched | None:
        """The alert to go on with, None if there is none, or what is there cannot be used."""
        kept = self._file.read()
        if kept is None:
            return None
        try:
            if not 0.0 <= _uptime_s() - float(kept["alive_s"]) <= self._survive_s:
                return None
            alert = kept["alert"]
            return Latched(
                int(alert["since_ns"]),
                str(alert["cause"]),
                tuple(map(str, alert["causes"])),
                float(alert["confidence"]),
            )
        except (ValueError, ArithmeticError, LookupError, TypeError, RecursionError):
            return None

    def forget(self) -> None:
        """Take the file away: the alert was taken back, or the node was asked to end."""
        self._file.forget()


def _uptime_s() -> float:
    return time.clock_gettime(time.CLOCK_BOOTTIME)


class Commanded:
    """A file with the alert on which a node has commanded the autopilot; a `Memory`.

    A node that is started again in the middle of an alert must not command a second time: by then
    a pilot may have taken over.
    """

    def __init__(self, node: str) -> None:
        """Name the file by ROS domain and full name of the node."""
        self._file = StateFile("commanded", node)

    def read(self) -> str | None:
        """See Memory."""
        kept = self._file.read()
        return None if kept is None or "since_ns" not in kept else str(kept["since_ns"])

    def write(self, since: str) -> None:
        """See Memory.

        Raises:
            OSError: It cannot be written.
        """
        self._file.write({"since_ns": since})

    def forget(self) -> None:
        """See Memory."""
        self._file.forget()
