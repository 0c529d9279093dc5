# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""When each message of a replay is due: pace, pause, step, loop, and the clock."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from enum import Enum
from typing import NamedTuple

from hijack_detect.bags.errors import BagError
from hijack_detect.replay.playback import Outgoing, Playback, ReplayParameters, moved_stamp
from hijack_detect.streams.cdr import stamp_from_bytes
from hijack_detect.streams.samples import NANOSECONDS

_MILLISECOND = NANOSECONDS // 1000


class State(Enum):
    """What a player does."""

    WAITING = "waiting for subscribers"
    PLAYING = "playing"
    PAUSED = "paused"
    ENDED = "ended"


class Tick(NamedTuple):
    """A time to publish on /clock, nanoseconds."""

    ns: int


class Player:
    """The clock of a replay: gives the next event to publish.

    `due` gives the next event as soon as its time has come, and the same one again until
    `advance` is called: nothing is lost when it cannot be sent yet. A player that is late keeps
    the order and catches up.

    Attributes:
        state: What the player does.
        head: The next message, None at the end.
        published: Number of messages sent, by topic.
        passes: Number of passes that were begun.
        error: Why the replay ended before the bag's end, empty if it did not.
    """

    def __init__(
        self,
        playback: Playback,
        parameters: ReplayParameters,
        *,
        monotonic_ns: Callable[[], int] = time.monotonic_ns,
        wall_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        """Stand at the start of the first pass.

        Raises:
            BagError: The bag is damaged at its start.
            ValueError: There is nothing to publish between start and end.
        """
        self._playback = playback
        self._parameters = parameters
        self._now = monotonic_ns
        self._wall = wall_ns
        self._rate = parameters.rate
        self._period_ns = round(NANOSECONDS / parameters.clock_hz) if parameters.clock_hz else 0
        self.state = State.PAUSED if parameters.start_paused else State.WAITING
        self.published: Counter[str] = Counter()
        self.passes = 0
        self.error = ""
        self._steps = 0
        self._offset_ns: int | None = None
        self._last_log_ns: int | None = None
        self._begin_pass()
        if self.error:
            raise BagError(self.error)
        if self.head is None:
            raise ValueError(f"{playback.reader.path}: no message between start and end to publish")
        self._measured = (self._now(), self._position_ns())

    def play(self) -> None:
        """Begin, or go on."""
        if self.state in (State.WAITING, State.PAUSED):
            self._anchor(self._position_ns())
            self._anchor_stamps()
            self.state = State.PLAYING

    def pause(self) -> None:
        """Stop until `play`."""
        if self.state is not State.ENDED:
            self._anchor(self._position_ns())
            self.state = State.PAUSED

    def step(self) -> str:
        """Allow one message while paused, and return its name; empty if not paused."""
        if self.state is not State.PAUSED or self.head is None:
            return ""
        if self._offset_ns is None:
            self._anchor_stamps()
        self._anchor(self.head.log_ns)
        self._steps += 1
        if not self.head.headed:
            return f"{self.head.topic} logged at {self.head.log_ns} ns"
        return f"{self.head.topic} stamped {stamp_from_bytes(self.head.data)} ns"

    def set_rate(self, rate: float) -> None:
        """Go on at another rate."""
        self._anchor(self._position_ns())
        self._rate = rate

    def due(self) -> Tick | Outgoing | None:
        """Return the event to publish now, None without one."""
        if self.head is None or not (self.state is State.PLAYING or self._steps):
            return None
        tick = self._grid(self._position_ns())
        if tick > self._tick_ns:
            return Tick(tick + (self._offset_ns or 0))
        if self.head.log_ns > self._bag_ns():
            return None
        if self._offset_ns and self.head.headed:
            return self.head._replace(data=moved_stamp(self.head.data, self._offset_ns))
        return self.head

    def advance(self, event: Tick | Outgoing) -> None:
        """Note that the event of `due` was published."""
        if isinstance(event, Tick):
            self._tick_ns = event.ns - (self._offset_ns or 0)
            return
        self.published[event.topic] += 1
        self._last_log_ns = event.log_ns
        self._steps = max(self._steps - 1, 0)
        self._next()
        if self.head is None:
            self._end_pass()

    def wait_s(self) -> float:
        """Seconds of wall time until something is due; infinite while nothing will be."""
        if self.head is None or self.state is not State.PLAYING:
            return float("inf")
        until = min(self.head.log_ns, self._tick_ns + 1) if self._period_ns else self.head.log_ns
        return max(until - self._bag_ns(), 0) / self._rate / NANOSECONDS

    @property
    def position_s(self) -> float:
        """Seconds from the bag's first message to where the replay is."""
        return self._playback.position_s(self._position_ns())

    @property
    def end_s(self) -> float:
        """Seconds from the bag's first message to where the replay ends."""
        return self._playback.position_s(self._playback.end_ns)

    @property
    def behind_s(self) -> float:
        """Seconds of wall time by which the next message is late."""
        if self.head is None or self.state is not State.PLAYING:
            return 0.0
        return max(self._bag_ns() - self.head.log_ns, 0) / self._rate / NANOSECONDS

    def _measured_rate(self) -> float:
        """Bag seconds for each second of wall time since the last call."""
        before, (now, position) = self._measured, (self._now(), self._position_ns())
        self._measured = (now, position)
        return (position - before[1]) / max(now - before[0], 1)

    def where(self) -> str:
        """Its state and position, in words."""
        return f"{self.state.value} at {self.position_s:.3f} s of {self.end_s:.3f} s"

    def report(self) -> dict[str, str]:
        """Figures of the replay, for people."""
        rejected = self._playback.rejected.counts
        return {
            "bag": str(self._playback.reader.path),
            "position": f"{self.position_s:.3f}",
            "passes": str(self.passes),
            "rate": f"{self._rate:g}",
            "achieved rate": f"{self._measured_rate():.3f}",
            "late by": f"{self.behind_s:.3f}",
            "topics left out": str(len(self._playback.routes.skipped)),
            **{f"published {topic}": str(n) for topic, n in sorted(self.published.items())},
            **{f"refused {topic} {what}": str(n) for (topic, what), n in rejected.items()},
        }

    def _bag_ns(self) -> int:
        """Log time that should be reached now."""
        if self.state is not State.PLAYING:
            return self._anchor_bag_ns
        return self._anchor_bag_ns + round((self._now() - self._anchor_ns) * self._rate)

    def _position_ns(self) -> int:
        """Log time that is reached: it never passes a message that is still to be sent."""
        if self.head is None:
            return self._anchor_bag_ns if self._last_log_ns is None else self._last_log_ns
        return min(self._bag_ns(), self.head.log_ns)

    def _grid(self, log_ns: int) -> int:
        """Return the clock tick that covers a log time; ticks run ahead by up to one period."""
        if not self._period_ns:
            return 0
        start = self._playback.reader.start_ns
        return start + -(-(log_ns - start) // self._period_ns) * self._period_ns

    def _anchor(self, bag_ns: int) -> None:
        self._anchor_ns, self._anchor_bag_ns = self._now(), bag_ns

    def _anchor_stamps(self) -> None:
        """Move stamps so that the next message is now; they never run backwards."""
        if not self._parameters.restamp or self.head is None:
            return
        out_ns = self._wall()
        if self._last_log_ns is not None and self._offset_ns is not None:
            gap = self.head.log_ns - self._last_log_ns
            gap = gap if gap >= 0 else self._period_ns + _MILLISECOND  # a new pass
            out_ns = max(out_ns, self._last_log_ns + self._offset_ns + gap)
        self._offset_ns = out_ns - self.head.log_ns

    def _begin_pass(self) -> None:
        self._messages: Iterator[Outgoing] = self._playback.messages()
        self._tick_ns = 0
        self.passes += 1
        self._next()
        self._anchor(self._playback.start_ns)

    def _next(self) -> None:
        self.head: Outgoing | None
        try:
            self.head = next(self._messages, None)
        except BagError as error:
            self.head, self.error = None, str(error)

    def _end_pass(self) -> None:
        if self._parameters.loop and not self.error:
            self._begin_pass()
            self._anchor_stamps()
        if self.head is None:
            self.state = State.ENDED
