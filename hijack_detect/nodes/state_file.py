# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a node keeps beyond the end of its process, and not beyond that of the machine."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

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

    def write(self, told: Mapping[str, Any]) -> None:
        """Replace what is kept, at once.

        Raises:
            OSError: It cannot be written.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        part = self.path.with_suffix(".part")
        part.write_text(json.dumps({"boot": _boot_id(), **told}) + "\n", encoding="utf-8")
        part.replace(self.path)

    def read(self) -> dict[str, Any] | None:
        """What is kept; None if there is nothing, or nothing of this start of the machine."""
        try:
            told = json.loads(self.path.read_text(encoding="utf-8"))
            return dict(told) if told["boot"] == _boot_id() else None
        except (OSError, ValueError, LookupError, TypeError, RecursionError):
            return None

    def forget(self) -> None:
        """Take the file away."""
        self.path.unlink(missing_ok=True)


def _boot_id() -> str:
    """Which start of the machine this is; empty where that is not known."""
    return BOOT.read_text(encoding="ascii").strip() if BOOT.is_file() else ""
