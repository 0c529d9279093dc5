# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What one snapshot is, before and after it is written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hijack_detect.bags.reader import RawMessage


@dataclass(frozen=True)
class Snapshot:
    """Messages around an alert that are to be written as a bag.

    Attributes:
        name: Name of the snapshot, the same for its parts and for the whole.
        part: 0 for the whole; parts are numbered from 1, and each holds the one before.
        alerts_ns: Stamps of the alerts in it, nanoseconds.
        messages: In order of log time.
    """

    name: str
    part: int
    alerts_ns: tuple[int, ...]
    messages: Sequence[RawMessage]

    @property
    def complete(self) -> bool:
        """Whether the time after the alert is in it, as far as there was any."""
        return self.part == 0

    @property
    def directory(self) -> str:
        """Name of the bag directory."""
        return self.name if self.complete else f"{self.name}.part{self.part}"


@dataclass(frozen=True)
class Written:
    """A snapshot on disk, complete and flushed.

    `size` is in bytes.
    """

    snapshot: Snapshot
    size: int
    excess: tuple[str, ...]
    """Bag directories that should go, so that the bounds hold; the oldest first."""


@dataclass(frozen=True)
class Failed:
    """A snapshot that could not be written; `text` says why, and what to do."""

    snapshot: Snapshot
    text: str
