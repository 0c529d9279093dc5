# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attitudes of the interval between two GPS velocities."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.detectors.attitude_window import HOLE_NS, AttitudeMeans, AttitudeWindow
from hijack_detect.estimation.rotation import matrices
from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample

MS = NANOSECONDS // 1000


def attitude(stamp_ns: int) -> AttitudeSample:
    return AttitudeSample(
        stamp_ns, (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 9.8), math.inf
    )


def window(*stamps_ns: int, kept_s: float = 3.0) -> AttitudeWindow:
    one = AttitudeWindow(kept_s)
    for stamp_ns in stamps_ns:
        one.add(attitude(stamp_ns))
    return one


def taken(one: AttitudeWindow, start_ns: int, end_ns: int) -> list[int]:
    return [sample.stamp_ns for sample in one.take(start_ns, end_ns)]


def test_an_interval_has_its_end_and_not_its_start() -> None:
    one = window(*range(0, 1001 * MS, 100 * MS))
    assert taken(one, 0, 200 * MS) == [100 * MS, 200 * MS]
    assert taken(one, 200 * MS, 450 * MS) == [300 * MS, 400 * MS]
    assert taken(one, 450 * MS, 600 * MS) == [500 * MS, 600 * MS]


@pytest.mark.parametrize(
    "stamps",
    [
        (0, 100, 500, 600),  # in the middle
        (400, 500, 600),  # at the start
        (100, 200),  # at the end
        (),
    ],
)
def test_an_interval_with_a_hole_has_no_attitudes(stamps: tuple[int, ...]) -> None:
    assert taken(window(*(one * MS for one in stamps)), 0, 600 * MS) == []


def test_a_hole_is_longer_than_six_samples_of_the_slowest_imu() -> None:
    assert taken(window(HOLE_NS), 0, 2 * HOLE_NS) == [HOLE_NS]
    assert taken(window(HOLE_NS + 1), 0, 2 * HOLE_NS) == []


def test_after_a_hole_the_next_interval_is_whole() -> None:
    one = window(100 * MS, 900 * MS, 1000 * MS, 1100 * MS, 1200 * MS)
    assert taken(one, 0, 1000 * MS) == []
    assert taken(one, 1000 * MS, 1200 * MS) == [1100 * MS, 1200 * MS]


def test_attitudes_older_than_the_window_are_forgotten() -> None:
    one = window(*range(0, 5001 * MS, 100 * MS))
    assert taken(one, 1000 * MS, 2000 * MS) == []
    assert taken(one, 2000 * MS, 2200 * MS) == [2100 * MS, 2200 * MS]


@given(
    st.lists(st.integers(1, 400), min_size=1, max_size=60),
    st.lists(st.integers(1, 1500), min_size=1, max_size=10),
)
def test_each_attitude_is_given_once_and_only_in_intervals_without_holes(
    steps_ms: list[int], intervals_ms: list[int]
) -> None:
    stamps = [sum(steps_ms[: n + 1]) * MS for n in range(len(steps_ms))]
    one, start, found = window(*stamps, kept_s=100.0), 0, []
    for length in intervals_ms:
        end = start + length * MS
        within = [at for at in stamps if start < at <= end]
        ends = [start, *within, end]
        whole = all(b - a <= HOLE_NS for a, b in pairwise(ends))
        got = taken(one, start, end)
        assert got == (within if whole else [])
        found += got
        start = end
    assert len(found) == len(set(found))


def turning(stamp_ns: int, *, known: bool = True) -> AttitudeSample:
    """An attitude whose orientation and force differ from those of every other stamp."""
    half = 1e-9 * stamp_ns
    orientation = (0.0, 0.6 * math.sin(half), 0.8 * math.sin(half), math.cos(half))
    force = (math.sin(3.0 * half), math.cos(5.0 * half), 9.8 + half)
    return AttitudeSample(stamp_ns, orientation if known else None, 0.0, (0.0, 0.0, 0.0), force)


@given(
    st.lists(st.tuples(st.integers(1, 400), st.booleans()), min_size=1, max_size=60),
    st.lists(st.integers(1, 900), min_size=1, max_size=10),
    st.lists(st.integers(0, 1500), min_size=1, max_size=6),
)
def test_means_are_those_of_the_attitudes_of_each_interval_to_the_bit(
    steps_ms: list[tuple[int, bool]], intervals_ms: list[int], back_ms: list[int]
) -> None:
    stamps = np.cumsum([step for step, _ in steps_ms]) * MS
    samples = [
        turning(stamp_ns, known=known)
        for stamp_ns, (_, known) in zip(stamps.tolist(), steps_ms, strict=True)
    ]
    means, start = AttitudeMeans(1000.0), 0
    for length in intervals_ms:
        end = start + length * MS
        while samples and samples[0].stamp_ns <= end:
            means.add(samples.pop(0))
        turns, forces, known = means.over(start, end, np.array(back_ms) * MS)
        for at, back in enumerate(back_ms):
            window = AttitudeWindow(1000.0)
            for stamp_ns, (_, oriented) in zip(stamps.tolist(), steps_ms, strict=True):
                if stamp_ns <= end:
                    window.add(turning(stamp_ns, known=oriented))
            expected = window.take(start - back * MS, end - back * MS)
            oriented_ones = [one.orientation for one in expected if one.orientation is not None]
            assert known[at] == bool(oriented_ones)
            if oriented_ones:
                mean = matrices(np.array(oriented_ones)).mean(axis=0)
                assert np.array_equal(turns[at], mean)
                force = np.mean([one.specific_force for one in expected], axis=0)
                assert np.array_equal(forces[at], force)
        start = end


def test_without_velocities_means_keep_no_more_than_they_need() -> None:
    means = AttitudeMeans(1.0)
    for ms in range(0, 100_000, 100):
        means.add(turning(ms * MS))
    assert not means.over(97_000 * MS, 98_000 * MS, np.array([0]))[2][0]
    assert means.over(99_000 * MS, 99_900 * MS, np.array([0]))[2][0]
    assert len(means) == 11
