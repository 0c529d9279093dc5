# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Horizontal specific force of a multirotor by its motion through the air.

    f = -(k + q |a|) a

in body x and y, with the velocity through the air a (m/s), drag k (1/s) and q (1/m). Rotors and
frame resist the air; thrust has no part along x and y, so neither have tilt and acceleration.
"""

from __future__ import annotations

import numpy as np

from hijack_detect.estimation.rotation import Array

SMALLEST_DRAG = 0.02
"""1/s; no filter believes less, where a wind would be infinite."""


def drag_force(air: Array, drag: float, quadratic: float) -> tuple[Array, Array, Array]:
    """Specific force f (n, 2), m/s², and its derivatives (n, 2, 2) by the velocity and by (k, q).

    Args:
        air: Velocity through the air, body x and y, shape (n, 2), m/s.
        drag: k, 1/s.
        quadratic: q, 1/m.
    """
    speed = np.sqrt(np.sum(air**2, axis=1) + 1e-6)[:, None]
    resistance = drag + quadratic * speed
    by_air = -resistance[:, :, None] * np.eye(2) - quadratic * (
        air[:, :, None] * air[:, None, :] / speed[:, :, None]
    )
    return -resistance * air, by_air, np.stack([-air, -speed * air], axis=2)
