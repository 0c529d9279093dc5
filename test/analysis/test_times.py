# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Sets of times against sets of single stamps."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.analysis.alarms import Times

STAMPS = st.integers(0, 30)
INTERVALS = st.lists(st.tuples(STAMPS, STAMPS), max_size=6)


def stamps(intervals: list[tuple[int, int]]) -> set[int]:
    return {stamp for start, end in intervals for stamp in range(start, end)}


@given(INTERVALS, INTERVALS, STAMPS)
def test_operations_are_those_of_sets(
    one: list[tuple[int, int]], other: list[tuple[int, int]], at: int
) -> None:
    first, second = Times(one), Times(other)
    assert stamps((first | second).intervals) == stamps(one) | stamps(other)
    assert stamps((first & second).intervals) == stamps(one) & stamps(other)
    assert stamps((first - second).intervals) == stamps(one) - stamps(other)
    assert stamps(first.before(at).intervals) == {stamp for stamp in stamps(one) if stamp < at}


@given(INTERVALS)
def test_intervals_are_disjoint_and_in_order_and_count_once(one: list[tuple[int, int]]) -> None:
    times = Times(one)
    assert all(start < end for start, end in times.intervals)
    assert all(before[1] < after[0] for before, after in pairwise(times.intervals))
    assert Times((a * 10**9, b * 10**9) for a, b in one).seconds == len(stamps(one))
