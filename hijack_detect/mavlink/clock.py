# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The clock of an autopilot in terms of a local one, from messages that take their time.

Local time is that of a steady clock, at the speed of the autopilot's; own time is that in the
messages of the autopilot, most often since its start. Both are integer nanoseconds, and their
difference is the offset.

An exchange (TIMESYNC) bounds the offset from both sides: the answer was written after the request
was sent and before it was received. Any other message bounds it from above: it was written before
it was received. The narrowest exchange of the last half minute is used, and without answers the
quickest message of the last ten seconds. Either moves the offset at a thousandth at most, so that
no delay of a message shows in a stamp.

The UTC of the autopilot is not used: it comes from the receiver that may be spoofed.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from hijack_detect.streams.samples import NANOSECONDS

WINDOW_NS = 30 * NANOSECONDS
"""Age at which an exchange expires. Chosen: an exchange widens by 6 ms in this time (2 * DRIFT)."""
QUICKEST_NS = 10 * NANOSECONDS
"""Window of the quickest message, used without exchanges. Chosen, not swept; between what drifts
(1 ms at DRIFT) and a link whose every message is late."""
DRIFT = 1e-4
"""Largest difference in rate of two crystals. Chosen; those of 18 logs are within 1.5e-4
(logs/receiver_clock.py)."""
SLEW = 1e-3
"""Largest rate at which the offset is moved. Chosen: ten times DRIFT; 0.01 ms between
two IMU samples."""
STEP_NS = NANOSECONDS // 4
"""An offset that is wrong by more than this is set, not moved. Chosen: 250 s of SLEW, longer than
any delay of a link; one of the clocks was set."""
FIRST, FIRST_NS = 5, NANOSECONDS
"""Exchanges before the first stamp, and the timeout of that wait. Chosen: the first exchange is
slow while processes start, and its error was stepped away with new beginnings."""
LEAP_NS = 2 * NANOSECONDS
"""An own time this far from where it should be is of another clock, or of a damaged message.
Chosen: longer than any delay of a link."""
AGREE = 3
"""Consecutive times or exchanges that replace all before. Chosen: damage rarely repeats itself."""
PENDING = 16
"""Requests whose answers are accepted. Chosen: 16 s of one a second."""


@dataclass(frozen=True, slots=True)
class _Bounds:
    """The offset is within these, as of a local time."""

    at_ns: int
    low_ns: int
    high_ns: int

    def at(self, now_ns: int) -> tuple[int, int]:
        """Bounds at another time: the clocks may have drifted."""
        drift = round(DRIFT * abs(now_ns - self.at_ns))
        return self.low_ns - drift, self.high_ns + drift

    def width(self, now_ns: int) -> int:
        low, high = self.at(now_ns)
        return high - low


class AutopilotClock:
    """Turns own times into local ones.

    Attributes:
        epoch: Counts how often the offset was set; stamps of one epoch are in order.
        newest_ns: The newest own time, None before the first.
        why: Why the offset was set the last time, for people; empty at first.
    """

    def __init__(self, speed: float = 1.0) -> None:
        """Begin without an offset.

        Args:
            speed: Seconds of the autopilot in one of the steady clock; 1 but for a simulator, in
                whose time every delay is longer.
        """
        self.epoch, self.why = 0, ""
        self._speed, self._zero_ns = speed, 0
        self._requests: deque[int] = deque(maxlen=PENDING)
        self._restart()

    def _restart(self) -> None:
        self.newest_ns: int | None = None
        self._received_ns = 0
        self._began_ns: int | None = None
        self._offset_ns: int | None = None
        self._exchanges: deque[_Bounds] = deque()
        self._against: list[_Bounds] = []
        self._quickest: deque[tuple[int, int]] = deque()
        self._leaps: list[int] = []

    @property
    def ready(self) -> bool:
        """Whether stamps can be given."""
        return self._offset_ns is not None

    def local_ns(self, now_ns: int) -> int:
        """Local time of a steady clock."""
        self._zero_ns = self._zero_ns or now_ns
        return self._zero_ns + round((now_ns - self._zero_ns) * self._speed)

    def round_trip_ns(self, now_ns: int) -> int | None:
        """How well the offset is known by now: the narrowest exchange, None without."""
        best = self._best(self.local_ns(now_ns))
        return None if best is None else best.high_ns - best.low_ns

    def request(self, now_ns: int) -> int:
        """Begin an exchange: the `ts1` of a TIMESYNC that is sent now."""
        request_ns = self.local_ns(now_ns)
        self._requests.append(request_ns)
        return request_ns

    def answer(self, own_ns: int, request_ns: int, now_ns: int) -> bool:
        """Take an answer to an exchange.

        Args:
            own_ns: The `tc1` of the TIMESYNC.
            request_ns: Its `ts1`.
            now_ns: Now, by the steady clock.

        Returns:
            Whether it was to a request of this clock, and of the same own time as the messages.
        """
        now_ns = self.local_ns(now_ns)
        if request_ns not in self._requests or self.newest_ns is None:
            return False
        self._requests.remove(request_ns)
        bounds = _Bounds(now_ns, request_ns - own_ns, now_ns - own_ns)
        if abs(own_ns - self.newest_ns) > LEAP_NS * self._speed + abs(now_ns - self._received_ns):
            return False
        best = self._best(now_ns)
        if best is None or _overlap(best.at(now_ns), bounds.at(now_ns)):
            self._against.clear()
            self._exchanges.append(bounds)
        else:
            self._against.append(bounds)
            if len(self._against) >= AGREE:
                self._exchanges = deque(self._against)
                self._against = []
        self._follow(now_ns, 0)
        return True

    def observe(self, own_ns: int, now_ns: int) -> bool:
        """Take the own time of a message as it arrives.

        Returns:
            Whether it is accepted; False for one that leaps, until others have leapt with it.
        """
        now_ns = self.local_ns(now_ns)
        if self._leapt(own_ns, now_ns):
            return False
        if self.newest_ns is None:
            self._began_ns = now_ns
            self.newest_ns = own_ns
        elapsed = now_ns - self._received_ns if self._received_ns else 0
        self._received_ns = now_ns
        self.newest_ns = max(self.newest_ns, own_ns)
        second, offset = now_ns // NANOSECONDS, now_ns - own_ns
        if self._quickest and self._quickest[-1][0] == second:
            offset = min(offset, self._quickest.pop()[1])
        self._quickest.append((second, offset))
        while (second - self._quickest[0][0]) * NANOSECONDS > QUICKEST_NS:
            self._quickest.popleft()
        self._follow(now_ns, elapsed)
        return True

    def stamp_ns(self, own_ns: int) -> int | None:
        """Local time of an own time; None until it is known."""
        return None if self._offset_ns is None else own_ns + self._offset_ns

    def _leapt(self, own_ns: int, now_ns: int) -> bool:
        """Whether an own time is impossible; restart once AGREE in a row are."""
        if self.newest_ns is None:
            return False
        ahead_ns = own_ns - self.newest_ns
        leap_ns = LEAP_NS * self._speed
        if -leap_ns <= ahead_ns <= leap_ns + max(0, now_ns - self._received_ns):
            self._leaps = []
            return False
        near = not self._leaps or 0 <= own_ns - self._leaps[-1] <= leap_ns
        self._leaps = [*self._leaps, own_ns] if near else [own_ns]
        if len(self._leaps) < AGREE:
            return True
        what = "was started again" if ahead_ns < 0 else "set its clock forward"
        self._set(f"the autopilot {what}: its time went from {_s(self.newest_ns)} to {_s(own_ns)}")
        self._restart()
        return False

    def _set(self, why: str) -> None:
        self.epoch += 1
        self.why = why

    def _best(self, now_ns: int) -> _Bounds | None:
        """The narrowest exchange that has not expired."""
        while self._exchanges and now_ns - self._exchanges[0].at_ns > WINDOW_NS:
            self._exchanges.popleft()
        return min(self._exchanges, key=lambda one: one.width(now_ns), default=None)

    def _follow(self, now_ns: int, elapsed_ns: int) -> None:
        """Move the offset towards the best estimate."""
        best = self._best(now_ns)
        waits = self._began_ns is None or now_ns - self._began_ns < FIRST_NS * self._speed
        if self._offset_ns is None and waits and len(self._exchanges) < FIRST:
            return
        if best is not None and best.high_ns - best.low_ns <= STEP_NS * self._speed:
            target = (best.low_ns + best.high_ns) // 2
        else:  # a wider exchange is worse than the quickest message
            target = min(offset for _, offset in self._quickest)
        if self._offset_ns is None:
            self._offset_ns = target
            return
        wrong = target - self._offset_ns
        if abs(wrong) > STEP_NS * self._speed:
            self._set(f"the clock of the autopilot was off by {wrong / NANOSECONDS:.3f} s")
            self._offset_ns = target
            return
        most = round(SLEW * max(0, elapsed_ns))
        self._offset_ns += min(most, max(-most, wrong))


def _overlap(one: tuple[int, int], other: tuple[int, int]) -> bool:
    return max(one[0], other[0]) <= min(one[1], other[1])


def _s(own_ns: int) -> str:
    return f"{own_ns / NANOSECONDS:.3f} s"


class InOrder:
    """A filter that passes only newer readings of each input: stamps never go back."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self._last: dict[str, tuple[int, int]] = {}

    def restart(self) -> None:
        """Forget all stamps: another epoch."""
        self._last.clear()

    def passes(self, name: str, own_ns: int, stamp_ns: int) -> bool:
        """Whether a reading is newer than the last of its input, by its own time and its stamp."""
        last = self._last.get(name)
        if last is not None and not (own_ns > last[0] and stamp_ns > last[1]):
            return False
        self._last[name] = (own_ns, stamp_ns)
        return True
