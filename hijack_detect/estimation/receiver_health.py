# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a GPS receiver is worth by its own word: lost fixes, satellites, claimed accuracy.

It is no judgement of whether the GPS is honest, and changes none: an attacker jams first. It names
what the receiver itself admits, so that a bad sky is not taken for an attack, and so that an
alert beside it is read with the doubt that it deserves.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

from hijack_detect.streams.samples import NANOSECONDS, FixSample, SatelliteSample

MINUTE_NS = 60 * NANOSECONDS
"""Lost fixes are counted over this time. Chosen, not swept."""
SHORT_NS = 10 * NANOSECONDS
"""Satellites and accuracy are poor if most fixes of this time are (PX4 waits as long for its own
checks, EKF2_REQ_GPS_H): one fix behind a tree is no poor receiver."""
LEAST_FIXES = 5
"""Fewer fixes show nothing of satellites and accuracy. Chosen, not swept."""
SILENT_NS = 3 * NANOSECONDS // 2
"""A receiver that sends nothing for this long has lost its fix: it sends one a second at least."""
HOLE_NS = 2 * NANOSECONDS
"""A step of all stamps this long is a hole of the recording, not an outage of the receiver.
Chosen, not swept."""

POOR = "the receiver is poor by its own word"
NO_FIX, ACCURACY, VERTICAL, SATELLITES = (
    "poor_no_fix",
    "poor_accuracy",
    "poor_vertical_accuracy",
    "poor_satellites",
)
"""Figures beyond their limits: s of the last minute, m, m, number."""
POOR_FIGURES = frozenset({NO_FIX, ACCURACY, VERTICAL, SATELLITES})


@dataclass(frozen=True)
class ReceiverLimits:
    """Limits of a poor receiver; see `GnssSanityParameters`."""

    no_fix_s: float
    accuracy_m: float
    vertical_accuracy_m: float
    satellites: int


class ReceiverHealth:
    """Follows the messages of one receiver, in order of stamp."""

    def __init__(self, limits: ReceiverLimits) -> None:
        """Start without messages."""
        self._limits = limits
        self._passed_ns: int | None = None
        self._fix: FixSample | None = None
        """The last message of the receiver, with a fix or without."""
        self._lost: deque[tuple[int, int]] = deque()
        """Stamp, and nanoseconds without a fix up to it."""
        self._lost_ns = 0
        self._recent: deque[tuple[int, float | None, float | None, int | None]] = deque()
        """Stamp, claimed accuracies (m) and satellites of each fix."""
        self._count: SatelliteSample | None = None

    def satellites(self, sample: SatelliteSample) -> None:
        """Note the number of satellites, which is that of the fixes up to a second later."""
        self._count = sample

    def fix(self, fix: FixSample) -> None:
        """Take a message of the receiver, with a fix or without."""
        self.passes(fix.stamp_ns)
        self._fix = fix
        if not fix.has_fix:
            return
        count = self._count
        fresh = count is not None and fix.stamp_ns - count.stamp_ns <= NANOSECONDS
        self._recent.append(
            (
                fix.stamp_ns,
                fix.accuracy_m,
                fix.vertical_accuracy_m if fix.has_altitude else None,
                count.count if count is not None and fresh else None,
            )
        )

    def unclear(self) -> None:
        """Note a message without a usable stamp: the receiver is not silent."""
        self._fix = None

    def passes(self, stamp_ns: int) -> None:
        """Note that time passes, by the stamp of any input."""
        before_ns, self._passed_ns = self._passed_ns, max(stamp_ns, self._passed_ns or stamp_ns)
        last = self._fix
        if before_ns is not None and last is not None and 0 < stamp_ns - before_ns <= HOLE_NS:
            silent = stamp_ns - last.stamp_ns > SILENT_NS
            if silent or not last.has_fix:
                self._lost.append((stamp_ns, stamp_ns - before_ns))
                self._lost_ns += stamp_ns - before_ns
        while self._lost and self._lost[0][0] <= stamp_ns - MINUTE_NS:
            self._lost_ns -= self._lost.popleft()[1]
        while self._recent and self._recent[0][0] <= stamp_ns - SHORT_NS:
            self._recent.popleft()

    def poor(self) -> dict[str, float]:
        """The figures beyond their limits, by name; empty while the receiver is good."""
        limits, found = self._limits, {}
        lost_s = self._lost_ns / NANOSECONDS
        if lost_s >= limits.no_fix_s:
            found[NO_FIX] = lost_s
        accuracy = _middle([across for _, across, _, _ in self._recent])
        if accuracy is not None and accuracy > limits.accuracy_m:
            found[ACCURACY] = accuracy
        vertical = _middle([up for _, _, up, _ in self._recent])
        if vertical is not None and vertical > limits.vertical_accuracy_m:
            found[VERTICAL] = vertical
        count = _middle([count for _, _, _, count in self._recent])
        if count is not None and count < limits.satellites:
            found[SATELLITES] = count
        return found


def poor_words(figures: Mapping[str, float]) -> str:
    """Figures beyond their limits in words; others are passed over, empty without any."""
    words = {
        NO_FIX: "no fix for {:.0f} s of a minute",
        ACCURACY: "claims an accuracy of {:.1f} m",
        VERTICAL: "claims an accuracy of {:.1f} m in height",
        SATELLITES: "{:.0f} satellites",
    }
    return ", ".join(text.format(figures[name]) for name, text in words.items() if name in figures)


def _middle(values: list[float | None] | list[int | None]) -> float | None:
    """The upper median of what is known; None of fewer than `LEAST_FIXES`."""
    known = sorted(one for one in values if one is not None)
    return known[len(known) // 2] if len(known) >= LEAST_FIXES else None
