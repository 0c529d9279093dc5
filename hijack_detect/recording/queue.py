# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Rows on their way to the journal, in bounded memory."""

from __future__ import annotations

from collections import Counter, deque
from itertools import islice

from hijack_detect.recording import schema
from hijack_detect.recording.rows import Row

MAX_BULK = 20_000
"""Half an hour of a flight with two detectors, some megabytes."""
MAX_KEPT = 1000


class RowQueue:
    """Waiting rows; while the disk takes none the oldest are dropped and counted.

    Alerts, snapshots and events wait apart from the many others, and are written first.

    Attributes:
        dropped: Rows dropped, by table.
    """

    def __init__(self) -> None:
        self._kept: deque[Row] = deque()
        self._bulk: deque[Row] = deque()
        self.dropped: Counter[str] = Counter()

    def __len__(self) -> int:
        return len(self._kept) + len(self._bulk)

    def add(self, row: Row) -> None:
        """Add a row."""
        bulk = row.table in schema.BULK
        queue, most = (self._bulk, MAX_BULK) if bulk else (self._kept, MAX_KEPT)
        queue.append(row)
        if len(queue) > most:
            self.dropped[queue.popleft().table] += 1

    def first(self, max_bytes: int) -> list[Row]:
        """The rows to be written next, of about so many bytes, at least one if there are any."""
        chosen: list[Row] = []
        size = 0
        queue = self._kept or self._bulk
        for row in islice(queue, MAX_BULK):
            size += row.size
            if chosen and size > max_bytes:
                break
            chosen.append(row)
        return sorted(chosen, key=lambda row: row.table)

    def remove(self, count: int) -> None:
        """Forget so many rows that `first` gave: they are written."""
        queue = self._kept or self._bulk
        for _ in range(count):
            queue.popleft()
