# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The last seconds of all messages, in bounded memory."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

from hijack_detect.bags.reader import RawMessage
from hijack_detect.streams.samples import NANOSECONDS

OVERHEAD_BYTES = 200
"""What Python needs for one message beside its bytes."""


def size_of(message: RawMessage) -> int:
    """Memory of one message, bytes."""
    return len(message.data) + OVERHEAD_BYTES


class Ring:
    """Keeps messages of the last seconds, and never more than so many bytes.

    Whoever judges the messages may be late: `hold` keeps those that it has not come to yet, and
    the seconds before them. Messages leave in the order in which they came. Their log times may be
    out of order by as much as one topic arrives later than another; old ones then leave later by
    as much.

    Attributes:
        size: Memory of the messages, bytes.
    """

    def __init__(self, seconds: float, max_bytes: int) -> None:
        """Keep messages logged within `seconds` of the newest one, in at most `max_bytes`."""
        self._span_ns = round(seconds * NANOSECONDS)
        self._max_bytes = max_bytes
        self._messages: deque[RawMessage] = deque()
        self._lost_ns: int | None = None
        self._newest_ns = 0
        self._held_ns: int | None = None
        self.size = 0

    def __len__(self) -> int:
        return len(self._messages)

    def __iter__(self) -> Iterator[RawMessage]:
        return iter(self._messages)

    @property
    def seconds(self) -> float:
        """From the first message to the newest, in log time."""
        if not self._messages:
            return 0.0
        return (self._newest_ns - self._messages[0].log_ns) / NANOSECONDS

    @property
    def short(self) -> bool:
        """Whether messages of the wanted seconds are missing, because the bytes are bounded."""
        return self._lost_ns is not None and self._lost_ns >= self._oldest_ns

    @property
    def _oldest_ns(self) -> int:
        newest = self._newest_ns
        held = newest if self._held_ns is None else min(newest, self._held_ns)
        return held - self._span_ns

    def hold(self, stamp_ns: int) -> None:
        """From now on count the seconds from this log time, if that is before the newest."""
        self._held_ns = stamp_ns

    def push(self, message: RawMessage) -> None:
        """Add a message, and drop what is too old or too much."""
        self._messages.append(message)
        self.size += size_of(message)
        self._newest_ns = max(self._newest_ns, message.log_ns)
        oldest_ns = self._oldest_ns
        while self._messages and self._messages[0].log_ns < oldest_ns:
            self._drop()
        while self.size > self._max_bytes:
            self._lost_ns = self._drop().log_ns

    def clear(self) -> None:
        """Forget everything."""
        self._messages.clear()
        self._lost_ns = self._held_ns = None
        self._newest_ns = 0
        self.size = 0

    def _drop(self) -> RawMessage:
        dropped = self._messages.popleft()
        self.size -= size_of(dropped)
        return dropped
