# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Merging several inputs into one stream ordered by header stamp.

Topics arrive in any order relative to each other. A sample is released once every input that
is alive has passed its stamp, so the released order, and with it every decision, depends on
stamps alone and not on when a message happened to arrive.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from hijack_detect.parameters import param
from hijack_detect.streams.samples import NANOSECONDS


def sensor_patience() -> Any:
    """Declare how long a part that hears sensors waits for one of them."""
    return param(
        SENSOR_PATIENCE_S,
        "How long to wait for a sensor that has gone silent, on the stamps of the others. For "
        "replays faster than real time far larger.",
        source="what counts as an outage (2 s), and the skew of what comes after it (1 s)",
        unit="s",
        low=SENSOR_PATIENCE_S,
        high=3600.0,
    )


SILENCE_S = 2.0
"""An input without a sample for this long, on its own stamps, has had an outage.
Chosen, not swept."""
SKEW_S = 1.0
"""After an outage the samples of this time are left out: whether they arrive before the other
inputs have moved on is a matter of luck."""
RESTART_S = 5.0
"""A clock that runs back by more than this is that of a new recording."""
CLOCKS = ("imu", "attitude")
"""Inputs that tell when the clock behind all stamps was set back: they have the stamps of the
IMU, which no attacker of the receiver can reach."""
SET_BACK_S = 0.1
"""The stamps of CLOCKS never run back so far for another reason. Chosen, not swept."""
SENSOR_PATIENCE_S = SILENCE_S + SKEW_S
"""How long to wait for a sensor that has gone silent, on the stamps of the other inputs."""


class Stamped(Protocol):
    """Anything with a header stamp in nanoseconds."""

    @property
    def stamp_ns(self) -> int:
        """Header stamp, nanoseconds."""


S = TypeVar("S", bound=Stamped)


@dataclass
class _Input:
    index: int
    patience_ns: int
    restart_ns: int
    latest_ns: int | None = None
    doubted_ns: int | None = None
    """A stamp that did not follow on the one before; the next one shows which was right."""
    joins_at_ns: int | None = None
    silent_until_ns: int = 0
    """No sample will come with a stamp up to this one."""


class StreamMerge(Generic[S]):
    """Orders the samples of named inputs by stamp; ties go in the order of the names.

    An input that stays silent is waited for as long as its patience, on the stamps of the
    others, and then no longer. Provided that no input is delivered later than that, the output
    is a function of the stamps alone; a larger patience costs time only while an input is silent.

    A stamp that does not increase is refused and counted. One that leaves a gap, or runs far
    backwards, is left out until the next sample of its input follows on it, so that a single
    broken stamp changes nothing. After a gap the input joins again one second later, after a
    jump backwards (a looped bag, a clock that was set) everything begins afresh, and
    `restarted` is true for that call; with one of CLOCKS a small jump is enough.
    """

    def __init__(self, patience_s: Mapping[str, float]) -> None:
        """Make a merge of inputs, given how long to wait for each, in seconds."""
        self._silence_ns = round(SILENCE_S * NANOSECONDS)
        self._skew_ns = round(SKEW_S * NANOSECONDS)
        self.refused: Counter[str] = Counter()
        """Samples left out, by reason."""
        self.out_of_order = False
        """True when the last `push` left its sample out for the stamps of its own input."""
        self.restarted = False
        """True when the last `push` began a new recording."""
        self.set_patience(patience_s)
        self._begin()

    def set_patience(self, patience_s: Mapping[str, float]) -> None:
        """Change how long to wait for each input from the next recording on, in seconds."""
        self._patience_ns = {name: round(s * NANOSECONDS) for name, s in patience_s.items()}

    def _begin(self) -> None:
        self._inputs = {
            name: _Input(
                index, patience, round((SET_BACK_S if name in CLOCKS else RESTART_S) * NANOSECONDS)
            )
            for index, (name, patience) in enumerate(self._patience_ns.items())
        }
        self._waiting: list[tuple[int, int, str, S]] = []
        self._first_ns: int | None = None
        self._newest_ns = 0
        self._released_ns: int | None = None
        self._slowest: _Input | None = None
        """The input that holds the others up; None where that has to be found out."""
        self._certain_ns = self._waited_until_ns = 0

    def push(self, name: str, sample: S) -> list[tuple[str, S]]:
        """Take one sample; return the samples that became certain, in order of stamp."""
        self.restarted = self.out_of_order = False
        stamp = sample.stamp_ns
        if not self._follows(name, stamp):
            return []
        source = self._inputs[name]
        if source.latest_ns is None:
            self._begin_input(source, stamp)
        source.latest_ns = stamp
        self._newest_ns = max(self._newest_ns, stamp)
        if self._released_ns is not None and stamp <= self._released_ns:
            self.refused[f"{name}: arrived too late"] += 1
        elif source.joins_at_ns is not None and stamp < source.joins_at_ns:
            self.refused[f"{name}: rejoining after an outage"] += 1
        else:
            heapq.heappush(self._waiting, (stamp, source.index, name, sample))
        return self._released(self._certain_until(source, stamp))

    def push_run(self, name: str, samples: Sequence[S]) -> tuple[int, list[tuple[str, S]]]:
        """Take samples of one input that follow on it and on each other, for the price of one.

        Returns:
            How many of the first samples were taken, and what became certain. The next one, if
            any is left, must be given to `push`, which knows what to do with its stamp.
        """
        self.restarted = self.out_of_order = False
        source = self._inputs[name]
        latest_ns, doubted = source.latest_ns, source.doubted_ns is not None
        if latest_ns is None or doubted:
            return 0, []
        taken, earliest_ns = 0, max(self._released_ns or 0, (source.joins_at_ns or 0) - 1)
        for sample in samples:
            stamp_ns = sample.stamp_ns
            if not 0 < stamp_ns - latest_ns <= self._silence_ns or stamp_ns <= earliest_ns:
                break
            heapq.heappush(self._waiting, (stamp_ns, source.index, name, sample))
            latest_ns = stamp_ns
            taken += 1
        if not taken:
            return 0, []
        source.latest_ns = latest_ns
        self._newest_ns = max(self._newest_ns, latest_ns)
        return taken, self._released(self._certain_until(source, latest_ns))

    def advance(self, name: str, stamp_ns: int) -> list[tuple[str, S]]:
        """Take it that no sample of an input will come with a stamp up to this one.

        Who makes the samples may know, long before the next one is there. That changes neither
        what is released nor the order, only how early.
        """
        self.restarted = self.out_of_order = False
        source = self._inputs[name]
        if source.latest_ns is None or stamp_ns <= source.silent_until_ns:
            return []
        source.silent_until_ns = stamp_ns
        if source is not self._slowest:
            return []
        return self._released(self._certain_until(source, stamp_ns))

    @property
    def certain_ns(self) -> int:
        """Stamp up to which everything has been released; 0 before the first sample."""
        return self._certain_ns

    def _released(self, certain_ns: int) -> list[tuple[str, S]]:
        released: list[tuple[str, S]] = []
        while self._waiting and self._waiting[0][0] <= certain_ns:
            self._released_ns, _, name, sample = heapq.heappop(self._waiting)
            released.append((name, sample))
        return released

    def _follows(self, name: str, stamp: int) -> bool:
        """Whether the stamp follows on those before it, of this or of a new recording."""
        source = self._inputs[name]
        latest, doubted = source.latest_ns, source.doubted_ns
        if latest is None or 0 < stamp - latest <= self._silence_ns:
            source.doubted_ns = None
            return True
        if 0 <= latest - stamp <= source.restart_ns:
            self._refuse(name, "stamp does not increase")
            return False
        if doubted is None or not 0 < stamp - doubted <= self._silence_ns:
            source.doubted_ns = stamp
            self._refuse(name, "stamp jumps")
            return False
        if stamp < latest:
            self._begin()
            self.restarted = True
        else:
            source.doubted_ns = None
            source.joins_at_ns = stamp + self._skew_ns
        return True

    def _refuse(self, name: str, reason: str) -> None:
        self.refused[f"{name}: {reason}"] += 1
        self.out_of_order = True

    def _begin_input(self, source: _Input, stamp: int) -> None:
        """Take note of the first stamp of an input."""
        if self._first_ns is None:
            self._first_ns = self._newest_ns = stamp
        self._slowest = None
        self._first_ns = min(self._first_ns, stamp)
        if stamp - self._first_ns > self._silence_ns:
            source.joins_at_ns = stamp + self._skew_ns

    def _certain_until(self, heard: _Input, stamp: int) -> int:
        """Newest stamp that every input which is still waited for has passed.

        It moves on only with the slowest input, or when that has been waited for long enough; and
        back, with one that had been given up.
        """
        slowest = self._slowest
        known = slowest is not None and slowest is not heard and stamp >= self._certain_ns
        if not known or self._newest_ns > self._waited_until_ns:
            self._find_slowest()
        return self._certain_ns

    def _find_slowest(self) -> None:
        """Look at every input; none is the slowest if the newest stamp is certain."""
        assert self._first_ns is not None
        self._certain_ns, self._slowest = self._newest_ns, None
        for source in self._inputs.values():
            latest = source.latest_ns
            since, passed = self._first_ns, self._first_ns - 1
            if latest is not None:
                since, passed = latest, max(latest, source.silent_until_ns)
            if self._newest_ns - since > source.patience_ns:
                continue
            if source.joins_at_ns is not None:  # nothing of it is let in before
                passed = max(passed, source.joins_at_ns - 1)
            if passed < self._certain_ns:
                self._certain_ns, self._slowest = passed, source
                self._waited_until_ns = since + source.patience_ns
