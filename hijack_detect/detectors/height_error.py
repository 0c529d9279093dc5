# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""By how much GPS height and barometer part without an attack: a Gauss-Markov error."""

from __future__ import annotations

import math

from hijack_detect.detectors.altitude_parameters import AltitudeParameters
from hijack_detect.estimation.learning import LearnedLevel
from hijack_detect.streams.samples import NANOSECONDS, FixSample

VERTICAL_OF_HORIZONTAL = 1.7
"""Vertical over horizontal deviation of a receiver under an open sky (VDOP over HDOP).
Chosen, not swept."""
GOOD_SHARE = 0.6
POOR_CLAIM = 3.0
"""Of recorded receivers those that claim less than 7.5 m changed by 0.1 to 0.8 of it within a
minute (root mean square), two that claim 10 m by 1.5. So the share of the claim that is allowed
for grows from GOOD_SHARE to 1 at a claim of POOR_CLAIM times the deviation of a poor pair."""
PROVED_NS = 80 * NANOSECONDS
"""A receiver is worth no more than its claim until a wander of a minute would have been learnt:
the longest horizon, and `learning.LEVEL_DELAY_S`."""
CEILING_OF_CLAIM = 2.0
"""What a receiver may be seen to wander by is bounded by this many times its claim.
Chosen, not swept."""


def claimed_height(fix: FixSample) -> float | None:
    """Standard deviation of the height that the receiver claims, m; None if it claims none."""
    if fix.vertical_accuracy_m is not None:
        return fix.vertical_accuracy_m
    return None if fix.accuracy_m is None else VERTICAL_OF_HORIZONTAL * fix.accuracy_m


class HeightError:
    """Error of the difference between GPS height and barometer, for this receiver.

    A Gauss-Markov process of deviation σ and time constant τ (Gelb 1974, section 3.8) beside white
    noise n: over h seconds a change of `height_sigmas √(n² + 2σ²(1 − exp(−h/τ)))` is normal. σ and
    n are `part` times those of a poor pair. The part is learnt from the changes of the flight's
    past, see `LearnedLevel`, and is at least a share of what the receiver claims; in its first
    80 s in the air all of it. Claims alone raise it up to `baro_ceiling`, wander that is
    seen besides up to `baro_highest`.

    How far a height wanders in minutes is not learnt in time. The limit of the distance from a
    reference is that of the claim, where it is more than the learnt one.
    """

    def __init__(self, parameters: AltitudeParameters) -> None:
        """Nothing is claimed or learnt yet."""
        self._p = p = parameters
        self._learned = LearnedLevel(p.baro_floor, p.baro_gain, p.baro_ceiling)
        self._claimed = 0.0
        """Claimed deviation over that of a poor pair, at most POOR_CLAIM."""
        self._last_ns: int | None = None

    def claim(self, fix: FixSample) -> None:
        """Take the accuracy that the receiver claims with a fix.

        An error outlives the claim by its time constant.
        """
        p = self._p
        last_ns, self._last_ns = self._last_ns, fix.stamp_ns
        if last_ns is not None:
            self._claimed *= math.exp((last_ns - fix.stamp_ns) / NANOSECONDS / p.wander_s)
        now = min(POOR_CLAIM, (claimed_height(fix) or 0.0) / p.wander_m)
        self._claimed = max(self._claimed, now)
        seen = min(p.baro_highest, CEILING_OF_CLAIM * self._claimed)
        self._learned.ceiling = max(p.baro_ceiling, seen)

    def learn(self, stamp_ns: int, rise: float, fall: float, *, moving: bool) -> None:
        """Note the largest changes upwards and downwards, in those of a poor pair.

        Args:
            stamp_ns: Stamp of the changes.
            rise: Largest change upwards over `poor` of its horizon.
            fall: The same downwards.
            moving: See `LearnedLevel.add`.
        """
        self._learned.add(stamp_ns, rise, moving=moving, opposite=fall)

    @property
    def part(self) -> float:
        """What is normal now over what is normal of a poor pair."""
        share = 1.0
        if self._learned.moved_ns >= PROVED_NS:
            share = min(1.0, max(GOOD_SHARE, self._claimed / POOR_CLAIM))
        return max(self._learned.part, min(self._p.baro_ceiling, share * self._claimed))

    @property
    def sigma(self) -> float:
        """Deviation σ that is allowed now, metres."""
        return self.part * self._p.wander_m

    def poor(self, horizon_s: float) -> float:
        """Change that is normal of a poor pair over a horizon, metres."""
        p = self._p
        wander = 2.0 * p.wander_m**2 * -math.expm1(-horizon_s / p.wander_s)
        return p.height_sigmas * math.sqrt(p.height_noise_m**2 + wander)

    def total(self) -> float:
        """Distance from a reference of minutes ago that is normal now, metres."""
        claimed = min(self._p.baro_ceiling, self._claimed) * self.poor(math.inf)
        return max(self._p.baro_total_m * max(1.0, self.part), claimed)
