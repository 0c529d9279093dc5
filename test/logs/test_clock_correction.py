# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A clock of another rate is found in the arrival of fixes, and nothing else is taken for one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.logs.receiver_clock import WEEK_S, receiver_clock


def arrivals(
    rate: float, seconds: float = 120.0, late_s: float = 2.0
) -> tuple[list[int], list[float]]:
    """Arrivals at 5 Hz, 10 ms rms late or early, the first ten up to `late_s`; receiver times."""
    time = np.arange(0.0, seconds, 0.2) + WEEK_S - 30.0
    own = (time - time[0]) / rate + np.random.default_rng(1).normal(0.0, 0.01, len(time))
    own[:10] += np.linspace(late_s, 0.1, 10)
    return [round(one * 1e9) + 5_000_000_000 for one in own], list(time % WEEK_S)


@given(st.floats(0.8, 1.2).filter(lambda rate: abs(rate - 1.0) > 2e-3))
def test_the_rate_is_found_over_the_end_of_a_week(rate: float) -> None:
    clock = receiver_clock(*arrivals(rate))
    assert clock.rate == pytest.approx(rate, abs=2e-4)
    assert clock(clock.anchor_ns + 10**10) - clock.anchor_ns == round(clock.rate * 10**10)


def test_a_slow_clock_is_said() -> None:
    clock = receiver_clock(*arrivals(13 / 12))
    assert "7.7 % slow" in clock.remark()


@pytest.mark.parametrize("rate", [1.0, 1.0 + 5e-4])
def test_a_crystal_is_left_alone(rate: float) -> None:
    assert not receiver_clock(*arrivals(rate)).corrects


def test_a_step_of_the_receivers_time_is_no_rate() -> None:
    own, time = arrivals(1.0)
    half = len(time) // 2
    stepped = [*time[:half], *(one + 18.0 for one in time[half:])]
    assert not receiver_clock(own, stepped).corrects


def test_a_short_log_is_left_alone() -> None:
    assert not receiver_clock(*arrivals(13 / 12, seconds=20.0)).corrects
    assert not receiver_clock([], []).corrects
