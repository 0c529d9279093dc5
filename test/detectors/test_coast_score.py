# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The score of a run of onsets: what all of them say."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.detectors.coast_bank import SLACK_S, sustained


def test_by_hand() -> None:
    """Runs of 1 s: (3, 2.5, 2), (2.5, 2, 1.5), (2, 1.5, 1); only the oldest is all large."""
    ages = np.array([3.0, 2.5, 2.0, 1.5, 1.0])
    score = np.array([4.0, 4.5, 3.0, 0.25, 2.25])
    found = sustained(ages, score, np.array([0.2, 0.2, 0.2, 0.4, 0.4]), 1.0)
    assert found is not None
    assert found.score == 3.0
    assert found.best == 1
    assert found.deviation == 0.2


def test_an_error_that_fits_one_onset_counts_for_nothing() -> None:
    ages = np.array([4.0, 3.6, 3.2, 2.8, 2.4, 2.0, 1.6, 1.2])
    for hit in range(len(ages)):
        score = np.ones(len(ages))
        score[hit] = 100.0
        found = sustained(ages, score, np.ones(len(ages)), 1.2)
        assert found is not None
        assert found.score == 1.0


@pytest.mark.parametrize("ages", [[], [1.0], [2.9, 2.0, 1.0]])
def test_nothing_is_said_before_the_onsets_span_a_run(ages: list[float]) -> None:
    assert sustained(np.array(ages), np.full(len(ages), 5.0), np.ones(len(ages)), 2.1) is None


@given(
    st.lists(st.floats(0.0, 10.0), min_size=8, max_size=20),
    st.floats(0.2, 2.0),
    st.integers(0, 10**6),
)
def test_it_is_the_largest_of_the_least(scores: list[float], span_s: float, seed: int) -> None:
    ages = [1.0 + 0.4 * k for k in reversed(range(len(scores)))]
    deviation = np.random.default_rng(seed).uniform(0.1, 1.0, size=len(scores))
    runs = [
        [k for k, other in enumerate(ages) if 0.0 <= age - other <= span_s]
        for age in ages
        if age - span_s >= 1.0 - SLACK_S
    ]
    found = sustained(np.array(ages), np.array(scores), deviation, span_s)
    assert found is not None
    assert found.score == max(min(scores[k] for k in run) for run in runs)
    assert found.deviation == min(max(deviation[k] for k in run) for run in runs)
    assert scores[found.best] >= found.score


def test_without_a_span_it_is_the_largest() -> None:
    found = sustained(np.array([3.0, 2.0, 1.0]), np.array([0.1, 0.7, 0.3]), np.ones(3), 0.0)
    assert found is not None
    assert (found.score, found.best) == (0.7, 1)
