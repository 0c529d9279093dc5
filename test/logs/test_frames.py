# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Frames against SciPy's rotations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hijack_detect.estimation.rotation import rotate
from hijack_detect.logs.frames import attitude, enu, flu, from_angles

angles = st.floats(-math.pi, math.pi)


@given(angles, st.floats(-1.5, 1.5), angles)
def test_roll_pitch_and_yaw_turn_body_into_world(roll: float, pitch: float, yaw: float) -> None:
    """Turning and then changing the frame is changing the frame and then turning."""
    frd_to_ned = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    body = (1.0, -2.0, 3.0)
    wanted = enu(*frd_to_ned.apply(body))
    assert rotate(from_angles(roll, pitch, yaw), flu(*body)) == pytest.approx(wanted, abs=1e-9)
    x, y, z, w = frd_to_ned.as_quat()
    assert rotate(attitude((x, y, z, w)), flu(*body)) == pytest.approx(wanted, abs=1e-9)


def test_level_and_heading_to_the_north() -> None:
    north = from_angles(0.0, 0.0, 0.0)
    assert np.allclose(rotate(north, (1.0, 0.0, 0.0)), (0.0, 1.0, 0.0), atol=1e-12)
    assert np.allclose(rotate(north, (0.0, 1.0, 0.0)), (-1.0, 0.0, 0.0), atol=1e-12)
    assert np.allclose(rotate(north, (0.0, 0.0, 1.0)), (0.0, 0.0, 1.0), atol=1e-12)
