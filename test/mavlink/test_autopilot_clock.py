# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The clock of an autopilot: true to the exchange, smooth, in order, and afresh after a start."""

from __future__ import annotations

import itertools
import random
from dataclasses import dataclass, field

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.mavlink.clock import DRIFT, SLEW, STEP_NS, AutopilotClock, InOrder

SECOND, MS = 1_000_000_000, 1_000_000
IMU_NS = 10 * MS


@dataclass
class World:
    """An autopilot whose clock differs from the local one, at the end of a slow link."""

    offset_ns: int
    """Local time less own time when both begin."""
    drift: float = 0.0
    fastest_ns: int = MS
    slowest_ns: int = 5 * MS
    loss: float = 0.0
    answers: bool = True
    seed: int = 1
    now_ns: int = 1000 * SECOND
    clock: AutopilotClock = field(default_factory=AutopilotClock)

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)
        self._start_ns = self.now_ns
        self.stamps: list[tuple[int, int]] = []
        """Own time and stamp of each message that had one."""

    def own_ns(self, at_ns: int) -> int:
        """What the autopilot's clock says at a local time."""
        drifted = round((at_ns - self._start_ns) * self.drift)
        return at_ns - self.offset_ns + drifted

    def error_ns(self, own_ns: int, stamp_ns: int) -> int:
        """A stamp less the true local time of an own time."""
        elapsed = own_ns + self.offset_ns - self._start_ns
        return stamp_ns - (self._start_ns + round(elapsed / (1.0 + self.drift)))

    def delay(self) -> int:
        return self._random.randint(self.fastest_ns, self.slowest_ns)

    def fly(self, seconds: float) -> None:
        """Messages at 100 Hz, an exchange each second."""
        arrivals = []
        for index in range(round(seconds * SECOND / IMU_NS)):
            at = self.now_ns + index * IMU_NS
            if self._random.random() >= self.loss:
                arrivals.append((at + self.delay(), "imu", self.own_ns(at), 0))
            if index % 100 == 50 and self.answers and self._random.random() >= self.loss:
                there = at + self.delay()
                arrivals.append((there + self.delay(), "answer", self.own_ns(there), at))
                self.clock.request(at)
        for now, kind, own, asked in sorted(arrivals):
            if kind == "answer":
                self.clock.answer(own, asked, now)
            elif self.clock.observe(own, now) and (stamp := self.clock.stamp_ns(own)) is not None:
                self.stamps.append((own, stamp))
        self.now_ns += round(seconds * SECOND) + self.slowest_ns


@given(
    st.integers(-(10**18), 10**18),
    st.floats(-5e-5, 5e-5),
    st.integers(0, 20 * MS),
    st.integers(0, 80 * MS),
    st.sampled_from((0.0, 0.2, 0.6)),
    st.integers(0, 10**6),
)
@settings(max_examples=60, deadline=None)
def test_stamps_are_true_to_half_the_exchange_and_hold_no_jitter(
    offset: int, drift: float, fastest: int, spread: int, loss: float, seed: int
) -> None:
    world = World(offset, drift, fastest, fastest + spread, loss, seed=seed)
    world.fly(40.0)
    assert world.clock.epoch == 0
    settled = world.stamps[len(world.stamps) // 2 :]
    bound = (fastest + spread) + 4 * DRIFT * 30 * SECOND
    assert max(abs(world.error_ns(*one)) for one in settled) <= bound
    by_own = sorted(world.stamps)
    for (own, stamp), (next_own, next_stamp) in itertools.pairwise(by_own):
        step = next_own - own
        here = step * (1.0 + DRIFT) + 2 * world.slowest_ns  # on the clock that the slew goes by
        assert abs(next_stamp - stamp - step) <= SLEW * here + 2


def test_delays_that_come_and_go_are_not_in_the_stamps() -> None:
    world = World(offset_ns=7 * SECOND)
    world.fly(5.0)
    world.slowest_ns = 900 * MS
    world.fly(20.0)
    assert world.clock.epoch == 0
    assert max(abs(world.error_ns(*one)) for one in world.stamps) < 5 * MS


def test_without_answers_the_quickest_messages_are_believed() -> None:
    world = World(offset_ns=-3 * SECOND, fastest_ns=4 * MS, slowest_ns=60 * MS, answers=False)
    world.fly(20.0)
    assert world.clock.round_trip_ns(world.now_ns) is None
    errors = [world.error_ns(*one) for one in world.stamps]
    assert min(errors) >= 0 and max(errors) < 20 * MS
    assert world.stamps[0][0] >= world.own_ns(1000 * SECOND + 900 * MS), (
        "a second is waited for an answer"
    )


def test_a_start_of_the_autopilot_is_noticed_and_stamps_begin_afresh() -> None:
    world = World(offset_ns=-500 * SECOND)
    world.fly(5.0)
    before = world.stamps[-1]
    world.offset_ns = world.now_ns - 2 * SECOND
    world._start_ns = world.now_ns
    count = len(world.stamps)
    world.fly(5.0)
    assert world.clock.epoch == 1
    assert "was started again" in world.clock.why
    assert world.stamps[count][1] > before[1]
    assert max(abs(world.error_ns(*one)) for one in world.stamps[count:]) < 5 * MS


@pytest.mark.parametrize("jump_s", [-1.5, 1.5, 30.0])
def test_a_clock_that_is_set_is_followed_at_once(jump_s: float) -> None:
    world = World(offset_ns=0)
    world.fly(35.0)
    world.offset_ns -= round(jump_s * SECOND)
    world.fly(10.0)
    assert world.clock.epoch >= 1
    assert max(abs(world.error_ns(*one)) for one in world.stamps[-400:]) < 5 * MS


@given(st.integers(0, 2**63 // 1000))
@settings(deadline=None)
def test_a_damaged_time_changes_nothing(own_ns: int) -> None:
    world = World(offset_ns=0)
    world.fly(2.0)
    known = world.clock.stamp_ns(0)
    world.clock.observe(own_ns, world.now_ns)
    assert abs((world.clock.stamp_ns(0) or 0) - (known or 0)) < STEP_NS
    assert world.clock.epoch == 0


def test_a_slow_first_exchange_is_not_believed_alone() -> None:
    world = World(offset_ns=0, fastest_ns=0, slowest_ns=5 * MS, answers=False)
    world.clock.observe(world.own_ns(world.now_ns), world.now_ns)
    asked = world.clock.request(world.now_ns)
    slow = world.now_ns + 900 * MS
    world.clock.answer(world.own_ns(slow - MS), asked, slow)
    assert not world.clock.ready
    world.now_ns = slow
    world.answers = True
    world.fly(8.0)
    assert world.clock.epoch == 0
    assert max(abs(world.error_ns(*one)) for one in world.stamps[200:]) < 460 * MS


def test_a_simulator_may_run_faster_than_life() -> None:
    clock, speed = AutopilotClock(speed=10.0), 10
    stamps = []
    for tick in range(400):
        now, own = 1000 * SECOND + tick * 5 * MS, 7 * SECOND + tick * 5 * MS * speed
        clock.observe(own, now + (tick % 3) * MS)
        if tick % 20 == 0:
            asked = clock.request(now)
            clock.answer(own + speed * MS, asked, now + 2 * MS)
        if (stamp := clock.stamp_ns(own)) is not None:
            stamps.append(stamp - own)
    assert (clock.epoch, len(stamps) > 250) == (0, True)
    assert max(stamps) - min(stamps) < MS


def test_answers_that_nobody_asked_for_or_of_another_clock_are_ignored() -> None:
    world = World(offset_ns=0, answers=False)
    assert not world.clock.answer(5, 5, 6)
    world.fly(3.0)
    assert not world.clock.answer(world.own_ns(world.now_ns), world.now_ns - MS, world.now_ns)
    asked = world.clock.request(world.now_ns)
    unix_ns = 1_790_000_000 * SECOND
    assert not world.clock.answer(unix_ns, asked, world.now_ns + MS)
    asked = world.clock.request(world.now_ns)
    assert world.clock.answer(world.own_ns(world.now_ns), asked, world.now_ns + MS)
    assert not world.clock.answer(world.own_ns(world.now_ns), asked, world.now_ns + MS), "twice"


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(0, 50)), max_size=60))
def test_what_passes_is_in_order_by_both_times(readings: list[tuple[int, int]]) -> None:
    order = InOrder()
    passed = [one for one in readings if order.passes("imu", *one)]
    for before, after in itertools.pairwise(passed):
        assert after[0] > before[0] and after[1] > before[1]
    assert order.passes("fix", 0, 0)
