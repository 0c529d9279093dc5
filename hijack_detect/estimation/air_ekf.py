# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The filter of `lag_ekf` that also feels the air: wind, drag and tilt of the rotors are states.

The drag of a multirotor says how fast it moves through the air. As long as the wind stays, that
is a velocity which no GPS has touched: weak from one fix to the next, and it keeps tilt and
accelerometer bias from taking up what a spoofed GPS pulls. The coloured error of GPS velocities is
a state, too: it does not tilt the vehicle.
"""

from __future__ import annotations

import math

import numpy as np

from hijack_detect.estimation.drag_model import SMALLEST_DRAG, drag_force
from hijack_detect.estimation.drag_noise import DragNoise, ForceNoise
from hijack_detect.estimation.ekf import (
    ACCEL_BIAS,
    ATTITUDE,
    POSITION,
    VELOCITY,
    ImuBlock,
    Observation,
    ProcessNoise,
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
"""Force is averaged over at least so long, and not used when it was longer: nobody knows how the
vehicle moved."""
JUMPED = 14.0
"""χ² of two axes, 3.7 standard deviations: one fix in a thousand of Gaussian noise is beyond."""
MAX_HEADING_SIGMA = math.radians(20.0)
"""Until the heading is known as well as this, a wind has no direction."""


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
        self.drag: Array = np.array([air.drag[0], air.quadratic[0]])
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

    def gps(self, block: slice, measured: Array, variances: Array) -> Observation:
        """See LagEkf."""
        rows, residual, noise = super().gps(block, measured, variances)
        if block is not VELOCITY:
            return rows, residual, noise
        rows[:, VELOCITY_ERROR] = np.eye(3)
        error = self.velocity_error
        return rows, residual - error.value, noise * error.scale**2

    def _anchor(self, rows: Array, residual: Array, noise: Array) -> None:
        """Where a fix jumps beside a velocity that does not, take the position for unknown.

        Reflections move fixes by some metres, and back. Taken for motion that tilts the filter; a
        large jump is for other checks, and a pull shows in the velocity as well.
        """
        if self._seconds > LONGEST_S or self.heading_variance > MAX_HEADING_SIGMA**2:
            return
        spread = rows @ self.covariance @ rows.T
        add_diagonal(spread, slice(0, 2), noise)
        if residual @ np.linalg.solve(spread, residual) > JUMPED:
            add_diagonal(self.covariance, slice(0, 2), float(residual @ residual))

    def update(self, h: Array, residual: Array, r: Array) -> Innovation:
        """See Ekf; after each GPS velocity the drag since the last one is used, too."""
        velocity = self._block is VELOCITY
        if self._block is POSITION:
            self._anchor(h[:2], residual[:2], r[:2])
        found = super().update(h, residual, r)
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
        h = np.zeros((2, len(self.covariance)))
        h[:, VELOCITY] = turn
        h[:, ATTITUDE] = turn @ skew(through[None])[0]
        h[:, ACCEL_BIAS.start : ACCEL_BIAS.start + 2] = np.eye(2)
        h[:, WIND] = -turn[:, :2]
        h[:, DRAG] = by_drag[0]
        h[:, TILT] = np.eye(2)
        innovation = force - expected[0] - self.tilt - self.accel_bias[:2]
        spread = h @ self.covariance @ h.T
        super().update(h, innovation, np.full(2, self._force.variance(spread, innovation, seconds)))

    def _inject(self, error: Array) -> None:
        super()._inject(error)
        self.wind = self.wind + error[WIND]
        smallest = (SMALLEST_DRAG, 0.0)
        self.drag = np.maximum(self.drag + error[DRAG], smallest)
        self.tilt = self.tilt + error[TILT]
        self.velocity_error.value = self.velocity_error.value + error[VELOCITY_ERROR]
