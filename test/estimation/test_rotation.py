# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Rotations against SciPy's."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hijack_detect.estimation import rotation
from hijack_detect.streams.samples import Quaternion, Vector3

components = st.floats(-1.0, 1.0)
vectors = st.tuples(*[st.floats(-50.0, 50.0)] * 3)
angles = st.floats(-math.pi, math.pi)


@st.composite
def unit_quaternions(draw: st.DrawFn) -> Quaternion:
    q = draw(st.tuples(*[components] * 4).filter(lambda v: math.hypot(*v) > 0.1))
    length = math.hypot(*q)
    x, y, z, w = (value / length for value in q)
    return (x, y, z, w)


def same_rotation(q: Quaternion, expected: Rotation) -> bool:
    return (Rotation.from_quat(q) * expected.inv()).magnitude() < 1e-7


@given(unit_quaternions(), unit_quaternions())
def test_product_is_the_composition(a: Quaternion, b: Quaternion) -> None:
    expected = Rotation.from_quat(a) * Rotation.from_quat(b)
    assert same_rotation(rotation.multiply(a, b), expected)


@given(unit_quaternions(), vectors)
def test_rotate_and_matrix_turn_vectors_alike(q: Quaternion, v: Vector3) -> None:
    expected = Rotation.from_quat(q).apply(v)
    np.testing.assert_allclose(rotation.rotate(q, v), expected, atol=1e-9)
    np.testing.assert_allclose(rotation.matrix(q) @ v, expected, atol=1e-9)


@given(st.lists(unit_quaternions(), min_size=1, max_size=5))
def test_many_matrices(qs: list[Quaternion]) -> None:
    expected = Rotation.from_quat(qs).as_matrix()
    np.testing.assert_allclose(rotation.matrices(np.array(qs)), expected, atol=1e-12)


@given(vectors)
def test_exponential(v: Vector3) -> None:
    assert same_rotation(rotation.exponential(v), Rotation.from_rotvec(v))


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 9.99e-5, 1.01e-4, 1e-3, math.pi, 7.0])
def test_exponential_keeps_its_precision_at_every_size(angle: float) -> None:
    x, y, z, w = rotation.exponential((0.0, angle, 0.0))
    assert (x, z) == (0.0, 0.0)
    assert y == pytest.approx(math.sin(angle / 2), rel=1e-14, abs=1e-300)
    assert w == pytest.approx(math.cos(angle / 2), rel=1e-14, abs=1e-15)


@given(st.lists(vectors | st.tuples(*[st.floats(-1e-3, 1e-3)] * 3), min_size=1, max_size=6))
def test_many_exponentials(many: list[Vector3]) -> None:
    found = rotation.exponentials(np.array(many))
    np.testing.assert_allclose(found, [rotation.exponential(v) for v in many], atol=1e-14)


@given(angles, st.floats(-1.57, 1.57), angles)
def test_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> None:
    expected = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    q = rotation.from_roll_pitch_yaw(roll, pitch, yaw)
    assert same_rotation(q, expected)
    back = rotation.roll_pitch_yaw(q)
    assert same_rotation(rotation.from_roll_pitch_yaw(*back), expected)
    if abs(pitch) < 1.5:
        found = math.remainder(back[2] - yaw, math.tau)
        assert found == pytest.approx(0.0, abs=1e-9)
        assert rotation.heading(q) == back[2]


@given(unit_quaternions())
def test_roll_pitch_yaw_never_fails(q: Quaternion) -> None:
    assert all(math.isfinite(angle) for angle in rotation.roll_pitch_yaw(q))


def test_roll_pitch_yaw_at_the_gimbal_lock_and_beyond_rounding() -> None:
    half = math.sqrt(0.5)
    assert rotation.roll_pitch_yaw((0.0, half, 0.0, half))[1] == pytest.approx(math.pi / 2)
    above = half * (1 + 1e-15)
    assert rotation.roll_pitch_yaw((0.0, above, 0.0, above))[1] == pytest.approx(math.pi / 2)


def test_heading_of_the_four_directions() -> None:
    for quarter, expected in enumerate([0.0, math.pi / 2, math.pi, -math.pi / 2]):
        half = quarter * math.pi / 4
        found = rotation.heading((0.0, 0.0, math.sin(half), math.cos(half)))
        assert math.remainder(found - expected, math.tau) == pytest.approx(0.0, abs=1e-15)


@given(st.floats(-1e6, 1e6))
def test_wrap(angle: float) -> None:
    wrapped = rotation.wrap(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


def test_wrap_closes_on_the_side_of_plus_pi() -> None:
    assert rotation.wrap(math.pi) == math.pi
    assert rotation.wrap(-math.pi) == math.pi
    assert rotation.wrap(3 * math.pi) == pytest.approx(math.pi)


@given(angles, st.floats(-1.5, 1.5), angles)
def test_level_finds_roll_and_pitch_of_a_body_at_rest(
    roll: float, pitch: float, yaw: float
) -> None:
    body = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    found_roll, found_pitch = rotation.level(tuple(body.inv().apply([0.0, 0.0, 9.81])))
    assert math.remainder(found_roll - roll, math.tau) == pytest.approx(0.0, abs=1e-9)
    assert found_pitch == pytest.approx(pitch, abs=1e-9)


@given(st.tuples(components, components, components, components).filter(any))
def test_normalized(q: Quaternion) -> None:
    scale = max(abs(value) for value in q)
    if scale < 1e-100:
        return
    found = rotation.normalized(q)
    assert math.hypot(*found) == pytest.approx(1.0)
    np.testing.assert_allclose(np.array(found) * math.hypot(*q), q, atol=1e-15)


@given(vectors, vectors)
def test_skew_is_the_cross_product(v: Vector3, u: Vector3) -> None:
    product = rotation.skew(np.array([v, u])) @ np.array(u)
    np.testing.assert_allclose(product[0], np.cross(v, u), atol=1e-9)
    np.testing.assert_allclose(product[1], np.zeros(3), atol=1e-9)
