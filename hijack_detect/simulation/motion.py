"""The attitude a multirotor needs for its motion, and what perfect sensors would feel.

A multirotor pushes along its own z axis and is dragged by the air along its x and y axes:

    R f = a - g,    f = (-k u, -k v, T)

with the air velocity (u, v, w) in body axes. So its z axis points along a - g + k v_air.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hijack_detect.estimation.rotation import matrices
from hijack_detect.simulation.kinematics import RATE_HZ, Array, Kinematics

IMU_HZ = 100
DRAG = 0.25
"""Rotor drag over mass, 1/s: 8 m/s of air tilt the vehicle by 11°."""
GRAVITY = 9.80665
"""m/s²"""


@dataclass(frozen=True)
class Motion:
    """Truth at the rate of the IMU; vectors of shape (n, 3).

    Attributes:
        offsets_ns: Time from the start, nanoseconds.
        position: Metres in ENU.
        velocity: m/s in ENU.
        acceleration: m/s² in ENU.
        quaternion: (x, y, z, w), turns FLU into ENU, shape (n, 4).
        angular_velocity: rad/s in FLU: the constant rate that turns the attitude of the sample
            before into this one, so that q[k] = q[k-1] exp(angular_velocity[k] / IMU_HZ).
        specific_force: m/s² in FLU: Rᵀ (acceleration - gravity).
        airborne: 0 on the ground, 1 in flight.
    """

    offsets_ns: npt.NDArray[np.int64]
    position: Array
    velocity: Array
    acceleration: Array
    quaternion: Array
    angular_velocity: Array
    specific_force: Array
    airborne: Array


def motion(path: Kinematics) -> Motion:
    """Add attitude, body rates and specific force to a motion."""
    step = RATE_HZ // IMU_HZ
    acceleration = path.acceleration[::step]
    airborne = path.airborne[::step]
    air = (path.velocity - path.wind)[::step]
    felt = acceleration + np.array([0.0, 0.0, GRAVITY])
    thrust = felt + DRAG * airborne[:, None] * air
    quaternion = attitudes(thrust, path.yaw[::step])
    return Motion(
        offsets_ns=np.arange(len(acceleration), dtype=np.int64) * (1_000_000_000 // IMU_HZ),
        position=path.position[::step],
        velocity=path.velocity[::step],
        acceleration=acceleration,
        quaternion=quaternion,
        angular_velocity=body_rates(quaternion, 1.0 / IMU_HZ),
        specific_force=np.einsum("nji,nj->ni", matrices(quaternion), felt),
        airborne=airborne,
    )


def attitudes(up: Array, yaw: Array) -> Array:
    """Return the quaternions (n, 4) that point body z along `up` (n, 3) and body x to `yaw`.

    Continuous as long as `up` never lies in the horizontal plane.
    """
    cosine, sine = np.cos(yaw), np.sin(yaw)
    forward = cosine * up[:, 0] + sine * up[:, 1]
    left = -sine * up[:, 0] + cosine * up[:, 1]
    pitch = np.arctan2(forward, up[:, 2])
    roll = -np.arcsin(left / np.linalg.norm(up, axis=1))
    cr, sr = np.cos(roll / 2), np.sin(roll / 2)
    cp, sp = np.cos(pitch / 2), np.sin(pitch / 2)
    cy, sy = np.cos(yaw / 2), np.sin(yaw / 2)
    return np.stack(
        [
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
            cy * cp * cr + sy * sp * sr,
        ],
        axis=1,
    )


def body_rates(quaternion: Array, step_s: float) -> Array:
    """Return the constant body rate (rad/s) from each attitude to the next; the first is zero."""
    x0, y0, z0, w0 = quaternion[:-1].T
    x1, y1, z1, w1 = quaternion[1:].T
    vector = np.stack(
        [
            w0 * x1 - x0 * w1 - y0 * z1 + z0 * y1,
            w0 * y1 + x0 * z1 - y0 * w1 - z0 * x1,
            w0 * z1 - x0 * y1 + y0 * x1 - z0 * w1,
        ],
        axis=1,
    )
    sine = np.linalg.norm(vector, axis=1)
    cosine = w0 * w1 + x0 * x1 + y0 * y1 + z0 * z1
    angle = 2.0 * np.arctan2(sine, cosine)
    scale = np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 2.0)
    return np.concatenate([np.zeros((1, 3)), scale[:, None] * vector / step_s])
