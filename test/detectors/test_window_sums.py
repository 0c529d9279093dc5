# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Sliding sums against NumPy over the same samples."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.detectors.window import Unwrap, WindowSums

values = st.floats(-1e4, 1e4)


@given(
    st.integers(1, 500),
    st.lists(st.tuples(st.integers(1, 100), values, values), min_size=1, max_size=60),
)
def test_means_and_covariances_are_those_of_the_samples_in_the_window(
    length: int, steps: list[tuple[int, float, float]]
) -> None:
    window = WindowSums(length, 2, [(0, 0), (1, 1), (0, 1)])
    kept: list[tuple[int, float, float]] = []
    now = 0
    for step, a, b in steps:
        now += step
        window.add(now, (a, b))
        kept = [one for one in [*kept, (now, a, b)] if one[0] > now - length]
        inside = np.array(kept)
        assert len(window) == len(inside)
        assert window.span_ns == inside[-1, 0] - inside[0, 0]
        assert window.mean(0) == pytest.approx(np.mean(inside[:, 1]), abs=1e-9)
        assert window.mean(1) == pytest.approx(np.mean(inside[:, 2]), abs=1e-9)
        expected = np.cov(inside[:, 1:].T, bias=True)
        assert window.covariance(0) == pytest.approx(expected[0, 0], rel=1e-9, abs=1e-6)
        assert window.covariance(1) == pytest.approx(expected[1, 1], rel=1e-9, abs=1e-6)
        assert window.covariance(2) == pytest.approx(expected[0, 1], rel=1e-9, abs=1e-6)


def test_a_sample_leaves_when_it_is_as_old_as_the_window() -> None:
    window = WindowSums(10, 1)
    window.add(0, (1.0,))
    window.add(9, (2.0,))
    assert len(window) == 2
    window.add(10, (3.0,))
    assert len(window) == 2
    assert window.mean(0) == 2.5


def test_drop_before_and_clear() -> None:
    window = WindowSums(100, 1, [(0, 0)])
    for stamp in range(5):
        window.add(stamp, (float(stamp),))
    window.drop_before(2)
    assert len(window) == 2
    assert window.mean(0) == 3.5
    assert window.covariance(0) == 0.25
    window.clear()
    assert len(window) == 0
    assert window.span_ns == 0
    window.add(7, (5.0,))
    assert window.mean(0) == 5.0
    assert window.covariance(0) == 0.0


def test_a_million_samples_with_a_large_offset_leave_no_drift_at_all() -> None:
    """The result must equal, to the bit, that of a window which saw the last samples only."""
    rng = np.random.default_rng(1)
    long, short = (WindowSums(100, 1, [(0, 0)]) for _ in range(2))
    noise = (1e6 + rng.normal(0.0, 1e-3, 1_000_000)).tolist()
    for stamp, value in enumerate(noise):
        long.add(stamp, (value,))
        if stamp >= 999_900:
            short.add(stamp, (value,))
    assert long.mean(0) == short.mean(0)
    assert long.covariance(0) == short.covariance(0)
    last = np.array(noise[-100:]) - 1e6
    assert long.mean(0) - 1e6 == pytest.approx(np.mean(last), abs=1e-9)
    assert long.covariance(0) == pytest.approx(np.var(last), rel=1e-5)


@given(st.floats(-1e3, 1e3), st.integers(1, 30))
def test_a_constant_has_no_variance(value: float, count: int) -> None:
    window = WindowSums(1000, 1, [(0, 0)])
    for stamp in range(count):
        window.add(stamp, (value,))
    assert window.covariance(0) == 0.0


@settings(max_examples=200)
@given(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=50), st.floats(-3.0, 3.0))
def test_unwrap_follows_numpy(steps: list[float], start: float) -> None:
    true = start + np.cumsum(steps)
    wrapped = np.arctan2(np.sin(true), np.cos(true))
    unwrap = Unwrap()
    found = [unwrap(angle) for angle in wrapped.tolist()]
    np.testing.assert_allclose(found, np.unwrap(wrapped), atol=1e-9)
    np.testing.assert_allclose(np.diff(found), np.diff(true), atol=1e-9)


def test_unwrap_keeps_the_first_angle_and_counts_turns() -> None:
    unwrap = Unwrap()
    angles = [unwrap(math.remainder(0.5 * k, math.tau)) for k in range(100)]
    assert angles == pytest.approx([0.5 * k for k in range(100)])
