# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The attack simulator of Basan et al. 2022, section 3.1: values generated with every update."""

from __future__ import annotations

import dataclasses

from hijack_detect.spoofing import schema
from hijack_detect.spoofing.attacks import OffsetAttack
from hijack_detect.spoofing.draws import Draws
from hijack_detect.spoofing.offsets import DriftOffset
from hijack_detect.spoofing.onset import Onset
from hijack_detect.spoofing.schema import Forge
from hijack_detect.streams.samples import FixSample, SatelliteSample, Vector3

VERTICAL_RATIO = 1.5
"""Claimed vertical over horizontal deviation, without a claim of the receiver. Physics: no
satellite is below the horizon; chosen."""
_POSITION, _VELOCITY, _SATELLITES, _ACCURACY = 2, 3, 4, 5
"""Streams of draws; 0 and 1 are those of jitter, so that equal seeds do not mean equal noise."""


class ForgeOffset:
    """Noise of position and velocity, and a displacement that grows along one bearing.

    The reported velocity is consistent with the displacement; its noise is independent of that of
    the position.
    """

    def __init__(self, model: Forge, course: float) -> None:
        """Fix the direction; `course` is in radians from North."""
        drift = schema.Drift(
            type="drift",
            speed_m_s=model.drift_speed_m_s,
            bearing_deg=model.bearing_deg,
            onset_acceleration_m_s2=model.onset_acceleration_m_s2,
            relative=model.relative,
        )
        self._model = model
        self._drift = DriftOffset(drift, course)
        self._position = Draws(
            model.seed, _POSITION, model.correlation_s, lambda draws: draws.standard_normal(3)
        )
        self._velocity = Draws(
            model.seed, _VELOCITY, model.correlation_s, lambda draws: draws.standard_normal(2)
        )

    def position(self, t_s: float, stamp_ns: int) -> Vector3:
        """See Offset."""
        x, y, _ = self._drift.position(t_s, stamp_ns)
        east, north, up = self._position.at(t_s, stamp_ns)
        sigma = self._model.horizontal_sigma_m
        return (x + sigma * east, y + sigma * north, self._model.altitude_sigma_m * up)

    def velocity(self, t_s: float, stamp_ns: int) -> Vector3:
        """See Offset."""
        u, v, _ = self._drift.velocity(t_s, stamp_ns)
        sigma = self._model.velocity_sigma_m_s
        if not sigma:
            return (u, v, 0.0)
        east, north = self._velocity.at(t_s, stamp_ns)
        return (u + sigma * east, v + sigma * north, 0.0)


class ForgeAttack(OffsetAttack):
    """Forges position, velocity, number of satellites and claimed accuracy."""

    def __init__(self, model: Forge, onset: Onset) -> None:
        """Start the displacement at the vehicle's state at onset."""
        super().__init__(ForgeOffset(model, onset.course), onset)
        self._satellites = self._accuracy = None
        if model.satellites is not None:
            fewest, most = model.satellites
            self._satellites = Draws(
                model.seed,
                _SATELLITES,
                model.correlation_s,
                lambda draws: draws.integers(fewest, most, size=1, endpoint=True).astype(float),
            )
        if model.accuracy_m is not None:
            best, worst = model.accuracy_m
            self._accuracy = Draws(
                model.seed,
                _ACCURACY,
                model.correlation_s,
                lambda draws: draws.uniform(best, worst, size=1),
            )

    def fix(self, true: FixSample, t_s: float) -> FixSample:
        """See Attack."""
        reported = super().fix(true, t_s)
        if self._accuracy is None:
            return reported
        (accuracy,) = self._accuracy.at(t_s, true.stamp_ns)
        ratio = VERTICAL_RATIO
        if true.accuracy_m is not None and true.vertical_accuracy_m is not None:
            ratio = true.vertical_accuracy_m / true.accuracy_m
        return dataclasses.replace(
            reported, accuracy_m=accuracy, vertical_accuracy_m=ratio * accuracy
        )

    def satellites(self, true: SatelliteSample, t_s: float) -> SatelliteSample:
        """See Attack."""
        if self._satellites is None:
            return true
        (count,) = self._satellites.at(t_s, true.stamp_ns)
        return dataclasses.replace(true, count=round(count))
