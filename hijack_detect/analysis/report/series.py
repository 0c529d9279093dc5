# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Makes curves fit to be drawn: fewer points without losing a peak, and angles without jumps."""

from __future__ import annotations

import numpy as np

from hijack_detect.analysis.report.curve import Array, Curve

MOST_POINTS = 3000
"""Points of a curve: more than a screen has pixels."""


def thinned(curve: Curve, most: int = MOST_POINTS) -> Curve:
    """A curve with fewer points: of each bin its smallest and largest value, and one gap."""
    count = len(curve.time_s)
    if count <= most:
        return curve
    kept: list[int] = []
    for part in np.array_split(np.arange(count), most // 3):
        values = curve.value[part]
        gaps = np.isnan(values)
        chosen = {int(part[gaps][0])} if gaps.any() else set()
        if not gaps.all():
            chosen |= {int(part[np.nanargmin(values)]), int(part[np.nanargmax(values)])}
        kept += sorted(chosen)
    return Curve(curve.time_s[kept], curve.value[kept])


def lonely(curve: Curve) -> Curve:
    """The points between two gaps, which a line does not show."""
    gap = np.concatenate([[True], np.isnan(curve.value), [True]])
    alone = ~gap[1:-1] & gap[:-2] & gap[2:]
    return Curve(curve.time_s[alone], curve.value[alone])


def emptiest_direction(angles: Array) -> float:
    """Where a circle is cut best: the middle of the widest arc without any angle, degrees.

    Args:
        angles: Degrees within [0, 360), NaN where unknown.
    """
    known = np.sort(angles[~np.isnan(angles)])
    if not len(known):
        return 360.0
    gaps = np.diff(known, append=known[0] + 360.0)
    widest = int(np.argmax(gaps))
    return float(known[widest] + gaps[widest] / 2.0) % 360.0 or 360.0


def cut_at(curve: Curve, cut: float) -> Curve:
    """Angles within [cut - 360, cut) degrees, with a gap wherever the curve crosses the cut."""
    value = (curve.value - cut) % 360.0 + cut - 360.0
    jumps = np.flatnonzero(np.abs(np.diff(value)) > 180.0) + 1
    return Curve(
        np.insert(curve.time_s, jumps, curve.time_s[jumps]), np.insert(value, jumps, np.nan)
    )
