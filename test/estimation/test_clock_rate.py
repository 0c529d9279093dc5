# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A clock of another rate shows in distances and in the interval of the fixes."""

from __future__ import annotations

import math

import pytest

from hijack_detect.estimation.clock_rate import ClockRateCheck
from hijack_detect.streams.samples import NANOSECONDS, FixSample, VelocitySample


def flown(rate: float, interval_s: float = 0.2, speed: float = 5.0) -> ClockRateCheck:
    """Two minutes on a circle, stamped by a clock of which a second lasts `rate` seconds."""
    check = ClockRateCheck()
    for k in range(round(120.0 / interval_s)):
        time = k * interval_s
        stamp_ns = round(time / rate * NANOSECONDS)
        turn = speed * time / 100.0
        north, east = 100.0 * math.sin(turn), 100.0 * (1.0 - math.cos(turn))
        latitude = 48.0 + math.degrees(north / 6_378_137.0)
        longitude = 11.0 + math.degrees(east / 6_378_137.0 / math.cos(math.radians(48.0)))
        velocity = (speed * math.sin(turn), speed * math.cos(turn), math.nan)
        check.velocity(VelocitySample(stamp_ns, velocity))
        check.fix(FixSample(stamp_ns, latitude, longitude, 500.0))
    return check


@pytest.mark.parametrize("rate", [13 / 12, 0.9])
def test_another_rate_is_found(rate: float) -> None:
    assert flown(rate).rate == pytest.approx(rate, abs=5e-3)


@pytest.mark.parametrize(("rate", "interval_s"), [(1.0, 0.2), (1.01, 0.2), (1.0, 0.183)])
def test_one_witness_is_not_enough(rate: float, interval_s: float) -> None:
    assert flown(rate, interval_s).rate is None


def test_a_slow_vehicle_tells_nothing() -> None:
    assert flown(13 / 12, speed=0.8).rate is None
