# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Places header stamps on the time of the log, also where the clock behind them jumps in flight."""

from __future__ import annotations

import dataclasses
from collections import deque
from typing import Any, Final

from hijack_detect.streams.samples import NANOSECONDS, ImuSample, Sample
from hijack_detect.streams.silence import SILENCE_S

APART_NS: Final = round(SILENCE_S * NANOSECONDS)
"""A step of the stamps as long as an outage, which the time of the log does not have."""
KEPT = 4
"""Newest offsets among which that of an output is looked for: outputs are late by seconds."""


class LogClock:
    """Takes the IMU's stamps beside the times of the log, and finds by how much they jumped.

    The IMU's clock is that of all decisions (`ReceiverClock`). Where it steps by more than
    `APART_NS` away from the time of the log, and goes on from there, a new offset begins; without
    such a step nothing is changed. A recorder that stalls makes no step: the stamps go on evenly.

    Attributes:
        adopt_first: Take off the offset that the first stamp has, as of a clock that counts from
            the start of the autopilot. Not where something else is known by such stamps; to be set
            before the first sample.
    """

    def __init__(self) -> None:
        """Start without an offset."""
        self.adopt_first = True
        self._stepped = False
        """Whether the clock may have another offset since the last stamp that had the known one."""
        self._offsets: deque[int] = deque([0], maxlen=KEPT)
        self._last: tuple[int, int] | None = None
        """Stamp of the IMU, and by how much it was ahead of the log."""
        self._log_ns = 0

    def take(self, sample: Sample, log_ns: int) -> None:
        """Take a sample and the time of the log at which it came, nanoseconds."""
        self._log_ns = log_ns
        if not isinstance(sample, ImuSample):
            return
        off_ns = sample.stamp_ns - log_ns
        last, self._last = self._last, (sample.stamp_ns, off_ns)
        if last is None:
            self._stepped = self.adopt_first
        if abs(off_ns - self._offsets[-1]) <= APART_NS:
            self._stepped = False
        elif last is not None:
            self._stepped |= abs(sample.stamp_ns - last[0]) > APART_NS
            goes_on = sample.stamp_ns > last[0] and abs(off_ns - last[1]) <= APART_NS
            if self._stepped and goes_on:
                self._stepped = False
                self._offsets.append(off_ns)

    def stamp_ns(self, stamp_ns: int) -> int:
        """The time of the log for a stamp of now or of the last seconds, nanoseconds."""
        # of two that are as near, the newer one
        return min(
            (stamp_ns - one for one in reversed(self._offsets)),
            key=lambda placed: abs(placed - self._log_ns),
        )

    def placed(self, output: Any) -> Any:
        """A sample, verdict or result with its stamp on the time of the log."""
        if len(self._offsets) == 1 and not self._offsets[0]:
            return output
        placed_ns = self.stamp_ns(output.stamp_ns)
        if placed_ns == output.stamp_ns:
            return output
        changes = {"stamp_ns": placed_ns}
        since_ns = getattr(output, "alert_since_ns", None)
        if since_ns is not None:
            changes["alert_since_ns"] = placed_ns + since_ns - output.stamp_ns
        return dataclasses.replace(output, **changes)
