# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
from __future__ import annotations

import math

import pytest

from hijack_detect.spoofing.onset import MAX_CARRY_S, onset_at
from hijack_detect.streams.samples import NANOSECONDS


def test_samples_at_the_onset_and_after_it_do_not_count(tools):
    flight = tools.flight("waving")
    stamp = flight.fixes[50].stamp_ns
    before = onset_at(stamp, flight.fixes[:50], flight.velocities[:50])
    assert onset_at(stamp, flight.fixes[:60], flight.velocities[:60]) == before
    assert before.fix is flight.fixes[49]
    assert before.velocity_sample is flight.velocities[49]


def test_the_last_fix_is_carried_to_the_onset(tools):
    flight = tools.flight()
    onset = onset_at(flight.fixes[49].stamp_ns + NANOSECONDS // 10, flight.fixes, flight.velocities)
    assert onset.carry == pytest.approx((0.4, 0.3, 0.0), abs=1e-4)
    assert onset.speed == pytest.approx(5.0)
    assert onset.course == pytest.approx(math.atan2(4.0, 3.0), abs=1e-4)


def test_an_old_fix_is_not_carried_far(tools):
    flight = tools.flight()
    onset = onset_at(flight.fixes[150].stamp_ns, flight.fixes[:10], flight.velocities)
    assert math.hypot(*onset.carry) == pytest.approx(5.0 * MAX_CARRY_S)


def test_nothing_known_is_standing_still(tools):
    onset = onset_at(0, (), ())
    assert (onset.fix, onset.velocity, onset.carry) == (None, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert (onset.speed, onset.course) == (0.0, 0.0)


def test_fixes_with_one_stamp_give_no_velocity(tools):
    fix = tools.flight().fixes[0]
    onset = onset_at(fix.stamp_ns + 1, (fix, fix), ())
    assert onset.velocity == (0.0, 0.0, 0.0)


def test_below_half_a_metre_a_second_there_is_no_course(tools):
    flight = tools.flight("hover")
    slow = [type(v)(v.stamp_ns, (0.3, -0.39, 4.0)) for v in flight.velocities]
    onset = onset_at(flight.fixes[50].stamp_ns, flight.fixes, slow)
    assert (onset.speed, onset.course) == (0.0, 0.0)
