# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The lags that explain differences that are made of a known lag."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.estimation.growing_lag import DOUBTED, JUMP, REFUTED, STEP_S, GrowingLag
from hijack_detect.estimation.lag_ekf import GROWTH
from hijack_detect.estimation.rotation import Array

PERIOD_S = 0.2
PART = 0.1
"""An observation of 0.2 s within a window of 2 s."""


def new() -> GrowingLag:
    return GrowingLag(0.15, 1.55)


def seen(one: GrowingLag, lag_s: float, size: float) -> Array:
    """Squares where a lag that is wrong by 1 s is a difference of `size` usual ones."""
    return PART * np.square(size * (one.lags_s - lag_s))


def index(one: GrowingLag, lag_s: float) -> int:
    return int(np.argmin(np.abs(one.lags_s - lag_s)))


def test_the_grid_has_the_usual_lag_one_below_and_those_up_to_the_largest() -> None:
    one = new()
    assert one.lags_s == pytest.approx(0.05 + 0.1 * np.arange(16))
    assert one.lags_s[one.usual] == 0.15
    assert one.lags_s[one.possible] == pytest.approx([0.05, 0.15, 0.25])
    assert one.held == one.usual


@given(st.floats(0.0, 1.0), st.floats(0.0, 3.0))
def test_no_lag_is_negative(usual_s: float, largest_s: float) -> None:
    one = GrowingLag(usual_s, largest_s)
    assert one.lags_s.min() >= 0.0
    assert one.lags_s[one.usual] == usual_s
    assert one.possible[one.usual]


def test_without_a_larger_lag_there_is_only_the_usual_one() -> None:
    one = GrowingLag(0.0, 0.0)
    assert not one.grows
    assert one.lags_s.tolist() == [0.0]
    assert one.judged.tolist() == [True]


def test_in_a_hover_the_lag_is_kept_while_others_become_possible() -> None:
    one = new()
    for _ in range(50):
        one.update(PERIOD_S, np.zeros(16))
    assert one.held == one.usual
    reached = 0.25 + GROWTH * 50 * PERIOD_S
    assert one.lags_s[one.possible].max() == pytest.approx(min(reached, 1.55), abs=STEP_S)


def test_a_lag_that_grows_in_manoeuvres_is_among_the_possible_ones_and_followed() -> None:
    """From 0.15 to 1.35 s within 10 s, the fastest that was tried."""
    one = new()
    for step in range(200):
        lag_s = 0.15 + 1.2 * min(1.0, step * PERIOD_S / 10.0)
        one.update(PERIOD_S, seen(one, lag_s, 10.0))
        assert one.possible[index(one, lag_s)]
    assert one.lags_s[one.held] == pytest.approx(1.35, abs=0.35)
    assert one.least_s == pytest.approx(1.35, abs=0.35)


def test_a_lag_that_falls_at_once_is_found_again() -> None:
    one = new()
    for step in range(100):
        one.update(PERIOD_S, seen(one, min(1.35, 0.15 + 0.12 * step * PERIOD_S), 10.0))
    assert one.least_s > 0.9
    assert one.judged[one.usual]
    for _ in range(10):
        one.update(PERIOD_S, seen(one, 0.15, 10.0))
    assert one.least_s < 0.3


@given(st.floats(0.0, 100.0), st.integers(1, 50))
def test_an_acceleration_that_all_lags_share_refutes_none(square: float, count: int) -> None:
    one, other = new(), new()
    for _ in range(count):
        one.update(PERIOD_S, np.full(16, square))
        other.update(PERIOD_S, np.zeros(16))
    assert one.possible.tolist() == other.possible.tolist()
    assert one.held == one.usual


@given(
    st.lists(
        st.tuples(st.floats(0.0, 100.0), st.lists(st.floats(0.0, 1e6), min_size=16, max_size=16)),
        max_size=30,
    )
)
def test_some_lag_is_always_possible_and_the_held_one_among_them(
    updates: list[tuple[float, list[float]]],
) -> None:
    one = new()
    for seconds, squares in updates:
        one.update(seconds, np.array(squares))
        assert one.possible[one.held]
        assert one.judged[one.usual]


def test_a_lag_is_given_up_before_it_is_refuted_and_a_jump_costs_more() -> None:
    assert DOUBTED < REFUTED < JUMP
