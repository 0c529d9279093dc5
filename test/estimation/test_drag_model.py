# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The force of drag: by hand, and its derivatives by differences."""

from __future__ import annotations

import numpy as np
import pytest

from hijack_detect.estimation.drag_filter import drag_force


def test_by_hand() -> None:
    """5 m/s at 3:4, k = 0.2 and q = 0.02: 0.3 1/s against each component."""
    force, _, _ = drag_force(np.array([[3.0, -4.0], [0.0, 0.0]]), 0.2, 0.02)
    np.testing.assert_allclose(force, [[-0.9, 1.2], [0.0, 0.0]], atol=1e-6)


@pytest.mark.parametrize("air", [(3.0, -4.0), (-0.5, 0.1), (12.0, 7.0), (0.0, 0.2)])
def test_the_derivatives_are_those_of_the_force(air: tuple[float, float]) -> None:
    at, drag, quadratic, step = np.array([air]), 0.25, 0.015, 1e-5

    def force(change: tuple[float, float], k: float = 0.0, q: float = 0.0) -> np.ndarray:
        return drag_force(at + step * np.array(change), drag + step * k, quadratic + step * q)[0]

    _, by_air, by_drag = drag_force(at, drag, quadratic)
    for axis in range(2):
        unit = (1.0 - axis, float(axis))
        opposite = (-unit[0], -unit[1])
        slope = (force(unit) - force(opposite)) / (2.0 * step)
        np.testing.assert_allclose(by_air[0, :, axis], slope[0], atol=1e-5)
        slope = (force((0.0, 0.0), *unit) - force((0.0, 0.0), *opposite)) / (2.0 * step)
        np.testing.assert_allclose(by_drag[0, :, axis], slope[0], atol=1e-5)
