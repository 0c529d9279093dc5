# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A GPS that comes later than receivers do: from which lag on, and how that is said.

The lag is the least that the filter of `coast` (`lag_ekf`), or the differences of `date`
(`growing_lag`), admit. It is no judgement of whether the GPS is honest, and changes none: whoever
forwards signals delays them as well. It names what an alert beside it may come from.
"""

from __future__ import annotations

from collections.abc import Mapping

LATE_S = 0.33
"""A lag beyond this is named: recorded receivers have 0.02 to 0.28 s, and no flight without a late
GPS reaches it."""
GROWTH = 0.15
"""s/s. A latency grows no faster in flight: a link that fills up, 1.5 s within 10 s."""
MOST_GROWTH_S = 1.5
"""It grows by no more: what a link holds back without a loss that is seen as one."""
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

    It is the least that the GPS lags by.
    """
    return f"lags by {values[LAG]:.2f} s or more" if LAG in values else ""
