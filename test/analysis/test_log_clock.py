# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Stamps are placed on the time of the log, whatever the clock behind them does."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.analysis.log_clock import LogClock
from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.streams.samples import FixSample, ImuSample

SECOND = 10**9
LATE = SECOND // 100
"""From stamp to log."""


def imu(stamp_ns: int) -> ImuSample:
    return ImuSample(stamp_ns, (0.0, 0.0, 0.0), (0.0, 0.0, 9.8))


def flown(clock: LogClock, begin_s: int, end_s: int, ahead_ns: int = 0) -> None:
    """An IMU at 10 Hz, stamped ahead of the log."""
    for k in range(10 * begin_s, 10 * end_s):
        at_ns = k * SECOND // 10
        clock.take(imu(at_ns + ahead_ns), at_ns + LATE)


@pytest.mark.parametrize("jump_s", [-3600, -10, -3, 3, 37, 10_000_000])
def test_times_go_on_where_the_clock_jumps(jump_s: int) -> None:
    clock = LogClock()
    flown(clock, 0, 20)
    assert clock.stamp_ns(19 * SECOND) == 19 * SECOND
    flown(clock, 20, 40, jump_s * SECOND)
    late = 39 * SECOND + jump_s * SECOND
    assert clock.stamp_ns(late) == pytest.approx(39 * SECOND, abs=2 * LATE)
    flown(clock, 40, 60)  # and back
    assert clock.stamp_ns(59 * SECOND) == pytest.approx(59 * SECOND, abs=2 * LATE)


def test_what_comes_late_of_before_a_jump_is_placed_before_it() -> None:
    clock = LogClock()
    flown(clock, 0, 20)
    flown(clock, 20, 21, -3600 * SECOND)
    assert clock.stamp_ns(19 * SECOND) == 19 * SECOND


@given(st.floats(0.0, 1.5), st.floats(0.0, 20.0))
def test_without_a_jump_nothing_changes(late_s: float, stall_s: float) -> None:
    """However late messages are, and while a recorder stalls and writes all at once after that."""
    clock = LogClock()
    for k in range(600):
        at_ns = k * SECOND // 10
        held_ns = max(at_ns, round((30.0 + stall_s) * SECOND)) if at_ns >= 30 * SECOND else at_ns
        clock.take(imu(at_ns), held_ns + round(late_s * SECOND))
        assert clock.stamp_ns(at_ns) == at_ns


def test_an_outage_that_the_log_has_too_is_no_jump() -> None:
    clock = LogClock()
    flown(clock, 0, 20)
    flown(clock, 80, 100)
    assert clock.stamp_ns(99 * SECOND) == 99 * SECOND


def test_a_clock_that_counts_from_the_start_is_placed_but_not_beside_what_is_known_by_it() -> None:
    boot = -1_700_000_000 * SECOND
    clock = LogClock()
    flown(clock, 1_700_000_000, 1_700_000_010, boot)
    assert clock.stamp_ns(5 * SECOND) == pytest.approx(1_700_000_005 * SECOND, abs=2 * LATE)
    clock = LogClock()
    clock.adopt_first = False
    flown(clock, 1_700_000_000, 1_700_000_010, boot)
    assert clock.stamp_ns(5 * SECOND) == 5 * SECOND


@pytest.mark.parametrize("stuck_s", [0, 1000])
def test_stamps_that_stand_still_are_no_clock(stuck_s: int) -> None:
    clock = LogClock()
    for k in range(100):
        clock.take(imu(stuck_s * SECOND), (2000 + k) * SECOND)
    assert clock.stamp_ns(2050 * SECOND) == 2050 * SECOND


def test_one_broken_stamp_is_no_clock() -> None:
    clock = LogClock()
    flown(clock, 0, 20)
    clock.take(imu(5000 * SECOND), 20 * SECOND)
    flown(clock, 20, 40)
    assert clock.stamp_ns(39 * SECOND) == 39 * SECOND


def test_samples_verdicts_and_results_are_placed_with_their_alert() -> None:
    clock = LogClock()
    flown(clock, 0, 20)
    flown(clock, 20, 40, 100 * SECOND)
    fix = FixSample(138 * SECOND, 48.0, 11.0, 500.0)
    assert abs(clock.placed(fix).stamp_ns - 38 * SECOND) <= LATE
    verdict = Verdict("date", 139 * SECOND, State.NORMAL, 0.0, 1.0, "calm")
    assert abs(clock.placed(verdict).stamp_ns - 39 * SECOND) <= LATE
    result = FusionResult(139 * SECOND, State.ALARM, True, 138 * SECOND, 1.0, "why", {}, ())
    placed = clock.placed(result)
    assert placed.stamp_ns - placed.alert_since_ns == SECOND
    assert abs(placed.stamp_ns - 39 * SECOND) <= LATE
