# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attacks that replace the true motion by a track: fake_track and turn_away.

Pure functions of the time since onset. Positions are metres from the position at onset,
velocities their exact derivatives in m/s, both in ENU of the tangent plane at the onset.
"""

from __future__ import annotations

import bisect
import math
from typing import Protocol

import numpy as np

from hijack_detect.estimation.rotation import Array
from hijack_detect.spoofing import schema
from hijack_detect.spoofing.onset import Onset
from hijack_detect.streams.samples import Vector3


class Track(Protocol):
    """A reported motion that ignores the vehicle."""

    keeps_altitude: bool
    """Whether height and climb stay the true ones."""

    def position(self, t_s: float) -> Vector3:
        """ENU metres from the position at onset, `t_s` seconds after it."""
        ...

    def velocity(self, t_s: float) -> Vector3:
        """ENU velocity, m/s, `t_s` seconds after onset."""
        ...


def make_track(model: schema.FakeTrack | schema.TurnAway, onset: Onset) -> Track:
    """Choose the track for a model and the vehicle's state at onset."""
    if isinstance(model, schema.TurnAway):
        return TurnTrack(model, onset)
    return ListedTrack(model, onset)


class TurnTrack:
    """Constant ground speed, a turn at constant rate, then straight on."""

    keeps_altitude = True

    def __init__(self, model: schema.TurnAway, onset: Onset) -> None:
        """Start on the course at onset, with the ground speed at onset unless one is given.

        A vehicle without a course (below 0.5 m/s) starts with its course North, and stands
        unless the model gives a speed.
        """
        self._course = onset.course
        self._speed = onset.speed if model.speed_m_s is None else model.speed_m_s
        self._rate = math.copysign(math.radians(model.rate_deg_s), model.angle_deg)
        self._turn_s = abs(model.angle_deg) / model.rate_deg_s

    def position(self, t_s: float) -> Vector3:
        """See Track. The chord of an arc: v t sinc(w t / 2) along the mean course."""
        turning = min(t_s, self._turn_s)
        half = 0.5 * self._rate * turning
        chord = self._speed * turning * (math.sin(half) / half if half else 1.0)
        straight = self._speed * (t_s - turning)
        mean, final = self._course + half, self._course + 2.0 * half
        return (
            chord * math.sin(mean) + straight * math.sin(final),
            chord * math.cos(mean) + straight * math.cos(final),
            0.0,
        )

    def velocity(self, t_s: float) -> Vector3:
        """See Track."""
        course = self._course + self._rate * min(t_s, self._turn_s)
        return (self._speed * math.sin(course), self._speed * math.cos(course), 0.0)


class ListedTrack:
    """A cubic Hermite curve through listed positions; after the last one its velocity is held.

    The slope at a position is that of the parabola through it and its neighbours, at the two
    ends that of the first and last leg: position and velocity are continuous.
    """

    keeps_altitude = False

    def __init__(self, model: schema.FakeTrack, onset: Onset) -> None:
        """Turn and scale the list by the model."""
        rows = np.array([schema.padded(row) for row in model.positions])
        times, points = rows[:, 0], rows[:, 1:]
        if model.frame == "course":
            points = points @ _course_axes(onset.course)
        slopes = _slopes(times, points)
        if model.speed_scale == "flight":
            scale = onset.speed / math.hypot(slopes[0, 0], slopes[0, 1])
            points, slopes = points * scale, slopes * scale
        self._times: list[float] = times.tolist()
        self._points = points
        self._slopes = slopes

    def position(self, t_s: float) -> Vector3:
        """See Track."""
        if t_s >= self._times[-1]:
            return _vector(self._points[-1] + (t_s - self._times[-1]) * self._slopes[-1])
        leg, step, s = self._leg(t_s)
        p0, p1 = self._points[leg], self._points[leg + 1]
        m0, m1 = step * self._slopes[leg], step * self._slopes[leg + 1]
        rise = s * s * (3.0 - 2.0 * s)
        return _vector(p0 + rise * (p1 - p0) + s * (1.0 - s) ** 2 * m0 - s * s * (1.0 - s) * m1)

    def velocity(self, t_s: float) -> Vector3:
        """See Track."""
        if t_s >= self._times[-1]:
            return _vector(self._slopes[-1])
        leg, step, s = self._leg(t_s)
        mean = (self._points[leg + 1] - self._points[leg]) / step
        m0, m1 = self._slopes[leg], self._slopes[leg + 1]
        return _vector(
            6.0 * s * (1.0 - s) * mean + (1.0 - s) * (1.0 - 3.0 * s) * m0 + s * (3.0 * s - 2.0) * m1
        )

    def _leg(self, t_s: float) -> tuple[int, float, float]:
        """Index of the leg at a time, its length in seconds and the part of it that is done."""
        leg = max(bisect.bisect_right(self._times, t_s) - 1, 0)
        step = self._times[leg + 1] - self._times[leg]
        return leg, step, (t_s - self._times[leg]) / step


def _course_axes(course: float) -> Array:
    """Rows: forward, left and up of a course (radians clockwise from North) in ENU."""
    sine, cosine = math.sin(course), math.cos(course)
    return np.array([[sine, cosine, 0.0], [-cosine, sine, 0.0], [0.0, 0.0, 1.0]])


def _slopes(times: Array, points: Array) -> Array:
    """Velocity at every listed position."""
    steps = np.diff(times)[:, np.newaxis]
    legs = np.diff(points, axis=0) / steps
    inner = (steps[1:] * legs[:-1] + steps[:-1] * legs[1:]) / (steps[:-1] + steps[1:])
    slopes: Array = np.concatenate([legs[:1], inner, legs[-1:]])
    return slopes


def _vector(values: Array) -> Vector3:
    east, north, up = values.tolist()
    return (east, north, up)
