# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Magnetic heading against published values of the World Magnetic Model."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hijack_detect.estimation.magnetic import declination, heading_error


@pytest.mark.parametrize(
    ("latitude", "longitude", "altitude_m", "published_deg"),
    [
        (80.0, 0.0, 0.0, 1.28),
        (0.0, 120.0, 0.0, -0.16),
        (-80.0, -120.0, 0.0, 68.78),
        (80.0, 0.0, 100_000.0, 0.85),
        (0.0, 120.0, 100_000.0, -0.15),
        (-80.0, -120.0, 100_000.0, 68.21),
    ],
)
def test_declination_is_that_of_the_test_values_of_wmm_2025(
    latitude: float, longitude: float, altitude_m: float, published_deg: float
) -> None:
    found = math.degrees(declination(latitude, longitude, altitude_m))
    assert found == pytest.approx(published_deg, abs=0.006)


@given(
    st.floats(-3.1, 3.1),
    st.floats(-0.5, 0.5),
    st.floats(-0.5, 0.5),
    st.floats(-1.2, 1.2),
    st.floats(-1.4, 1.4),
    st.floats(-1.0, 1.0),
)
def test_heading_error_is_the_turn_that_brings_the_field_to_magnetic_north(
    yaw: float, pitch: float, roll: float, dip: float, declined: float, wrong: float
) -> None:
    true = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    north, east = math.cos(dip) * math.cos(declined), math.cos(dip) * math.sin(declined)
    field = true.inv().apply([5e-5 * east, 5e-5 * north, -5e-5 * math.sin(dip)])
    estimate = Rotation.from_rotvec([0.0, 0.0, wrong]) * true
    found, _ = heading_error(tuple(estimate.as_quat()), tuple(field), declined)
    assert found == pytest.approx(-wrong, abs=1e-9)


@given(st.floats(-3.1, 3.1), st.floats(-1.0, 1.0), st.sampled_from([0, 1, 2]))
def test_derivatives_are_those_of_finite_differences(yaw: float, pitch: float, axis: int) -> None:
    """The attitude error is in ENU and takes the estimate to the truth."""
    estimate = Rotation.from_euler("ZY", [yaw, pitch])
    field = tuple(estimate.inv().apply([4e-6, 2e-5, -5e-5]))
    step = np.zeros(3)
    step[axis] = 1e-6
    before, slopes = heading_error(tuple(estimate.as_quat()), field, 0.2)
    moved = Rotation.from_rotvec(step) * estimate
    after, _ = heading_error(tuple(moved.as_quat()), field, 0.2)
    assert (before - after) / 1e-6 == pytest.approx(slopes[axis], abs=1e-4)


def test_heading_error_is_wrapped() -> None:
    south = Rotation.from_rotvec([0.0, 0.0, -math.pi / 2])
    field = tuple(Rotation.from_rotvec([0.0, 0.0, 1.6]).inv().apply([0.0, 2e-5, -4e-5]))
    found, _ = heading_error(tuple(south.as_quat()), field, 0.0)
    assert -math.pi <= found <= math.pi
    assert math.remainder(found - (1.6 + math.pi / 2), math.tau) == pytest.approx(0.0, abs=1e-9)
