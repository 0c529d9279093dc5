# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attitude by quaternion integration alone: Feng et al. 2018, Eqs. 2-10.

This module keeps the paper's frames: body x right, y forward, z up; world x East, y North, z up.
M turns body into world. Angles are radians: yaw γ counter-clockwise from North, pitch θ about x,
roll β about y. Quaternions are (q0, q1, q2, q3) with the scalar first.
"""

from __future__ import annotations

import math

import numpy as np

from hijack_detect.estimation.rotation import Array, exponential, multiply, normalized
from hijack_detect.streams.samples import Quaternion, Vector3

PaperQuaternion = tuple[float, float, float, float]


def initial_matrix(pitch: float, roll: float, yaw: float) -> Array:
    """Initial M of Eq. 8 with its slips mended: R_z(γ) R_x(θ) R_y(β), shape (3, 3)."""
    st, ct = math.sin(pitch), math.cos(pitch)
    sb, cb = math.sin(roll), math.cos(roll)
    sg, cg = math.sin(yaw), math.cos(yaw)
    return np.array(
        [
            [cb * cg - sb * st * sg, -ct * sg, sb * cg + cb * st * sg],
            [cb * sg + sb * st * cg, ct * cg, sb * sg - cb * st * cg],
            [-sb * ct, st, cb * ct],
        ]
    )


def quaternion_of(m: Array) -> PaperQuaternion:
    """Quaternion of a rotation matrix, Eqs. 9 and 10 (the first sign is that of q0: +)."""
    diagonal = (m[0, 0], m[1, 1], m[2, 2])
    signs = (m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1])
    trace = math.fsum(diagonal)
    q = [
        math.copysign(0.5 * math.sqrt(max(0.0, 1.0 - trace + 2.0 * d)), sign)
        for d, sign in zip(diagonal, signs, strict=True)
    ]
    return (math.sqrt(max(0.0, 1.0 - math.fsum(x * x for x in q))), q[0], q[1], q[2])


def rotation_matrix(q: PaperQuaternion) -> Array:
    """M of Eq. 4, shape (3, 3)."""
    q0, q1, q2, q3 = q
    return np.array(
        [
            [q0**2 + q1**2 - q2**2 - q3**2, 2 * (q1 * q2 - q0 * q3), 2 * (q1 * q3 + q0 * q2)],
            [2 * (q1 * q2 + q0 * q3), q0**2 - q1**2 + q2**2 - q3**2, 2 * (q2 * q3 - q0 * q1)],
            [2 * (q1 * q3 - q0 * q2), 2 * (q2 * q3 + q0 * q1), q0**2 - q1**2 - q2**2 + q3**2],
        ]
    )


def yaw_of(m: Array) -> float:
    """γ of Eq. 2 within [0, 2π), counter-clockwise from North; no case is lost."""
    return math.atan2(-m[0, 1], m[1, 1]) % math.tau


def first_order_step(q: PaperQuaternion, omega: Vector3, dt: float) -> PaperQuaternion:
    """Eqs. 5-6: q + ½ Ω q Δt, normalised. `omega` is rad/s in the paper's body frame."""
    q0, q1, q2, q3 = q
    wx, wy, wh = omega
    half = 0.5 * dt
    x, y, z, w = normalized(
        (
            q1 + half * (wx * q0 + wh * q2 - wy * q3),
            q2 + half * (wy * q0 - wh * q1 + wx * q3),
            q3 + half * (wh * q0 + wy * q1 - wx * q2),
            q0 + half * (-wx * q1 - wy * q2 - wh * q3),
        )
    )
    return (w, x, y, z)


def exact_step(q: PaperQuaternion, omega: Vector3, dt: float) -> PaperQuaternion:
    """The same step, exact for a constant angular velocity (exponential map)."""
    turn = exponential((omega[0] * dt, omega[1] * dt, omega[2] * dt))
    x, y, z, w = normalized(multiply((q[1], q[2], q[3], q[0]), turn))
    return (w, x, y, z)


_FLU_TO_PAPER: Quaternion = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
"""Turns FLU components into the paper's: x right = -left, y forward = x."""


class QuaternionIntegration:
    """Integrates the gyroscope from a first yaw, level at the start."""

    def __init__(self, heading: float, *, first_order: bool) -> None:
        """Start with pitch and roll zero (text under Eq. 10).

        Args:
            heading: First course, radians counter-clockwise from East.
            first_order: Use Eqs. 5-6 as printed instead of the exact step.
        """
        self._q = quaternion_of(initial_matrix(0.0, 0.0, heading - math.pi / 2))
        self._step = first_order_step if first_order else exact_step

    def step(self, angular_velocity: Vector3, dt: float) -> None:
        """Advance by dt seconds with an angular velocity free of bias, rad/s, FLU."""
        forward, left, up = angular_velocity
        self._q = self._step(self._q, (-left, forward, up), dt)

    @property
    def orientation(self) -> Quaternion:
        """Attitude FLU → ENU, (x, y, z, w)."""
        q0, q1, q2, q3 = self._q
        return multiply((q1, q2, q3, q0), _FLU_TO_PAPER)
