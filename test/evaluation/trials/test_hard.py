# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The protocol of hard clean flights."""

from __future__ import annotations

import pickle
from collections import Counter

import pytest

from hijack_detect.evaluation.trials.protocols import FLIGHTS, hard
from hijack_detect.simulation.hard_flights import HARD_FLIGHTS


def test_every_kind_is_flown_as_often_and_none_is_attacked() -> None:
    cases = hard()
    assert Counter(case.kind for case in cases) == dict.fromkeys(HARD_FLIGHTS, FLIGHTS)
    assert all(case.scenario is None for case in cases)
    assert pickle.loads(pickle.dumps(cases)) == cases


def test_a_larger_scale_adds_flights_and_changes_none() -> None:
    more = hard(2)
    assert all(case in more for case in hard())
    assert len({case.name for case in more}) == len({case.seed for case in more}) == len(more)
    for scale in (0, 201):
        with pytest.raises(ValueError, match=f"scale is {scale}"):
            hard(scale)
