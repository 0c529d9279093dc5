# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Receiver operating characteristic: what every threshold on a score would give.

A flight has one score. The curve says which part of the hijacked flights lies at or above a
threshold, over the part of the clean flights that does. It is about scores alone: persistence,
and whether an alarm came before the onset, are in the correctness and not in the curve.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.stats import rankdata

Curve = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]


def roc_area(clean: Sequence[float], hijacked: Sequence[float]) -> float | None:
    """Probability that a hijacked flight has the higher score, ties count half.

    It is the statistic of Mann and Whitney over the number of pairs; None without flights of
    both sorts.
    """
    pairs = len(clean) * len(hijacked)
    if not pairs:
        return None
    ranks = rankdata(np.concatenate([hijacked, clean]))[: len(hijacked)]
    return float(ranks.sum() - len(hijacked) * (len(hijacked) + 1) / 2) / pairs


def roc_curve(clean: Sequence[float], hijacked: Sequence[float]) -> Curve:
    """Parts of the clean and of the hijacked flights at or above each threshold, from 0 to 1.

    Both lists must have an element.
    """
    thresholds = np.unique(np.concatenate([clean, hijacked]))[::-1]
    parts = [
        np.mean(np.asarray(scores)[:, np.newaxis] >= thresholds, axis=0)
        for scores in (clean, hijacked)
    ]
    false, true = (np.concatenate([[0.0], part]) for part in parts)
    return false, true
