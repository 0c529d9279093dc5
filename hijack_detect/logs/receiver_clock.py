# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Rate of an autopilot's clock, from the receiver's time, and stamps corrected by it.

ArduPilot on a BeagleBone (PXF) counted 12/13 of true time: every interval of its log is 7.7 % too
short, and the IMU never fits the GPS.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.rotation import Array

WEEK_S = 604_800.0
LEAST_ERROR = 1e-3
"""A smaller error of the rate is not corrected. Measured: crystals are within 150 ppm (18
logs of 12 vehicles), and 1000 ppm of a velocity of 10 m/s is 1 cm/s, far below its noise."""
WINDOW_S = 10.0
"""Length of a slope. Measured: arrival jitters by 10 ms rms, which makes 1e-3 of each."""
SHORTEST_S = 30.0
"""A log with less of the receiver's time is not corrected. Chosen: three slopes."""
OUTLIER_SIGMAS = 3.0
"""Chosen: the usual 3 σ."""
ROUNDS = 5
"""Fits without outliers. Chosen, not swept."""
LEAST_SPREAD_S = 1e-3
"""Smallest scatter: the resolution of logs, a millisecond."""
SHARE = 0.7
"""A line must fit this share of the fixes, or the receiver's time steps or drifts. Chosen, not
swept."""
WORST_S = 0.1
"""Largest standard deviation of the arrivals about a line. Measured: 0.02 s at most in 18 logs;
five times that, chosen."""


@dataclass(frozen=True)
class ReceiverClock:
    """Maps an autopilot's time to one that runs as the receiver's does.

    Attributes:
        rate: Seconds of the receiver in a second of the autopilot.
        anchor_ns: Autopilot's time that stays as it is, nanoseconds.
    """

    rate: float = 1.0
    anchor_ns: int = 0

    @property
    def corrects(self) -> bool:
        """Whether times change."""
        return self.rate != 1.0

    def __call__(self, own_ns: int) -> int:
        """The corrected time of the autopilot, nanoseconds."""
        if not self.corrects:
            return own_ns
        return self.anchor_ns + round((own_ns - self.anchor_ns) * self.rate)

    def remark(self) -> str:
        """The correction, in one sentence."""
        percent = 100.0 * abs(1.0 / self.rate - 1.0)
        way = "slow" if self.rate > 1.0 else "fast"
        return (
            f"the autopilot's clock runs {percent:.1f} % {way}: all stamps are corrected by the "
            "receiver's time"
        )


def receiver_clock(own_ns: Sequence[int], receiver_s: Sequence[float]) -> ReceiverClock:
    """The clock of a log from when its fixes arrived and what time they have.

    A line through arrival over receiver time; the first fixes come up to 2 s late and are dropped
    as outliers.

    Args:
        own_ns: Autopilot's time at the arrival of each fix, nanoseconds.
        receiver_s: Time of the fix by the receiver, seconds; it may wrap at the end of a week.
    """
    if len(own_ns) < 2:
        return ReceiverClock()
    own: Array = np.array([one - own_ns[0] for one in own_ns]) * 1e-9
    time: Array = np.unwrap(np.array(receiver_s, dtype=float) - receiver_s[0], period=WEEK_S)
    fresh = np.concatenate([[True], (np.diff(own) > 0.0) & (np.diff(time) > 0.0)])
    own, time = own[fresh], time[fresh]
    if own[-1] - own[0] < SHORTEST_S:
        return ReceiverClock()
    later = np.minimum(np.searchsorted(own, own + WINDOW_S), len(own) - 1)
    spans = own[later] - own
    whole = spans >= WINDOW_S
    rate = float(np.median((time[later] - time)[whole] / spans[whole]))
    apart: Array = time - rate * own
    for _ in range(ROUNDS):
        off: Array = np.abs(apart - np.median(apart))
        spread = max(1.4826 * float(np.median(off)), LEAST_SPREAD_S)
        good = off <= OUTLIER_SIGMAS * spread
        rate, start = np.polyfit(own[good], time[good], 1).tolist()
        apart = time - rate * own - start
    if spread > WORST_S or np.mean(good) < SHARE:
        return ReceiverClock()
    anchor_ns = int(own_ns[0])
    return ReceiverClock(rate, anchor_ns) if abs(rate - 1.0) > LEAST_ERROR else ReceiverClock()
