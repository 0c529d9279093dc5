# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A GPS that comes later than receivers do: from which lag on, and how that is said.

The lag is the one that the filter of `coast` has learnt (`lag_ekf`). It is no judgement of whether
the GPS is honest, and changes none: whoever forwards signals delays them as well. It names what an
alert beside it may come from, for a filter that cannot follow takes manoeuvres for accelerations.
"""

from __future__ import annotations

from collections.abc import Mapping

LATE_S = 0.33
"""A lag beyond this is named: recorded receivers have 0.02 to 0.28 s, and no flight without a late
GPS reaches it. From 0.38 s on the filter cannot follow (`ModelErrors.max_lag_s`)."""
LATE = "the GPS is late"
LAG = "late_gps"
"""Value: the lag, s, where it is beyond LATE_S."""
LATE_FIGURES = frozenset({LAG})


def late(*lags_s: float) -> dict[str, float]:
    """The largest of some lags as a value of a verdict; empty unless it is beyond LATE_S."""
    lag_s = max(lags_s)
    return {LAG: lag_s} if lag_s > LATE_S else {}


def late_words(values: Mapping[str, float]) -> str:
    """A lag beyond its limit in words, empty without one.

    The filter follows slowly and up to a bound, so it is the least that the GPS lags by.
    """
    return f"lags by {values[LAG]:.2f} s or more" if LAG in values else ""
