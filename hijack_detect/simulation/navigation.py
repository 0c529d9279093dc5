# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The autopilot's estimate: inertial motion, corrected by the GPS.

A stand-in for the estimator of a real autopilot, and as trusting. Between fixes it integrates
its acceleration. A fix is compared with the belief of LAG_S ago and corrects it by fixed gains.
An innovation beyond its gate is refused at first; but a receiver that insists for RESET_S is
believed, position and velocity alike, and one that was silent for as long is believed at its
first word. So a smooth pull is followed at once, a large jump after a while, as with an autopilot
that resets to its GPS.

Height is that of an ideal barometer, carried along by the height of the fixes within some
seconds: a false height moves the vehicle, a frozen one does not make it climb for ever.
"""

from __future__ import annotations

import math
from collections import deque

from hijack_detect.streams.samples import Vector3

LAG_S = 0.15
"""The lag that the autopilot assumes; the receiver's own differs from it by up to 0.05 s."""
POSITION_GAIN = 0.15
"""The gains and bounds are chosen: an assumption, no copy of an autopilot (docs/simulator.md)."""
VELOCITY_FROM_POSITION = 0.02
"""1/s"""
VELOCITY_GAIN = 0.3
HEIGHT_GAIN = 0.2
CLIMB_FROM_HEIGHT = 0.15
"""1/s"""
GPS_HEIGHT_GAIN = 0.04
"""How much of the difference between GPS and barometer is made up with each fix: 5 s."""
POSITION_GATE = 12.0
"""Metres, horizontal; every gain is per fix."""
VELOCITY_GATE = 5.0
"""m/s, horizontal."""
RESET_S = 10.0
"""Time of rejection after which the position is reset to the fix."""


class Navigation:
    """Position and velocity as the autopilot believes them, metres and m/s in ENU."""

    def __init__(self, step_s: float) -> None:
        """Start at rest at the origin; `step_s` is the time between two calls of `predict`."""
        self.position: Vector3 = (0.0, 0.0, 0.0)
        self.velocity: Vector3 = (0.0, 0.0, 0.0)
        self._step_s = step_s
        self._height_offset = 0.0
        self._past: deque[tuple[Vector3, Vector3]] = deque(maxlen=1 + round(LAG_S / step_s))
        self._refused_since_s: float | None = None

    def predict(self, velocity_change: Vector3) -> None:
        """Move on by one step with the velocity change (m/s, ENU) that the IMU felt in it."""
        (px, py, pz), (vx, vy, vz), (dx, dy, dz) = self.position, self.velocity, velocity_change
        step = self._step_s
        self.position = (
            px + (vx + 0.5 * dx) * step,
            py + (vy + 0.5 * dy) * step,
            pz + (vz + 0.5 * dz) * step,
        )
        self.velocity = (vx + dx, vy + dy, vz + dz)
        self._past.append((self.position, self.velocity))

    def correct(self, position: Vector3, velocity: Vector3, height: float, now_s: float) -> None:
        """Take what the GPS reports.

        Args:
            position: Reported position, metres in ENU.
            velocity: Reported velocity, m/s in ENU.
            height: Height by the barometer now, metres.
            now_s: Time, seconds.
        """
        self._height_offset += GPS_HEIGHT_GAIN * (position[2] - height - self._height_offset)
        self._hold_height(height)
        (x, y, _), (u, v, _) = self._past[0] if self._past else (self.position, self.velocity)
        dx, dy = position[0] - x, position[1] - y
        du, dv = velocity[0] - u, velocity[1] - v
        near, alike = math.hypot(dx, dy) <= POSITION_GATE, math.hypot(du, dv) <= VELOCITY_GATE
        if near and alike:
            self._refused_since_s = None
        elif self._refused_since_s is None:
            self._refused_since_s = now_s
        elif now_s - self._refused_since_s >= RESET_S:
            self._refused_since_s = None
            self._move(dx, dy)
            self._accelerate(du, dv)
            return
        if near:
            self._move(POSITION_GAIN * dx, POSITION_GAIN * dy)
            self._accelerate(VELOCITY_FROM_POSITION * dx, VELOCITY_FROM_POSITION * dy)
        if alike:
            self._accelerate(VELOCITY_GAIN * du, VELOCITY_GAIN * dv)

    def miss(self, height: float, now_s: float) -> None:
        """Do without a fix that was due; a receiver that was away counts as refused.

        Args:
            height: Height by the barometer now, metres.
            now_s: Time, seconds.
        """
        if self._refused_since_s is None:
            self._refused_since_s = now_s
        self._hold_height(height)

    def _hold_height(self, barometer: float) -> None:
        """Follow the barometer with the shift that the reported heights gave it."""
        x, y, z = self.position
        off = barometer + self._height_offset - z
        self.position = (x, y, z + HEIGHT_GAIN * off)
        u, v, w = self.velocity
        self.velocity = (u, v, w + CLIMB_FROM_HEIGHT * off)

    def _move(self, east: float, north: float) -> None:
        x, y, z = self.position
        self.position = (x + east, y + north, z)

    def _accelerate(self, east: float, north: float) -> None:
        x, y, z = self.velocity
        self.velocity = (x + east, y + north, z)
