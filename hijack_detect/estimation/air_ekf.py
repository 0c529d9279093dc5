# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The filter of `lag_ekf` that also feels the air: wind, drag and tilt of the rotors are states.

The drag of a multirotor shows how fast it moves through the air. As long as the wind stays, that
is a velocity which no GPS has touched: weak from one fix to the next, and it keeps tilt and
accelerometer bias from taking up what a spoofed GPS pulls. The coloured error of GPS velocities is
a state, too: it does not tilt the vehicle.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from hijack_detect.estimation.drag_filter import SMALLEST_DRAG, DragNoise, ForceNoise, drag_force
from hijack_detect.estimation.ekf import (
    ACCEL_BIAS,
    ATTITUDE,
    VELOCITY,
    ImuBlock,
    Observation,
    ProcessNoise,
    Source,
)
from hijack_detect.estimation.kalman import Innovation, add_diagonal
from hijack_detect.estimation.lag_ekf import LagEkf, ModelErrors
from hijack_detect.estimation.rotation import Array, matrix, skew
from hijack_detect.estimation.velocity_error import VelocityError, VelocityNoise
from hijack_detect.streams.samples import Quaternion

WIND, DRAG, TILT = slice(17, 19), slice(19, 21), slice(21, 23)
"""Wind (East, North, m/s); k (1/s) and q (1/m); force along x and y from tilted rotors (m/s²)."""
VELOCITY_ERROR = slice(23, 26)
"""Error of the GPS velocity (East, North, Up, m/s), see `velocity_error`."""
SIZE = 26
SHORTEST_S, LONGEST_S = 0.15, 1.1
"""Force is averaged over at least this long, and not used when it was longer: the
motion in between is unknown."""
JUMPED = 14.0
"""χ² of two axes, 3.7 standard deviations: one fix in a thousand of Gaussian noise is beyond."""
MAX_HEADING_SIGMA = math.radians(20.0)
"""Until the heading is known as well as this, a wind has no direction. Chosen, not swept."""


class AirEkf(LagEkf):
    """15 states, two lags, wind (2), drag (2), force of tilted rotors (2), velocity error (3)."""

    def __init__(
        self,
        attitude: Quaternion,
        sigmas: Array,
        noise: ProcessNoise,
        errors: ModelErrors,
        air: DragNoise,
        receiver: VelocityNoise,
    ) -> None:
        """See LagEkf; `air` is what is assumed of wind and drag, `receiver` of GPS velocities."""
        self.velocity_error = VelocityError(receiver)
        behind = (*air.sigmas, *self.velocity_error.sigmas)
        super().__init__(attitude, sigmas, noise, errors, behind)
        self._walk = np.square(air.walks)
        self._force = ForceNoise(air)
        self.wind: Array = np.zeros(2)
        self.drag: Array = np.array([air.drag[0], 0.0])
        self.tilt: Array = np.zeros(2)
        self._impulse: Array = np.zeros(2)
        self._seconds = 0.0
        """Time since a GPS velocity, over which `_impulse` is summed."""

    @property
    def residual(self) -> float:
        """Root mean square of the force about the model, see ForceNoise, m/s²."""
        return self._force.residual

    def propagate(self, block: ImuBlock) -> None:
        """See Ekf."""
        super().propagate(block)
        self.velocity_error.propagate(block.seconds)
        self._impulse = self._impulse + block.dt @ block.specific_force[:, :2]
        self._seconds += block.seconds

    def process_noise(self, block: ImuBlock, force: Array) -> Array:
        """See LagEkf."""
        noise = super().process_noise(block, force)
        noise[WIND.start : TILT.stop] = self._walk * block.seconds
        noise[VELOCITY_ERROR] = self.velocity_error.walked(block.seconds)
        return noise

    def transition_over(self, dt: Array, rotation: Array, force: Array) -> Array:
        """See Ekf."""
        phi = super().transition_over(dt, rotation, force)
        phi[VELOCITY_ERROR, VELOCITY_ERROR] *= self.velocity_error.kept(float(dt.sum()))
        return phi

    def gps(self, source: Source, measured: Array, variances: Array) -> Observation:
        """See LagEkf."""
        white = super().gps(source, measured, variances)
        if source is not Source.VELOCITY:
            return white
        white.H[:, VELOCITY_ERROR] = np.eye(3)
        error = self.velocity_error
        return replace(white, residual=white.residual - error.value, R=white.R * error.scale**2)

    def _anchor(self, fix: Observation) -> None:
        """Where a fix jumps beside a velocity that does not, take the position for unknown.

        Reflections move fixes by some metres, and back. Taken for motion that tilts the filter; a
        large jump is for other checks, and a pull shows in the velocity as well.
        """
        if self._seconds > LONGEST_S or self.heading_variance > MAX_HEADING_SIGMA**2:
            return
        H, residual = fix.H[:2], fix.residual[:2]
        S = H @ self.covariance @ H.T
        add_diagonal(S, slice(0, 2), fix.R[:2])
        if residual @ np.linalg.solve(S, residual) > JUMPED:
            add_diagonal(self.covariance, slice(0, 2), float(residual @ residual))

    def update(self, seen: Observation) -> Innovation:
        """See Ekf; after each GPS velocity the drag since the last one is used, too."""
        velocity = seen.source is Source.VELOCITY
        if seen.source is Source.POSITION and seen.horizontal:
            self._anchor(seen)
        found = super().update(seen)
        if velocity:
            self.velocity_error.learn(found)
        if velocity and self._seconds > SHORTEST_S:
            if self._seconds < LONGEST_S and self.heading_variance < MAX_HEADING_SIGMA**2:
                self._feel(self._impulse / self._seconds, self._seconds)
            self._impulse, self._seconds = np.zeros(2), 0.0
        return found

    def _feel(self, force: Array, seconds: float) -> None:
        """Use the mean specific force of the last interval, body x and y, m/s²."""
        body = matrix(self.attitude).T
        through = self.velocity - np.append(self.wind, 0.0)
        drag, quadratic = self.drag.tolist()
        expected, by_air, by_drag = drag_force((body @ through)[None, :2], drag, quadratic)
        turn = by_air[0] @ body[:2]
        H = np.zeros((2, len(self.covariance)))
        H[:, VELOCITY] = turn
        H[:, ATTITUDE] = turn @ skew(through[None])[0]
        H[:, ACCEL_BIAS.start : ACCEL_BIAS.start + 2] = np.eye(2)
        H[:, WIND] = -turn[:, :2]
        H[:, DRAG] = by_drag[0]
        H[:, TILT] = np.eye(2)
        innovation = force - expected[0] - self.tilt - self.accel_bias[:2]
        spread = H @ self.covariance @ H.T
        variance = self._force.variance(spread, innovation, seconds)
        super().update(Observation(Source.DRAG, H, innovation, np.full(2, variance)))

    def _inject(self, error: Array) -> None:
        super()._inject(error)
        self.wind = self.wind + error[WIND]
        smallest = (SMALLEST_DRAG, 0.0)
        self.drag = np.maximum(self.drag + error[DRAG], smallest)
        self.tilt = self.tilt + error[TILT]
        self.velocity_error.value = self.velocity_error.value + error[VELOCITY_ERROR]
