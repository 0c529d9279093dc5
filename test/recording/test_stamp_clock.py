# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The clock of a recording believes no single broken stamp."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.recording.stamp_clock import LEAP_S, StampClock

SECOND = 1_000_000_000
START = 1_700_000_000 * SECOND
LEAP = round(LEAP_S * SECOND)
STAMPS = st.integers(-(2**31) * SECOND, 2**31 * SECOND)


def fly(clock: StampClock, start: int, seconds: int, *names: str) -> list[bool]:
    """Let inputs come five times a second; return whether each stamp was believed."""
    return [
        clock.push(name, start + index * SECOND // 5)
        for index in range(seconds * 5)
        for name in names
    ]


@given(st.lists(st.integers(0, LEAP), min_size=1))
def test_the_clock_is_the_newest_stamp(steps: list[int]) -> None:
    clock, stamp = StampClock(), START
    for step in steps:
        stamp += step
        assert clock.push("imu", stamp)
        assert clock.now_ns == stamp


@given(STAMPS, st.integers(1, 20))
def test_one_broken_stamp_changes_nothing(broken: int, position: int) -> None:
    clock = StampClock()
    fly(clock, START, position, "imu", "fix")
    before = clock.now_ns
    assert before is not None
    believed = clock.push("fix", broken)
    assert believed == (abs(broken - before) <= LEAP)
    assert clock.now_ns is not None
    assert abs(clock.now_ns - before) <= LEAP
    assert all(fly(clock, START + position * SECOND, 4, "imu", "fix"))
    assert not clock.restarted
    assert clock.now_ns == START + (position + 4) * SECOND - SECOND // 5


def test_a_loop_begins_one_new_recording_whatever_arrives_late() -> None:
    clock = StampClock()
    fly(clock, START, 100, "imu", "fix", "velocity")
    restarts = 0
    for index in range(20):
        for name in ("imu", "fix", "velocity"):
            clock.push(name, START + index * SECOND // 5)
            restarts += clock.restarted
        if index == 3:
            assert not clock.push("fix", START + 100 * SECOND)
    assert restarts == 1
    assert clock.now_ns == START + 19 * SECOND // 5


def test_a_broken_first_stamp_is_forgotten() -> None:
    clock = StampClock()
    clock.push("imu", START + 10**9 * SECOND)
    fly(clock, START, 1, "imu")
    assert clock.now_ns == START + 4 * SECOND // 5


def test_an_input_that_is_late_from_the_start_is_believed() -> None:
    clock = StampClock()
    fly(clock, START, 20, "imu")
    assert all(fly(clock, START, 20, "fix"))
    assert not clock.push("mag", START - 60 * SECOND)


def test_an_outage_is_believed_at_the_second_stamp() -> None:
    clock = StampClock()
    fly(clock, START, 2, "imu")
    assert fly(clock, START + 60 * SECOND, 1, "imu") == [False, True, True, True, True]
    assert not clock.restarted


def test_inputs_may_have_clocks_of_their_own() -> None:
    clock = StampClock()
    fly(clock, START, 2, "fix")
    restarts = 0
    for index in range(20):
        clock.push("imu", 5 * SECOND + index * SECOND // 5)
        restarts += clock.restarted
        assert clock.push("fix", START + 2 * SECOND + index * SECOND // 5)
        restarts += clock.restarted
    assert not restarts
    assert clock.now_ns == START + 2 * SECOND + 19 * SECOND // 5
