# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The black box: the messages of each snapshot, chosen by header stamps alone.

The log time of a message is its stamp, and never less than that of the message before of its topic.
One with a broken stamp has the time of the one before; one without a header, or of a sensor with a
clock of its own, that of the recording, which is the newest stamp of all. A snapshot is in order of
log time. What the fusion has not judged yet is kept within the bound of memory. So a flight
replayed faster than the monitor can follow gives the same seconds in the same order, however late
one topic arrives after another.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from typing import Any

from hijack_detect.bags.reader import RawMessage
from hijack_detect.recording.parameters import MEGABYTE, RecorderParameters
from hijack_detect.recording.snapshots import Snapshot
from hijack_detect.recording.stamp_clock import StampClock
from hijack_detect.streams.cdr import stamp_from_bytes
from hijack_detect.streams.samples import NANOSECONDS

FUSION = "fusion"
"""Name of the source with the alert."""


@dataclass(frozen=True)
class Source:
    """A topic that is recorded.

    Attributes:
        name: Name of the input, or of the detector.
        topic: Absolute topic.
        msgtype: Type as `std_msgs/msg/Bool`.
        stamped: Whether its messages begin with a header.
        decode: Makes the message from its CDR bytes, for what the journal keeps.
    """

    name: str
    topic: str
    msgtype: str
    stamped: bool = True
    decode: Callable[[bytes], Any] | None = None


OVERHEAD_BYTES = 200
"""Memory of Python for one message beside its bytes: a RawMessage, the header of its bytes, its
place in a deque; estimated."""


def size_of(message: RawMessage) -> int:
    """Memory of one message, bytes."""
    return len(message.data) + OVERHEAD_BYTES


class Ring:
    """The messages of the last seconds, within a bound in bytes.

    The fusion may be late: `hold` keeps the messages that it has not judged, and the seconds before
    them. Messages leave in the order in which they came; where a topic is late, log times are out
    of order by its delay, and old messages leave later by it.

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


SLACK_S = 30.0
"""Time kept beyond `before_s`, and timeout of a fusion that falls silent after an alert. Chosen,
not swept."""
LATE_S = 120.0
"""Longest wait for the fusion, in time of the flight. Measured: at six times real time on two busy
cores a replay was more than 30 s ahead of its monitor; four times that, chosen. A stamp this far
from the others is that of another clock."""
GRACE_S = 2.0
"""Wait after the end of a snapshot for late messages, on the stamps of the fusion. Chosen, not
swept."""
QUIET_S = 5.0
"""Silence after which a snapshot is finished, by the wall clock. Chosen, not swept."""
_EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)


@dataclass
class _Pending:
    name: str
    alerts_ns: list[int]
    since_ns: int
    until_ns: int
    messages: list[RawMessage]
    after_bytes: int = 0
    parts: int = 0
    new_alert: bool = True


class BlackBox:
    """A recorder of the last messages, and of those around an alert.

    `due` gives the snapshots to write: at an alert at once a part with all messages before it, and
    when the time after it is over the whole. An alert within that time makes the snapshot
    longer, and gives another part.
    """

    def __init__(
        self, parameters: RecorderParameters, unused: Callable[[str], str] = lambda name: name
    ) -> None:
        """Begin empty.

        Args:
            parameters: Seconds and bytes.
            unused: Makes the name of a snapshot one that is not in use.
        """
        self._slack_ns = round(SLACK_S * NANOSECONDS)
        self._late_ns = round(LATE_S * NANOSECONDS)
        self._grace_ns = round(GRACE_S * NANOSECONDS)
        self._before_ns = round(parameters.before_s * NANOSECONDS)
        self._after_ns = round(parameters.after_s * NANOSECONDS)
        self._max_bytes = parameters.ring_max_mb * MEGABYTE // 2
        self._unused = unused
        self._clock = StampClock()
        self.ring = Ring(parameters.before_s + SLACK_S, self._max_bytes)
        self._logged_ns: dict[str, int] = {}
        self._judged_ns: int | None = None
        self._pending: _Pending | None = None
        self._finished: list[Snapshot] = []
        self._received_s = 0.0

    @property
    def now_ns(self) -> int | None:
        """Newest stamp that is accepted, nanoseconds."""
        return self._clock.now_ns

    @property
    def size(self) -> int:
        """Memory of all messages, bytes."""
        return self.ring.size + (self._pending.after_bytes if self._pending else 0)

    @property
    def collecting(self) -> bool:
        """Whether the time after an alert is not over."""
        return self._pending is not None

    def push(
        self, name: str, topic: str, msgtype: str, data: bytes, *, stamped: bool, wall_s: float
    ) -> int | None:
        """Take one message.

        Args:
            name: Name of the input.
            topic: Absolute topic under which it is written.
            msgtype: Type as `std_msgs/msg/Bool`.
            data: CDR bytes.
            stamped: Whether it begins with a header.
            wall_s: A steady clock, seconds.

        Returns:
            Its stamp in nanoseconds, None without one that is accepted.
        """
        self._received_s = wall_s
        stamp_ns = stamp_from_bytes(data) if stamped else None
        if stamp_ns is not None and not self._clock.push(name, stamp_ns):
            stamp_ns = None
        if stamp_ns is not None and self._clock.restarted:
            self.finish()
            self.ring.clear()
            self._logged_ns.clear()
            self._judged_ns = None
        now_ns = self._clock.now_ns
        if now_ns is None:
            return None
        log_ns = self._logged_ns[topic] = self._log_time(topic, stamp_ns, now_ns, stamped=stamped)
        if name == FUSION and stamp_ns is not None:
            self._judged_ns = stamp_ns
        if self._judged_ns is not None:
            self.ring.hold(max(self._judged_ns, now_ns - self._late_ns))
        self._keep(RawMessage(topic, msgtype, log_ns, data), now_ns)
        return stamp_ns

    def alert(self, stamp_ns: int | None) -> None:
        """Collect the messages around an alert.

        Args:
            stamp_ns: Stamp of the alert, nanoseconds; None for now.
        """
        alert_ns = self._clock.now_ns if stamp_ns is None else stamp_ns
        if alert_ns is None:
            return
        pending = self._pending
        if pending is not None:
            pending.alerts_ns.append(alert_ns)
            pending.until_ns = max(pending.until_ns, alert_ns + self._after_ns)
            pending.new_alert = True
            return
        since_ns = alert_ns - self._before_ns
        messages = [one for one in self.ring if one.log_ns >= since_ns]
        name = self._unused(snapshot_name(alert_ns))
        self._pending = _Pending(name, [alert_ns], since_ns, alert_ns + self._after_ns, messages)

    def due(self, wall_s: float, *, busy: bool = False) -> list[Snapshot]:
        """Take the snapshots that are to be written now.

        Args:
            wall_s: A steady clock, seconds.
            busy: Whether another is being written; then a part has to wait.
        """
        pending = self._pending
        if pending is not None and pending.new_alert and not busy:
            pending.new_alert = False
            pending.parts += 1
            self._add(_snapshot(pending, pending.parts))
        if pending is not None and wall_s - self._received_s > QUIET_S:
            self.finish()
        finished, self._finished = self._finished, []
        return finished

    def finish(self) -> None:
        """End the snapshot that is being collected."""
        if self._pending is not None:
            self._add(_snapshot(self._pending, 0))
            self._pending = None

    def _add(self, snapshot: Snapshot) -> None:
        if snapshot.messages:
            self._finished.append(snapshot)

    def _log_time(self, topic: str, stamp_ns: int | None, now_ns: int, *, stamped: bool) -> int:
        before_ns = self._logged_ns.get(topic)
        if stamp_ns is not None and abs(stamp_ns - now_ns) <= self._late_ns:
            return stamp_ns if before_ns is None else max(stamp_ns, before_ns)
        broken = stamped and stamp_ns is None
        return before_ns if broken and before_ns is not None else now_ns

    def _keep(self, message: RawMessage, now_ns: int) -> None:
        self.ring.push(message)
        pending = self._pending
        if pending is None:
            return
        size = size_of(message)
        if self._over(pending.until_ns, now_ns) or pending.after_bytes + size > self._max_bytes:
            self.finish()
            return
        pending.messages.append(message)
        pending.after_bytes += size

    def _over(self, until_ns: int, now_ns: int) -> bool:
        """Whether no more messages before `until_ns` are expected."""
        judged_ns = now_ns if self._judged_ns is None else self._judged_ns
        return judged_ns > until_ns + self._grace_ns or now_ns > until_ns + self._slack_ns


def snapshot_name(alert_ns: int) -> str:
    """Name of a snapshot: UTC of the alert's stamp, as `alert_20261125T133510.123Z`."""
    milliseconds = alert_ns // 1_000_000
    moment = _EPOCH + timedelta(milliseconds=milliseconds)
    return f"alert_{moment:%Y%m%dT%H%M%S}.{milliseconds % 1000:03d}Z"


def _snapshot(pending: _Pending, part: int) -> Snapshot:
    since_ns, until_ns = pending.since_ns, pending.until_ns
    inside = (one for one in pending.messages if since_ns <= one.log_ns <= until_ns)
    messages = sorted(inside, key=lambda one: one.log_ns)
    return Snapshot(pending.name, part, tuple(pending.alerts_ns), messages)
