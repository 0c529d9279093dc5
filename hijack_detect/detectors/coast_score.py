# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From scores of many onsets to one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.rotation import Array

SLACK_S = 0.15
"""A run may fall short of its span by so much: onsets begin with a fix."""


@dataclass(frozen=True, slots=True)
class Sustained:
    """What a whole run of successive onsets says.

    Attributes:
        score: The least within the run.
        best: Index of the onset in the run with the largest.
        deviation: The least deviation for which every onset of some run speaks: times a limit,
            the smallest offset that exceeds it.
    """

    score: float
    best: int
    deviation: float


def sustained(age_s: Array, score: Array, deviation: Array, span_s: float) -> Sustained | None:
    """The run of onsets over `span_s` whose least score is the largest.

    An attack is seen from every onset about its own. An error that is over fits one onset only,
    the one that begins with it, and is no attack however large it is.

    Args:
        age_s: Ages of the onsets, s, shape (n,).
        score: Their scores, shape (n,).
        deviation: The offset with a score of 1, shape (n,).
        span_s: Length of a run, s.

    Returns:
        None as long as the onsets do not span a run.
    """
    younger = age_s[:, None] - age_s[None, :]
    inside = (younger >= 0.0) & (younger <= span_s)
    whole = np.flatnonzero(age_s - span_s >= np.min(age_s, initial=np.inf) - SLACK_S)
    if len(whole) == 0:
        return None
    inside = inside[whole]
    least = np.min(np.where(inside, score, np.inf), axis=1)
    run = int(np.argmax(least))
    best = int(np.argmax(np.where(inside[run], score, -np.inf)))
    visible = np.max(np.where(inside, deviation, 0.0), axis=1)
    return Sustained(float(least[run]), best, float(np.min(visible)))
