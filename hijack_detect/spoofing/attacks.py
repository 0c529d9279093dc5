# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The ways in which an attack changes samples: offset, track, frozen, replayed.

An attack sees every true sample of its segment in stamp order. What it reports for one stamp
depends on samples of the other kind only if they are strictly older, so the order of a fix and
a velocity with the same stamp does not matter.
"""

from __future__ import annotations

import dataclasses
from typing import Protocol

from hijack_detect.estimation.geodesy import TangentPlane, moved, turned, with_velocity
from hijack_detect.spoofing import schema
from hijack_detect.spoofing.offsets import Offset
from hijack_detect.spoofing.onset import History, Onset, fix_between, velocity_between
from hijack_detect.spoofing.tracks import Track
from hijack_detect.streams.samples import FixSample, SatelliteSample, VelocitySample


class Attack(Protocol):
    """One attack, from its onset on."""

    def fix(self, true: FixSample, t_s: float) -> FixSample:
        """Return the reported fix for a true one `t_s` seconds after onset."""
        ...

    def velocity(
        self, true: VelocitySample, t_s: float, before: FixSample | None
    ) -> VelocitySample:
        """Return the reported velocity for a true one; `before` is the last older true fix."""
        ...

    def satellites(self, true: SatelliteSample, t_s: float) -> SatelliteSample:
        """Return the reported number of satellites; the true one unless an attack forges it."""
        return true


@dataclasses.dataclass(frozen=True)
class Recording:
    """What a replay plays: the earlier fixes and velocities, and how much earlier they are."""

    lag_ns: int
    fixes: History[FixSample]
    velocities: History[VelocitySample]


class OffsetAttack(Attack):
    """Reports the true motion plus an offset; a horizontal offset leaves the altitude alone."""

    def __init__(self, offset: Offset, onset: Onset) -> None:
        """Anchor the plane at the last fix before onset, if there was one."""
        self._offset = offset
        self._anchor = onset.fix

    def fix(self, true: FixSample, t_s: float) -> FixSample:
        """See Attack."""
        if self._anchor is None:
            self._anchor = true
        east, north, up = self._offset.position(t_s, true.stamp_ns)
        place = (true.latitude_deg, true.longitude_deg)
        if east or north:
            x, y, z = TangentPlane(self._anchor).enu(true)
            place = TangentPlane(self._anchor).geodetic((x + east, y + north, z))
        return moved(true, place, true.altitude_m + up)

    def velocity(
        self, true: VelocitySample, t_s: float, before: FixSample | None
    ) -> VelocitySample:
        """See Attack. An offset that does not change leaves the velocity as it is."""
        rate = self._offset.velocity(t_s, true.stamp_ns)
        if rate == (0.0, 0.0, 0.0):
            return true
        own = true.velocity
        if (rate[0] or rate[1]) and before is not None and self._anchor is not None:
            plane = TangentPlane(self._anchor)
            x, y, z = plane.enu(before)
            east, north, _ = self._offset.position(t_s, true.stamp_ns)
            place = plane.geodetic((x + east, y + north, z))
            own = turned(own, (before.latitude_deg, before.longitude_deg), place)
            rate = plane.velocity_at(rate, place)
        return with_velocity(true, (own[0] + rate[0], own[1] + rate[1], own[2] + rate[2]))


class TrackAttack(Attack):
    """Reports a track that starts where the vehicle was at onset."""

    def __init__(self, track: Track, onset: Onset) -> None:
        """Anchor the track at the last fix before onset, carried forward to the onset."""
        self._track = track
        self._anchor = onset.fix
        self._carry = onset.carry

    def fix(self, true: FixSample, t_s: float) -> FixSample:
        """See Attack."""
        if self._anchor is None:
            self._anchor = true
        east, north, up = self._track.position(t_s)
        x, y, z = self._carry
        place = TangentPlane(self._anchor).geodetic((x + east, y + north, 0.0))
        if self._track.keeps_altitude:
            return moved(true, place, true.altitude_m)
        return moved(true, place, self._anchor.altitude_m + z + up)

    def velocity(
        self, true: VelocitySample, t_s: float, before: FixSample | None
    ) -> VelocitySample:
        """See Attack."""
        velocity = self._track.velocity(t_s)
        if before is not None and self._anchor is not None:
            plane = TangentPlane(self._anchor)
            east, north, _ = self._track.position(t_s)
            place = plane.geodetic((self._carry[0] + east, self._carry[1] + north, 0.0))
            velocity = plane.velocity_at(velocity, place)
        up = true.velocity[2] if self._track.keeps_altitude else velocity[2]
        return with_velocity(true, (velocity[0], velocity[1], up))


class FreezeAttack(Attack):
    """Reports the last position, and the last velocity unless the model has another."""

    def __init__(self, model: schema.Freeze, onset: Onset) -> None:
        """Hold the last report; the first true sample without one."""
        self._velocity_mode = model.velocity
        self._fix = onset.fix
        self._velocity = onset.velocity_sample

    def fix(self, true: FixSample, t_s: float) -> FixSample:
        """See Attack."""
        if self._fix is None:
            self._fix = true
        return _at(self._fix, true)

    def velocity(
        self, true: VelocitySample, t_s: float, before: FixSample | None
    ) -> VelocitySample:
        """See Attack."""
        if self._velocity_mode == "true":
            return true
        if self._velocity_mode == "zero":
            return with_velocity(true, (0.0, 0.0, 0.0))
        if self._velocity is None:
            self._velocity = true
        return with_velocity(true, self._velocity.velocity)


class ReplayAttack(Attack):
    """Reports the truth of a fixed time earlier, interpolated between the recorded samples.

    Where nothing was recorded yet the sample passes as it is.
    """

    def __init__(self, recording: Recording) -> None:
        """Play a recording."""
        self._recording = recording

    def fix(self, true: FixSample, t_s: float) -> FixSample:
        """See Attack."""
        found = self._recording.fixes.around(true.stamp_ns - self._recording.lag_ns)
        if found is None:
            return true
        return _at(fix_between(*found), true)

    def velocity(
        self, true: VelocitySample, t_s: float, before: FixSample | None
    ) -> VelocitySample:
        """See Attack."""
        found = self._recording.velocities.around(true.stamp_ns - self._recording.lag_ns)
        if found is None:
            return true
        return with_velocity(true, velocity_between(*found))


def _at(place: FixSample, true: FixSample) -> FixSample:
    """The true fix at another place; its claimed accuracy stays."""
    return moved(true, (place.latitude_deg, place.longitude_deg), place.altitude_m)
