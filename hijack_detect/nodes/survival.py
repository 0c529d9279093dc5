# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Keeps an alert beyond the end of the process that raised it."""

from __future__ import annotations

import json
import os
import time
from dataclasses import asdict
from pathlib import Path

from hijack_detect.detectors.fusion import Latched

BOOT = Path("/proc/sys/kernel/random/boot_id")


class Survivor:
    """A file with the latched alert of one fusion node.

    It says when the node was last alive, in the time since the machine was started, which no
    clock that is set can change. Who starts within `survive_s` of that goes on with the alert.
    """

    def __init__(self, node: str, survive_s: float) -> None:
        """Name the file by ROS domain and node.

        Args:
            node: Full name of the node.
            survive_s: Longest time between the last sign of life and a new start, s.
        """
        self.path = state_path("alert", node)
        self._survive_s = survive_s

    def write(self, alert: Latched) -> None:
        """Note the alert, and that the node is alive.

        Raises:
            OSError: The file cannot be written.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        told = {"boot": boot_id(), "alive_s": _uptime_s(), "alert": asdict(alert)}
        part = self.path.with_suffix(".part")
        part.write_text(json.dumps(told) + "\n", encoding="utf-8")
        part.replace(self.path)

    def read(self) -> Latched | None:
        """The alert to go on with, None if there is none, or what is there cannot be used."""
        try:
            told = json.loads(self.path.read_text(encoding="utf-8"))
            age_s = _uptime_s() - float(told["alive_s"])
            if told["boot"] != boot_id() or not 0.0 <= age_s <= self._survive_s:
                return None
            alert = told["alert"]
            return Latched(
                int(alert["since_ns"]),
                str(alert["cause"]),
                tuple(map(str, alert["causes"])),
                float(alert["confidence"]),
            )
        except (OSError, ValueError, ArithmeticError, LookupError, TypeError, RecursionError):
            return None

    def forget(self) -> None:
        """Take the file away: the alert was taken back, or the node was asked to end."""
        self.path.unlink(missing_ok=True)


def state_path(what: str, node: str) -> Path:
    """Where a node keeps something beyond its end; by ROS domain and its full name."""
    home = Path(os.environ.get("ROS_HOME") or Path.home() / ".ros")
    domain = os.environ.get("ROS_DOMAIN_ID") or "0"
    return home / "hijack_detect" / f"{what}-{domain}{node.replace('/', '-')}.json"


def boot_id() -> str:
    """Which start of the machine this is; empty where that is not known."""
    return BOOT.read_text(encoding="ascii").strip() if BOOT.is_file() else ""


def _uptime_s() -> float:
    return time.clock_gettime(time.CLOCK_BOOTTIME)
