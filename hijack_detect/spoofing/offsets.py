# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attacks that add an offset to the true motion: jump, drift, altitude, jitter.

Pure functions of the time since onset. Offsets are metres, their rates m/s, both in ENU of the
tangent plane at the onset.
"""

from __future__ import annotations

import math
from typing import Protocol

from hijack_detect.spoofing import schema
from hijack_detect.spoofing.draws import generator
from hijack_detect.streams.samples import Vector3

_POSITION_STREAM, _VELOCITY_STREAM = 0, 1


class Offset(Protocol):
    """An offset of the true position and velocity."""

    def position(self, t_s: float, stamp_ns: int) -> Vector3:
        """Offset of the position (ENU, m) `t_s` seconds after onset."""
        ...

    def velocity(self, t_s: float, stamp_ns: int) -> Vector3:
        """Offset of the velocity (ENU, m/s) `t_s` seconds after onset."""
        ...


def make_offset(
    model: schema.Jump | schema.Drift | schema.Altitude | schema.Jitter, course: float
) -> Offset:
    """Choose the offset for a model; `course` (radians from North) turns relative bearings."""
    if isinstance(model, schema.Jump):
        return JumpOffset(model, course)
    if isinstance(model, schema.Drift):
        return DriftOffset(model, course)
    if isinstance(model, schema.Altitude):
        return AltitudeOffset(model)
    return JitterOffset(model)


def ramp(t_s: float, speed: float, acceleration: float | None) -> tuple[float, float]:
    """Distance (m) and speed (m/s) of a motion that builds up to `speed` and keeps it.

    With T = |speed| / a: d = a t² / 2 up to T, then speed (t - T / 2). Without an acceleration
    the speed is there at once.
    """
    if acceleration is None:
        return (speed * t_s, speed)
    build_up = abs(speed) / acceleration
    if t_s < build_up:
        rate = math.copysign(acceleration * t_s, speed)
        return (0.5 * rate * t_s, rate)
    return (speed * (t_s - 0.5 * build_up), speed)


class JumpOffset:
    """A constant displacement; its rate is zero."""

    def __init__(self, model: schema.Jump, course: float) -> None:
        """Fix the displacement."""
        east, north = _direction(model.bearing_deg, course if model.relative else 0.0)
        self._offset: Vector3 = (model.distance_m * east, model.distance_m * north, 0.0)

    def position(self, t_s: float, stamp_ns: int) -> Vector3:
        """See Offset."""
        return self._offset

    def velocity(self, t_s: float, stamp_ns: int) -> Vector3:
        """See Offset."""
        return (0.0, 0.0, 0.0)


class DriftOffset:
    """A displacement that grows along one bearing."""

    def __init__(self, model: schema.Drift, course: float) -> None:
        """Fix the direction."""
        self._model = model
        self._direction = _direction(model.bearing_deg, course if model.relative else 0.0)

    def position(self, t_s: float, stamp_ns: int) -> Vector3:
        """See Offset."""
        distance, _ = ramp(t_s, self._model.speed_m_s, self._model.onset_acceleration_m_s2)
        return (distance * self._direction[0], distance * self._direction[1], 0.0)

    def velocity(self, t_s: float, stamp_ns: int) -> Vector3:
        """See Offset."""
        _, speed = ramp(t_s, self._model.speed_m_s, self._model.onset_acceleration_m_s2)
        return (speed * self._direction[0], speed * self._direction[1], 0.0)


class AltitudeOffset:
    """A step and a ramp of height."""

    def __init__(self, model: schema.Altitude) -> None:
        """Keep the model."""
        self._model = model

    def position(self, t_s: float, stamp_ns: int) -> Vector3:
        """See Offset."""
        height, _ = ramp(t_s, self._model.rate_m_s, self._model.onset_acceleration_m_s2)
        return (0.0, 0.0, self._model.step_m + height)

    def velocity(self, t_s: float, stamp_ns: int) -> Vector3:
        """See Offset."""
        _, rate = ramp(t_s, self._model.rate_m_s, self._model.onset_acceleration_m_s2)
        return (0.0, 0.0, rate)


class JitterOffset:
    """White noise that depends on seed and stamp only."""

    def __init__(self, model: schema.Jitter) -> None:
        """Keep the model."""
        self._model = model

    def position(self, t_s: float, stamp_ns: int) -> Vector3:
        """See Offset."""
        east, north, up = self._normal(stamp_ns, _POSITION_STREAM)
        sigma = self._model.sigma_m
        return (sigma * east, sigma * north, self._model.vertical_sigma_m * up)

    def velocity(self, t_s: float, stamp_ns: int) -> Vector3:
        """See Offset."""
        if self._model.sigma_m_s == 0.0:
            return (0.0, 0.0, 0.0)
        east, north, _ = self._normal(stamp_ns, _VELOCITY_STREAM)
        return (self._model.sigma_m_s * east, self._model.sigma_m_s * north, 0.0)

    def _normal(self, stamp_ns: int, stream: int) -> Vector3:
        draws = generator(self._model.seed, stamp_ns, stream)
        east, north, up = draws.standard_normal(3).tolist()
        return (east, north, up)


def _direction(bearing_deg: float, course: float) -> tuple[float, float]:
    """East and North of a bearing in degrees clockwise from `course` (radians from North)."""
    bearing = math.radians(bearing_deg) + course
    return (math.sin(bearing), math.cos(bearing))
