# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Keeps which alert was acted on, beyond the end of the process that did."""

from __future__ import annotations

import json

from hijack_detect.nodes.survival import boot_id, state_path


class Commanded:
    """A file with the alert on which a node has commanded the autopilot; a `Memory`.

    A node that is started again in the middle of an alert must not command a second time: by then
    a pilot may have taken over. After a start of the machine the file counts no more.
    """

    def __init__(self, node: str) -> None:
        """Name the file by ROS domain and full name of the node."""
        self.path = state_path("commanded", node)

    def read(self) -> str | None:
        """See Memory."""
        try:
            told = json.loads(self.path.read_text(encoding="utf-8"))
            return str(told["since_ns"]) if told["boot"] == boot_id() else None
        except (OSError, ValueError, LookupError, TypeError, RecursionError):
            return None

    def write(self, since: str) -> None:
        """See Memory.

        Raises:
            OSError: It cannot be written.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        part = self.path.with_suffix(".part")
        part.write_text(json.dumps({"boot": boot_id(), "since_ns": since}) + "\n", encoding="utf-8")
        part.replace(self.path)

    def forget(self) -> None:
        """See Memory."""
        self.path.unlink(missing_ok=True)
