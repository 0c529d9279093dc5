# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The filter of `ekf` with two more states: how far GPS position and velocity lag behind."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.ekf import (
    ATTITUDE,
    GRAVITY,
    UP,
    VELOCITY,
    Ekf,
    ImuBlock,
    Observation,
    ProcessNoise,
    Source,
)
from hijack_detect.estimation.kalman import Innovation
from hijack_detect.estimation.rotation import Array
from hijack_detect.streams.samples import Quaternion

LATE_S = 0.33
"""A lag beyond this is named: recorded receivers have 0.02 to 0.28 s, and no flight without a late
GPS reaches it."""
GROWTH = 0.15
"""s/s. A latency grows no faster in flight: a link that fills up, 1.5 s within 10 s."""
MOST_GROWTH_S = 1.5
"""It grows by no more: what a link holds back without a loss that is seen as one."""
LATE = "the GPS is late"
LATE_GPS = "late_gps"
"""Value: the lag, s, where it is beyond LATE_S."""
LATE_FIGURES = frozenset({LATE_GPS})


def late(*lags_s: float) -> dict[str, float]:
    """The largest of some lags as a value of a verdict; empty unless it is beyond LATE_S."""
    lag_s = max(lags_s)
    return {LATE_GPS: lag_s} if lag_s > LATE_S else {}


def late_words(values: Mapping[str, float]) -> str:
    """A lag beyond its limit in words, empty without one.

    It is the least that the GPS lags by.
    """
    return f"lags by {values[LATE_GPS]:.2f} s or more" if LATE_GPS in values else ""


LAG, DIFFERENCE = 15, 16
"""Lag of the receiver's velocity, and how much longer that of its position is."""
LAGS = slice(15, 17)
SIZE = 17
LAG_BAND_S = 0.1
"""Lags within this of the nominal one are a state only, beyond it the filter runs later: p − τv is
linear in τ, and of 13 recorded receivers none is further off than 0.13 s."""
LAG_SHOWN_BY = 0.5
"""m/s²: horizontal acceleration from which on a lag shows, and the filter may run later for it. In
a hover of three minutes, or on a straight where positions wander, the state drifts; a filter that
had followed it by running later alarmed in the next turn (synthetic flights)."""
MOST_LAG_SIGMA_S = 0.2
"""The walk of the lag ends where its standard deviation is this: receivers in order do not walk,
and a lag that may be anything takes up what an attack pulls."""
STEPS = 512
"""Newest steps that are kept; far more than lie between two samples."""


@dataclass(frozen=True)
class ModelErrors:
    """What a filter with constant noise would be too sure of.

    Attributes:
        lag_sigma_s: Lags differ between receivers by this, and that of position from that of
            velocity, standard deviation, s.
        lag_walk: Random walk of the lag up to MOST_LAG_SIGMA_S, s/√s.
        lag_difference_walk: The same for the difference of the two.
        lag_jitter_s: Velocity noise grows with acceleration times this, s.
        position_jitter_s: Position noise grows with speed times this, s.
        force_scale: Accelerometer noise density grows with acceleration times this, 1/√Hz.
        rate_scale: Gyroscope noise density grows with angular velocity times this, 1/√Hz.
        max_lag_s: Bound of either state, s.
        max_force: Specific force beyond which the IMU is not believed, m/s².
        max_rate: The same for the angular velocity, rad/s.
    """

    lag_sigma_s: float
    lag_walk: float
    lag_difference_walk: float
    lag_jitter_s: float
    position_jitter_s: float
    force_scale: float
    rate_scale: float
    max_lag_s: float
    max_force: float
    max_rate: float


@dataclass(frozen=True, slots=True)
class Propagated:
    """The filter moved on: seconds, and Φ of shape (n, n)."""

    dt_s: float
    transition: Array


@dataclass(frozen=True, slots=True)
class Measured:
    """The filter used an observation.

    Attributes:
        source: See Observation.
        horizontal: See Observation.
        innovation: The filter's innovation, shapes as in `kalman`.
    """

    source: Source
    horizontal: bool
    innovation: Innovation


class LagEkf(Ekf):
    """15 states, the lags of position and velocity about the nominal one, and a record of steps.

    Both lags differ from vehicle to vehicle. As states they are learnt within the first
    manoeuvres, and until then their uncertainty widens the innovations of manoeuvres. The one
    of the velocity may grow in flight, and that of position goes with it. What is beyond
    LAG_BAND_S is for the nominal lag.
    """

    def __init__(
        self,
        attitude: Quaternion,
        sigmas: Array,
        noise: ProcessNoise,
        errors: ModelErrors,
        behind: Sequence[float] = (),
    ) -> None:
        """See Ekf.

        Args:
            attitude: See Ekf.
            sigmas: Of the 15 states.
            noise: See Ekf.
            errors: Those of the model.
            behind: Standard deviations of the states that a subclass adds behind the lags.
        """
        lags = np.full(2, errors.lag_sigma_s)
        super().__init__(attitude, np.concatenate([sigmas, lags, behind]), noise)
        self._errors = errors
        self.lags: Array = np.zeros(2)
        """Lag of the velocity beyond the nominal one, and that of position beyond it, s."""
        self.acceleration: Array = np.zeros(3)
        """Mean over the last block, ENU, m/s²."""
        self.steps: deque[Propagated | Measured] = deque(maxlen=STEPS)
        """Steps since this was emptied; unread, it keeps the newest."""

    @property
    def beyond_band(self) -> float:
        """See Ekf: the mean of both lags beyond LAG_BAND_S, in motion that shows it."""
        lag = float(self.lags[0] + 0.5 * self.lags[1])
        if math.hypot(*self.acceleration[:2].tolist()) < LAG_SHOWN_BY:
            return 0.0
        return lag - min(max(lag, -LAG_BAND_S), LAG_BAND_S)

    def rebase(self, shift_s: float) -> None:
        """See Ekf."""
        self.lags = self.lags - [shift_s, 0.0]

    @property
    def least_lags(self) -> tuple[float, float]:
        """Lags of position and velocity beyond the nominal one, less 3 standard deviations, s."""
        lag, difference = self.lags.tolist()
        block = self.covariance[LAGS, LAGS]
        position = lag + difference - 3.0 * math.sqrt(max(0.0, block.sum()))
        return position, lag - 3.0 * math.sqrt(block[0, 0])

    def propagate(self, block: ImuBlock) -> None:
        """See Ekf."""
        if not block.seconds:
            return
        before = self.velocity
        super().propagate(block)
        self.acceleration = (self.velocity - before) / block.seconds
        self.steps.append(Propagated(block.seconds, self.transition))

    def process_noise(self, block: ImuBlock, force: Array) -> Array:
        """See Ekf; with errors of scale."""
        noise = super().process_noise(block, force)
        e, seconds = self._errors, block.seconds
        accel = math.hypot(*(force - UP * GRAVITY).tolist())
        rate = math.hypot(*block.angular_velocity.mean(axis=0).tolist())
        noise[VELOCITY] += (e.force_scale * accel) ** 2 * seconds
        noise[ATTITUDE] += (e.rate_scale * rate) ** 2 * seconds
        walks = self.covariance[LAG, LAG] < MOST_LAG_SIGMA_S**2
        noise[LAGS] = np.square([walks * e.lag_walk, e.lag_difference_walk]) * seconds
        wild = (np.linalg.norm(block.specific_force, axis=1) > e.max_force) | (
            np.linalg.norm(block.angular_velocity, axis=1) > e.max_rate
        )
        if wild.any():
            self.add_unseen(noise, float(block.dt[wild].sum()))
        return noise

    def gps(self, source: Source, measured: Array, variances: Array) -> Observation:
        """See Ekf. A measurement that lags by τ shows p − τv or v − τa."""
        prompt = super().gps(source, measured, variances)
        H = prompt.H
        if source is Source.POSITION:
            rate = self.velocity
            more = self._errors.position_jitter_s * math.hypot(*rate[:2].tolist())
            H[:, DIFFERENCE] = -rate
            lag = self.lags.sum()
        else:
            rate = self.acceleration
            more = self._errors.lag_jitter_s * math.hypot(*rate.tolist())
            lag = self.lags[0]
        H[:, LAG] = -rate
        return Observation(source, H, prompt.residual + lag * rate, prompt.R + more**2)

    def update(self, seen: Observation) -> Innovation:
        """See Ekf; the step is recorded."""
        found = super().update(seen)
        self.steps.append(Measured(seen.source, seen.horizontal, found))
        return found

    def _inject(self, error: Array) -> None:
        super()._inject(error)
        bound = self._errors.max_lag_s
        self.lags = np.minimum(np.maximum(self.lags + error[LAGS], -bound), bound)
