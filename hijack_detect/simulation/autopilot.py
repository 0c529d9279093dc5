# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Flies the route by what the navigation believes: position, velocity, tilt, heading.

The target point moves along the route and waits when the vehicle falls behind. Position error
asks for velocity, velocity error for acceleration (with an integral against wind and drag), and
the thrust is laid along the acceleration. The nose turns with the target, so under a smooth
attack heading and reported course keep agreeing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from hijack_detect.simulation.route import RATE_HZ, Route
from hijack_detect.simulation.vehicle import GRAVITY
from hijack_detect.streams.samples import Quaternion, Vector3

STEP_S = 1.0 / RATE_HZ
POSITION_GAIN = 1.0
"""1/s. All numbers of this controller are chosen; docs/simulator.md has how well it flies."""
VELOCITY_GAIN = 2.5
"""1/s"""
INTEGRAL_GAIN = 1.0
"""1/s²"""
MAX_INTEGRAL = 5.0
"""m/s²: what wind and drag may cost."""
MAX_CORRECTION = 4.0
"""m/s: how much a position error may add to the speed of the route."""
MAX_CLIMB_CORRECTION = 2.0
"""m/s"""
MAX_TILT = math.radians(35.0)
MAX_CLIMB_ACCELERATION = 4.0
"""m/s²"""
LEASH_M = 20.0
"""Position error at which the target stands; it slows down from half of that on."""


@dataclass(frozen=True, slots=True)
class Command:
    """A command to the vehicle: thrust per mass (m/s²) and attitude (FLU to ENU)."""

    thrust: float
    attitude: Quaternion


class Autopilot:
    """Makes a command of a belief, RATE_HZ times a second."""

    def __init__(self, route: Route, compass_error: float) -> None:
        """Take the route and the constant error of the heading in radians."""
        self._rows = list(
            zip(
                *(part.tolist() for part in (route.position, route.velocity, route.acceleration)),
                strict=True,
            )
        )
        self._yaws: list[float] = route.yaw.tolist()
        self._turn_most = route.max_yaw_rate * STEP_S
        self._compass_error = compass_error
        self._yaw = self._yaws[0]
        self._progress = 0.0
        self._integral: Vector3 = (0.0, 0.0, 0.0)
        self.target: Vector3 = (0.0, 0.0, 0.0)

    def command(self, position: Vector3, velocity: Vector3, *, flying: bool) -> Command:
        """Move the target on and fly to it.

        Args:
            position: Believed position, metres in ENU.
            velocity: Believed velocity, m/s in ENU.
            flying: False on the ground, where the integral would only wind up.
        """
        row = min(int(self._progress), len(self._rows) - 1)
        (px, py, pz), (vx, vy, vz), (ax, ay, az) = self._rows[row]
        part = (self._progress - row) * STEP_S
        self.target = (px + part * vx, py + part * vy, pz + part * vz)
        ex, ey, ez = (there - here for there, here in zip(self.target, position, strict=True))
        pace = min(max(2.0 - 2.0 * math.hypot(ex, ey) / LEASH_M, 0.0), 1.0)
        self._progress = min(self._progress + pace, len(self._rows) - 1.0)
        self._turn(self._yaws[row])

        cx, cy = _within(POSITION_GAIN * ex, POSITION_GAIN * ey, MAX_CORRECTION)
        cz = min(max(POSITION_GAIN * ez, -MAX_CLIMB_CORRECTION), MAX_CLIMB_CORRECTION)
        rx = pace * vx + cx - velocity[0]
        ry = pace * vy + cy - velocity[1]
        rz = vz + cz - velocity[2]
        ix, iy, iz = self._integral
        up = az + VELOCITY_GAIN * rz + iz
        up = min(max(up, -MAX_CLIMB_ACCELERATION), MAX_CLIMB_ACCELERATION) + GRAVITY
        wanted_x = pace * ax + VELOCITY_GAIN * rx + ix
        wanted_y = pace * ay + VELOCITY_GAIN * ry + iy
        fx, fy = _within(wanted_x, wanted_y, up * math.tan(MAX_TILT))
        if flying and (fx, fy) == (wanted_x, wanted_y):
            gain = INTEGRAL_GAIN * STEP_S
            ix, iy = _within(ix + gain * rx, iy + gain * ry, MAX_INTEGRAL)
            iz = min(max(iz + gain * rz, -MAX_INTEGRAL), MAX_INTEGRAL)
            self._integral = (ix, iy, iz)
        return Command(
            math.sqrt(fx * fx + fy * fy + up * up),
            pointing((fx, fy, up), self._yaw + self._compass_error),
        )

    def _turn(self, wanted: float) -> None:
        """Turn the commanded heading towards the planned one, no faster than a vehicle does."""
        self._yaw += min(max(wanted - self._yaw, -self._turn_most), self._turn_most)


def pointing(up: Vector3, yaw: float) -> Quaternion:
    """Attitude (FLU to ENU) with body z along `up` and body x in the vertical plane of `yaw`.

    Args:
        up: Any vector that does not lie in the horizontal plane, ENU.
        yaw: Radians counter-clockwise from East.
    """
    cosine, sine = math.cos(yaw), math.sin(yaw)
    forward = cosine * up[0] + sine * up[1]
    left = -sine * up[0] + cosine * up[1]
    pitch = 0.5 * math.atan2(forward, up[2])
    roll = -0.5 * math.asin(left / math.sqrt(up[0] ** 2 + up[1] ** 2 + up[2] ** 2))
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    return (
        cy * cp * sr - sy * sp * cr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
        cy * cp * cr + sy * sp * sr,
    )


def _within(x: float, y: float, most: float) -> tuple[float, float]:
    """Shorten a horizontal vector to a length."""
    length = math.hypot(x, y)
    if length <= most:
        return x, y
    return x * most / length, y * most / length
