# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Keeps which alert was acted on, beyond the end of the process that did."""

from __future__ import annotations

from hijack_detect.nodes.state_file import StateFile


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
        told = self._file.read()
        return None if told is None or "since_ns" not in told else str(told["since_ns"])

    def write(self, since: str) -> None:
        """See Memory.

        Raises:
            OSError: It cannot be written.
        """
        self._file.write({"since_ns": since})

    def forget(self) -> None:
        """See Memory."""
        self._file.forget()
