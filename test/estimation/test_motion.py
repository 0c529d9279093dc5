# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Velocity over ground from what a receiver gives: its velocities, or else its fixes."""

from __future__ import annotations

import math

import numpy as np
import pymap3d
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.estimation.motion import GpsMotion
from hijack_detect.streams.samples import NANOSECONDS, FixSample, VelocitySample

DEGREES = st.floats(-80.0, 80.0)


def fix(seconds: float, east: float = 0.0, *, has_fix: bool = True) -> FixSample:
    latitude, longitude, height = pymap3d.enu2geodetic(east, 0.0, 0.0, 47.0, 8.0, 500.0)
    stamp = round(seconds * NANOSECONDS)
    return FixSample(stamp, float(latitude), float(longitude), float(height), has_fix=has_fix)


@given(DEGREES, DEGREES, st.tuples(*[st.floats(-30.0, 30.0)] * 3), st.integers(50, 1000))
def test_a_difference_of_fixes_is_the_velocity_between_them(
    latitude: float, longitude: float, velocity: tuple[float, float, float], dt_ms: int
) -> None:
    """The second fix comes from pymap3d; its tangent plane is that of the first."""
    dt_ns = dt_ms * NANOSECONDS // 1000
    moved = np.array(velocity) * dt_ns / NANOSECONDS
    there = pymap3d.enu2geodetic(*moved, latitude, longitude, 100.0)
    gps = GpsMotion(1.0)
    assert gps.fix(FixSample(0, latitude, longitude, 100.0)) is None
    motion = gps.fix(FixSample(dt_ns, *map(float, there)))
    assert motion is not None
    assert (motion.stamp_ns, motion.from_fixes) == (dt_ns, True)
    assert motion.middle_ns == dt_ns - dt_ns // 2
    np.testing.assert_allclose(motion.velocity, velocity, atol=1e-4)


def test_velocities_of_the_receiver_come_first() -> None:
    gps = GpsMotion(1.0)
    assert not gps.measured(0)
    own = gps.velocity(VelocitySample(0, (3.0, 4.0, math.nan)))
    np.testing.assert_array_equal(own.velocity, [3.0, 4.0, math.nan])
    assert (own.stamp_ns, own.middle_ns, own.from_fixes) == (0, 0, False)
    assert gps.measured(NANOSECONDS)
    assert not gps.measured(NANOSECONDS + 1)


@pytest.mark.parametrize(
    "second",
    [fix(0.2, has_fix=False), fix(0.0), fix(2.1)],
    ids=["no fix", "the same stamp", "too late"],
)
def test_fixes_that_give_no_velocity(second: FixSample) -> None:
    gps = GpsMotion(1.0, max_gap_s=2.0)
    gps.fix(fix(0.0))
    assert gps.fix(second) is None
    after = gps.fix(fix(2.2, 1.0))
    assert (after is None) == (not second.has_fix or second.stamp_ns == 0)


def test_a_lost_fix_begins_anew() -> None:
    gps = GpsMotion(1.0)
    gps.fix(fix(0.0))
    gps.fix(fix(0.2, has_fix=False))
    assert gps.last_fix is None
    assert gps.fix(fix(0.4, 1.0)) is None
    motion = gps.fix(fix(0.6, 2.0))
    assert motion is not None
    np.testing.assert_allclose(motion.velocity[:2], [5.0, 0.0], atol=1e-3)
