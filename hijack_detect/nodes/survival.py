# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Keeps an alert beyond the end of the process that raised it."""

from __future__ import annotations

import time
from dataclasses import asdict

from hijack_detect.detectors.fusion import Latched
from hijack_detect.nodes.state_file import StateFile


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
        told = self._file.read()
        if told is None:
            return None
        try:
            if not 0.0 <= _uptime_s() - float(told["alive_s"]) <= self._survive_s:
                return None
            alert = told["alert"]
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
