# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The paper's Eqs. 2-10 against SciPy; angles and frames as in the paper."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hijack_detect.estimation import quaternion_integration as paper
from hijack_detect.streams.samples import Vector3

angles = st.floats(-math.pi, math.pi)
rates = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


def random_rotations(count: int) -> list[Rotation]:
    return list(Rotation.random(count, random_state=np.random.RandomState(1)))


def scalar_first(rotation: Rotation) -> paper.PaperQuaternion:
    x, y, z, w = rotation.as_quat()
    return (w, x, y, z)


def rotation_of(q: paper.PaperQuaternion) -> Rotation:
    return Rotation.from_quat([q[1], q[2], q[3], q[0]])


@given(angles, angles, angles)
def test_eq_8_is_the_product_of_the_elementary_rotations(
    pitch: float, roll: float, yaw: float
) -> None:
    product = (
        Rotation.from_rotvec([0, 0, yaw])
        * Rotation.from_rotvec([pitch, 0, 0])
        * Rotation.from_rotvec([0, roll, 0])
    )
    found = paper.initial_matrix(pitch, roll, yaw)
    np.testing.assert_allclose(found, product.as_matrix(), atol=1e-12)


def test_eq_4_is_the_matrix_of_the_quaternion() -> None:
    for rotation in random_rotations(100):
        found = paper.rotation_matrix(scalar_first(rotation))
        np.testing.assert_allclose(found, rotation.as_matrix(), atol=1e-12)


def test_eqs_9_and_10_return_the_quaternion_of_a_matrix() -> None:
    for rotation in random_rotations(300):
        q = paper.quaternion_of(rotation.as_matrix())
        assert q[0] >= 0.0
        assert math.hypot(*q) == pytest.approx(1.0, abs=1e-9)
        assert (rotation_of(q) * rotation.inv()).magnitude() < 1e-6


@given(angles, st.floats(-1.4, 1.4), angles)
def test_eqs_4_and_9_are_inverse(pitch: float, roll: float, yaw: float) -> None:
    m = paper.initial_matrix(pitch, roll, yaw)
    back = paper.rotation_matrix(paper.quaternion_of(m))
    if np.trace(m) > -0.99:  # at half a turn the printed signs are those of zero
        np.testing.assert_allclose(back, m, atol=1e-6)


@pytest.mark.parametrize("degrees", [0, 45, 90, 135, 180, 225, 270, 315, 359])
def test_eq_2_loses_no_direction(degrees: int) -> None:
    yaw = math.radians(degrees)
    found = paper.yaw_of(paper.initial_matrix(0.0, 0.0, yaw))
    assert math.remainder(found - yaw, math.tau) == pytest.approx(0.0, abs=1e-12)
    assert 0.0 <= found < math.tau


@given(st.floats(-1.4, 1.4), st.floats(-1.4, 1.4), angles)
def test_eq_2_is_the_yaw_of_a_tilted_body(pitch: float, roll: float, yaw: float) -> None:
    found = paper.yaw_of(paper.initial_matrix(pitch, roll, yaw))
    assert math.remainder(found - yaw, math.tau) == pytest.approx(0.0, abs=1e-9)


@given(rates, st.floats(0.001, 0.5))
def test_the_exact_step_is_a_rotation_in_the_body_frame(omega: Vector3, dt: float) -> None:
    start = Rotation.from_euler("xyz", [0.3, -0.2, 1.0])
    found = paper.exact_step(scalar_first(start), omega, dt)
    expected = start * Rotation.from_rotvec(np.array(omega) * dt)
    assert (rotation_of(found) * expected.inv()).magnitude() < 1e-7


@given(rates)
def test_the_first_order_step_is_eq_5(omega: Vector3) -> None:
    """Ω of Eq. 5 written out, then normalised."""
    wx, wy, wh = omega
    matrix = np.array([[0, -wx, -wy, -wh], [wx, 0, wh, -wy], [wy, -wh, 0, wx], [wh, wy, -wx, 0]])
    q = np.array(scalar_first(Rotation.from_euler("xyz", [0.3, -0.2, 1.0])))
    expected = q + 0.5 * matrix @ q * 0.02
    expected /= np.linalg.norm(expected)
    np.testing.assert_allclose(paper.first_order_step(tuple(q), omega, 0.02), expected, atol=1e-14)


def test_the_first_order_step_converges_to_the_exact_one() -> None:
    """Halving the step divides its error by eight: normalised, it is better than first order."""
    q = scalar_first(Rotation.from_euler("xyz", [0.3, -0.2, 1.0]))
    omega = (0.7, -0.4, 1.1)

    def error(dt: float) -> float:
        rough = rotation_of(paper.first_order_step(q, omega, dt))
        return (rough * rotation_of(paper.exact_step(q, omega, dt)).inv()).magnitude()

    assert error(0.02) > 1e-7
    for dt in (0.2, 0.1, 0.05):
        assert error(dt) / error(dt / 2) == pytest.approx(8.0, rel=0.05)


@pytest.mark.parametrize("first_order", [False, True])
def test_a_full_turn_at_constant_rate(first_order: bool) -> None:
    one = paper.QuaternionIntegration(0.0, first_order=first_order)
    rate, dt = math.tau / 20.0, 0.02
    for step in range(1000):
        one.step((0.0, 0.0, rate), dt)
        if step == 249:
            _, _, z, w = one.orientation
            assert 2 * math.atan2(z, w) % math.tau == pytest.approx(math.pi / 2, abs=1e-4)
    assert Rotation.from_quat(one.orientation).magnitude() < 1e-3


@pytest.mark.parametrize("heading_deg", [-170.0, -90.0, 0.0, 45.0, 90.0, 180.0])
def test_it_starts_level_with_the_nose_on_the_course(heading_deg: float) -> None:
    heading = math.radians(heading_deg)
    one = paper.QuaternionIntegration(heading, first_order=False)
    expected = Rotation.from_rotvec([0.0, 0.0, heading])
    assert (Rotation.from_quat(one.orientation) * expected.inv()).magnitude() < 1e-6


@given(angles, st.lists(rates, min_size=1, max_size=10))
def test_orientation_turns_flu_into_enu(heading: float, turns: list[Vector3]) -> None:
    one = paper.QuaternionIntegration(heading, first_order=False)
    expected = Rotation.from_rotvec([0.0, 0.0, heading])
    for omega in turns:
        one.step(omega, 0.1)
        expected = expected * Rotation.from_rotvec(np.array(omega) * 0.1)
    assert (Rotation.from_quat(one.orientation) * expected.inv()).magnitude() < 1e-6
