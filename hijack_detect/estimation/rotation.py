# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Rotations as quaternions (x, y, z, w) that turn body FLU vectors into ENU."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hijack_detect.streams.samples import Quaternion, Vector3

Array = npt.NDArray[np.float64]


UNIT = np.eye(3)
CROSS = np.cross(UNIT[:, None], UNIT[None]).transpose(0, 2, 1).reshape(3, 9)
"""A vector times this is its matrix of the cross product."""
SMALLEST_RAD = 1e-100
"""Keeps the sine of no rotation over itself at one."""


def wrap(angle: float) -> float:
    """Wrap an angle in radians to (-π, π]."""
    wrapped = math.remainder(angle, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


def up_component(q: Quaternion) -> float:
    """Cosine of the tilt: the Up component of the body's z axis."""
    x, y, _, _ = q
    return 1.0 - 2.0 * (x * x + y * y)


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Hamilton product: the rotation b followed by a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def normalized(q: Quaternion) -> Quaternion:
    """The quaternion scaled to length one."""
    x, y, z, w = q
    scale = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    return (x * scale, y * scale, z * scale, w * scale)


def exponential(vector: Vector3) -> Quaternion:
    """Rotation by a rotation vector in radians: exact for a constant angular velocity."""
    x, y, z = vector
    angle = math.sqrt(x * x + y * y + z * z)
    half = 0.5 * angle
    scale = 0.5 - angle * angle / 48.0 if angle < 1e-4 else math.sin(half) / angle
    return (x * scale, y * scale, z * scale, math.cos(half))


def exponentials(vectors: Array) -> Array:
    """Rotations by rotation vectors of shape (n, 3), rad, as quaternions of shape (n, 4)."""
    half = 0.5 * np.sqrt((vectors * vectors).sum(axis=1, keepdims=True))
    out = np.empty((len(vectors), 4))
    out[:, :3] = vectors * (0.5 * np.sin(half + SMALLEST_RAD) / (half + SMALLEST_RAD))
    out[:, 3:] = np.cos(half)
    return out


def from_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Rotation R_z(yaw) R_y(pitch) R_x(roll), radians; pitch is positive nose down in FLU."""
    qz = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    qy = (0.0, math.sin(pitch / 2), 0.0, math.cos(pitch / 2))
    qx = (math.sin(roll / 2), 0.0, 0.0, math.cos(roll / 2))
    return multiply(multiply(qz, qy), qx)


def roll_pitch_yaw(q: Quaternion) -> Vector3:
    """Angles of R_z(yaw) R_y(pitch) R_x(roll) in radians."""
    x, y, z, w = q
    sine = max(-1.0, min(1.0, 2.0 * (w * y - z * x)))
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(sine),
        heading(q),
    )


def heading(q: Quaternion) -> float:
    """Heading of the body's x axis, radians counter-clockwise from East."""
    x, y, z, w = q
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def level(specific_force: Vector3) -> tuple[float, float]:
    """Roll and pitch of a body that does not accelerate, from its specific force."""
    x, y, z = specific_force
    return math.atan2(y, z), -math.atan2(x, math.hypot(y, z))


def matrix(q: Quaternion) -> Array:
    """Rotation matrix, shape (3, 3), that turns FLU into ENU."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def matrices(q: Array) -> Array:
    """Rotation matrices, shape (n, 3, 3), of unit quaternions of shape (n, 4)."""
    turned: Array = skew(2.0 * q[:, :3])
    out: Array = (q[:, 3, None, None] * turned) + 0.5 * turned @ turned + UNIT
    return out


def rotate(q: Quaternion, v: Vector3) -> Vector3:
    """Turn a body vector into ENU."""
    x, y, z, w = q
    vx, vy, vz = v
    tx = 2.0 * (y * vz - z * vy)
    ty = 2.0 * (z * vx - x * vz)
    tz = 2.0 * (x * vy - y * vx)
    return (
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


def skew(v: Array) -> Array:
    """Matrices [v]× of vectors (..., 3), so that [v]× u = v × u; shape (..., 3, 3)."""
    crossed: Array = v @ CROSS
    return crossed.reshape(*v.shape[:-1], 3, 3)
