# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A multirotor as its sensors see it: thrust along z, drag, and a lag in everything.

    a = R f - g,    f = (-d u, -d v, T),    d = drag + drag_quadratic |air|

with the air velocity (u, v, w) in body axes. Forces are per mass. The inner loops of attitude
and motors, which turn commands into torques, are a second-order response of the attitude and
a first-order lag of the thrust. Plain floats: an array of three costs more than its arithmetic.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from hijack_detect.streams.samples import Quaternion, Vector3

GRAVITY = 9.80665
"""m/s²: standard gravity."""
TILT_RATE = 10.0
"""Natural frequency of roll and pitch, rad/s: a tilt follows its command by 0.16 s.
Chosen, as the dampings and the two below, for a small multirotor."""
TILT_DAMPING = 0.8
YAW_RATE = 6.0
"""Natural frequency of yaw, rad/s: the nose follows its command by 0.3 s."""
YAW_DAMPING = 0.9
THRUST_S = 0.05
"""Time constant of the thrust, seconds."""


@dataclass(slots=True)
class Multirotor:
    """The true state, moved on by `step`.

    Attributes:
        drag: Linear drag along body x and y, 1/s.
        drag_quadratic: Drag that grows with the air speed, 1/m.
        attitude: (x, y, z, w), turns FLU into ENU.
        position: Metres in ENU; the ground is at height 0.
        velocity: m/s in ENU.
        acceleration: m/s² in ENU.
        specific_force: m/s² in FLU, what an ideal accelerometer feels.
        rate: Angular velocity, rad/s in FLU.
        thrust: m/s².
        on_ground: Whether the ground carries the vehicle.
    """

    drag: float
    drag_quadratic: float
    attitude: Quaternion
    position: Vector3 = (0.0, 0.0, 0.0)
    velocity: Vector3 = (0.0, 0.0, 0.0)
    acceleration: Vector3 = (0.0, 0.0, 0.0)
    specific_force: Vector3 = (0.0, 0.0, GRAVITY)
    rate: Vector3 = (0.0, 0.0, 0.0)
    thrust: float = 0.0
    on_ground: bool = True

    def step(self, thrust: float, attitude: Quaternion, wind: Vector3, step_s: float) -> None:
        """Move on by `step_s` seconds with commands held.

        Heun's method: exact for constant forces, of second order otherwise.

        Args:
            thrust: Commanded thrust per mass, m/s².
            attitude: Commanded attitude, FLU to ENU.
            wind: Velocity of the air, m/s in ENU.
            step_s: Seconds, well below the lags.
        """
        self.thrust += (thrust - self.thrust) * -math.expm1(-step_s / THRUST_S)
        if not self.on_ground:
            self._turn(attitude, step_s)
        a0, (v0, v1, v2), (p0, p1, p2) = self.acceleration, self.velocity, self.position
        ahead = (v0 + a0[0] * step_s, v1 + a0[1] * step_s, v2 + a0[2] * step_s)
        a1 = self._forces(ahead, wind)
        half = 0.5 * step_s
        velocity = (
            v0 + (a0[0] + a1[0]) * half,
            v1 + (a0[1] + a1[1]) * half,
            v2 + (a0[2] + a1[2]) * half,
        )
        height = p2 + (v2 + a0[2] * half) * step_s
        if height <= 0.0 and a1[2] <= 0.0:
            self._rest(p0, p1)
            return
        self.on_ground = False
        self.acceleration, self.velocity = a1, velocity
        self.position = (
            p0 + (v0 + a0[0] * half) * step_s,
            p1 + (v1 + a0[1] * half) * step_s,
            height,
        )

    def _turn(self, command: Quaternion, step_s: float) -> None:
        """Turn towards the commanded attitude."""
        x, y, z, w = self.attitude
        cx, cy, cz, cw = command
        sign = 2.0 if w * cw + x * cx + y * cy + z * cz >= 0.0 else -2.0
        ex = sign * (w * cx - x * cw - y * cz + z * cy)
        ey = sign * (w * cy + x * cz - y * cw - z * cx)
        ez = sign * (w * cz - x * cy + y * cx - z * cw)
        rx, ry, rz = self.rate
        stiff, damp = TILT_RATE**2 * step_s, 2.0 * TILT_DAMPING * TILT_RATE * step_s
        rx += stiff * ex - damp * rx
        ry += stiff * ey - damp * ry
        rz += YAW_RATE**2 * step_s * ez - 2.0 * YAW_DAMPING * YAW_RATE * step_s * rz
        self.rate = (rx, ry, rz)
        hx, hy, hz = 0.5 * step_s * rx, 0.5 * step_s * ry, 0.5 * step_s * rz
        nx = x + w * hx + y * hz - z * hy
        ny = y + w * hy + z * hx - x * hz
        nz = z + w * hz + x * hy - y * hx
        nw = w - x * hx - y * hy - z * hz
        scale = 1.0 / math.sqrt(nx * nx + ny * ny + nz * nz + nw * nw)
        self.attitude = (nx * scale, ny * scale, nz * scale, nw * scale)

    def _forces(self, velocity: Vector3, wind: Vector3) -> Vector3:
        """Set the specific force; return the acceleration in ENU."""
        x, y, z, w = self.attitude
        xx, xy, xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
        yx, yy, yz = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
        zx, zy, zz = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
        ae, an, au = velocity[0] - wind[0], velocity[1] - wind[1], velocity[2] - wind[2]
        drag = self.drag + self.drag_quadratic * math.sqrt(ae * ae + an * an + au * au)
        fx = -drag * (xx * ae + xy * an + xz * au)
        fy = -drag * (yx * ae + yy * an + yz * au)
        fz = self.thrust
        self.specific_force = (fx, fy, fz)
        return (
            xx * fx + yx * fy + zx * fz,
            xy * fx + yy * fy + zy * fz,
            xz * fx + yz * fy + zz * fz - GRAVITY,
        )

    def _rest(self, east: float, north: float) -> None:
        """Stop on the ground, which carries the weight."""
        x, y, z, w = self.attitude
        self.on_ground = True
        self.position = (east, north, 0.0)
        self.velocity = self.acceleration = self.rate = (0.0, 0.0, 0.0)
        self.specific_force = (
            2.0 * (x * z - w * y) * GRAVITY,
            2.0 * (y * z + w * x) * GRAVITY,
            (1.0 - 2.0 * (x * x + y * y)) * GRAVITY,
        )
