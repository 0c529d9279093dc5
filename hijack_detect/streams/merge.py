"""Merging several inputs into one stream ordered by header stamp.

Topics arrive in any order relative to each other. A sample is released once every input that
is alive has passed its stamp, so the released order, and with it every decision, depends on
stamps alone and not on when a message happened to arrive.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from hijack_detect.streams.samples import NANOSECONDS


class Stamped(Protocol):
    """Anything with a header stamp in nanoseconds."""

    @property
    def stamp_ns(self) -> int:
        """Header stamp, nanoseconds."""


S = TypeVar("S", bound=Stamped)


@dataclass
class _Input:
    index: int
    latest_ns: int | None = None
    joins_at_ns: int | None = None
    """After an outage, samples before this stamp are left out: see `StreamMerge`."""


class StreamMerge(Generic[S]):
    """Orders the samples of named inputs by stamp; ties go in the order of the names.

    An input that stays silent for `silence_s` plus `skew_s` (on the stamps of the others) is
    no longer waited for. When it returns after more than `silence_s`, its samples of the first
    `skew_s` are left out, because whether they arrive before the others have moved on is a
    matter of luck. Provided that no input is delivered more than `skew_s` later than another,
    the output is a function of the stamps alone.

    A stamp that does not increase is refused and counted. One that runs backwards by more than
    `restart_s` is a new recording (a looped bag, a clock that was set): `restarted` becomes
    true for that call and everything begins afresh, so that a bad clock never silences an input.
    """

    def __init__(
        self,
        names: Sequence[str],
        *,
        silence_s: float = 2.0,
        skew_s: float = 1.0,
        restart_s: float = 5.0,
    ) -> None:
        """Make a merge of the named inputs."""
        self._names = tuple(names)
        self._silence_ns = round(silence_s * NANOSECONDS)
        self._skew_ns = round(skew_s * NANOSECONDS)
        self._restart_ns = round(restart_s * NANOSECONDS)
        self.refused: Counter[str] = Counter()
        """Samples left out, by reason."""
        self.restarted = False
        """True when the last `push` began a new recording."""
        self._begin()

    def _begin(self) -> None:
        self._inputs = {name: _Input(index) for index, name in enumerate(self._names)}
        self._waiting: list[tuple[int, int, str, S]] = []
        self._first_ns: int | None = None
        self._newest_ns = 0
        self._released_ns: int | None = None

    def push(self, name: str, sample: S) -> list[tuple[str, S]]:
        """Take one sample; return the samples that became certain, in order of stamp."""
        stamp = sample.stamp_ns
        source = self._inputs[name]
        self.restarted = False
        if source.latest_ns is not None and stamp <= source.latest_ns:
            if source.latest_ns - stamp <= self._restart_ns:
                self.refused[f"{name}: stamp does not increase"] += 1
                return []
            self.refused[f"{name}: clock ran backwards, started afresh"] += 1
            self._begin()
            self.restarted = True
            source = self._inputs[name]
        if self._first_ns is None:
            self._first_ns = self._newest_ns = stamp
        since = self._first_ns if source.latest_ns is None else source.latest_ns
        if stamp - since > self._silence_ns:
            source.joins_at_ns = stamp + self._skew_ns
        source.latest_ns = stamp
        self._newest_ns = max(self._newest_ns, stamp)
        if self._released_ns is not None and stamp <= self._released_ns:
            self.refused[f"{name}: arrived too late"] += 1
        elif source.joins_at_ns is not None and stamp < source.joins_at_ns:
            self.refused[f"{name}: rejoining after an outage"] += 1
        else:
            heapq.heappush(self._waiting, (stamp, source.index, name, sample))
        return list(self._release())

    def _release(self) -> Iterator[tuple[str, S]]:
        certain_ns = self._certain_until()
        while self._waiting and self._waiting[0][0] <= certain_ns:
            stamp, _, name, sample = heapq.heappop(self._waiting)
            self._released_ns = stamp
            yield name, sample

    def _certain_until(self) -> int:
        """Newest stamp that every input which is still waited for has passed."""
        assert self._first_ns is not None
        certain = self._newest_ns
        for source in self._inputs.values():
            since = self._first_ns if source.latest_ns is None else source.latest_ns
            if self._newest_ns - since <= self._silence_ns + self._skew_ns:
                certain = min(certain, since if source.latest_ns is not None else since - 1)
        return certain
