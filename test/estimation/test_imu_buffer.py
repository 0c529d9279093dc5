# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The buffer between the newest IMU sample and the filter behind it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.estimation.imu_buffer import ImuBuffer
from hijack_detect.streams.samples import ImuSample

MS = 1_000_000


def filled(stamps_ms: list[int]) -> ImuBuffer:
    """Readings that are linear in time, so that interpolation and means are exact."""
    buffer = ImuBuffer()
    for ms in stamps_ms:
        rate = (0.001 * ms, -0.002 * ms, 1.0)
        buffer.append(ImuSample(ms * MS, rate, (0.01 * ms, 2.0, 9.8 - 0.003 * ms)))
    return buffer


def test_take_interpolates_at_both_ends() -> None:
    block = filled([0, 10, 20, 30, 40]).take(5 * MS, 33 * MS)
    np.testing.assert_allclose(block.dt, [0.005, 0.010, 0.010, 0.003])
    middles = np.array([7.5, 15.0, 25.0, 31.5])
    np.testing.assert_allclose(block.angular_velocity[:, 0], 0.001 * middles)
    np.testing.assert_allclose(block.angular_velocity[:, 1], -0.002 * middles)
    np.testing.assert_allclose(block.specific_force[:, 0], 0.01 * middles)
    np.testing.assert_allclose(block.specific_force[:, 2], 9.8 - 0.003 * middles)


@given(
    st.lists(st.integers(1, 50), min_size=2, max_size=40),
    st.lists(st.integers(0, 1000), max_size=8),
)
def test_successive_takes_cover_the_time_once(steps: list[int], cuts: list[int]) -> None:
    stamps = np.cumsum([0, *steps]).tolist()
    ends = sorted({cut for cut in cuts if 0 < cut < stamps[-1]} | {stamps[-1]})
    buffer = filled(stamps)
    begin, turned = 0, 0.0
    for end in ends:
        block = buffer.take(begin * MS, end * MS)
        assert np.all(block.dt > 0.0)
        assert np.sum(block.dt) == pytest.approx((end - begin) * 1e-3)
        turned += float(np.sum(block.dt * block.angular_velocity[:, 0]))
        begin = end
    assert turned == pytest.approx(0.5 * 1e-6 * stamps[-1] ** 2)


def test_take_drops_what_is_no_longer_needed() -> None:
    buffer = filled(list(range(0, 1000, 10)))
    buffer.take(0, 995 * MS - 10 * MS)
    assert buffer.oldest_ns == 980 * MS
    assert buffer.newest_ns == 990 * MS
    assert np.sum(buffer.take(985 * MS, 990 * MS).dt) == pytest.approx(0.005)


def test_take_before_the_first_sample_holds_its_reading() -> None:
    block = filled([100, 110]).take(90 * MS, 105 * MS)
    assert np.sum(block.dt) == pytest.approx(0.015)
    assert block.angular_velocity[0, 0] == pytest.approx(0.1, abs=1e-3)


def test_steps_carry_on_from_the_given_time() -> None:
    steps = list(filled([0, 10, 20, 40]).steps(15 * MS))
    assert [dt for dt, _ in steps] == pytest.approx([0.005, 0.020])
    assert [omega[0] for _, omega in steps] == pytest.approx([0.015, 0.030])
    assert list(filled([0, 10]).steps(10 * MS)) == []


def test_mean_specific_force() -> None:
    assert filled([0, 10, 50]).mean_specific_force() == pytest.approx((0.2, 2.0, 9.74))
