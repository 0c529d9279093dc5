# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Sensor properties estimated from a flight: the GPS's lag, and the IMU's noise.

Both are figures of one vehicle that the package needs and no data sheet gives. They come from
the estimators' outputs over a clean flight, see `recorded`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hijack_detect.detectors.date import DateDetector, DateParameters
from hijack_detect.evaluation.trials.recorded import Recorded, judge
from hijack_detect.streams.samples import NANOSECONDS, VelocitySample

LAG_STEP_S = 0.05
LAGS_S = tuple(round(LAG_STEP_S * step, 2) for step in range(11))
"""0 to 0.5 s: recorded receivers have 0.02 to 0.28 s (docs/detectors.md)."""
WINDOW_FIXES = 4.5
"""Window of the comparison in intervals between fixes: short, so that a lag is not averaged out,
and half an interval off a whole number, so that jitter never changes how many it holds. Chosen, not
swept."""
MIN_CONTRAST = 1.05
"""The worst lag must disagree by this factor more than the best: a flight that hardly
accelerates does not show its lag. Chosen, not swept."""
MIN_SPEED = 1.0
"""m/s; faster than this it flies, and its motors shake the IMU. Chosen, not swept."""
BLOCK_S = 1.0
MIN_BLOCKS = 10
"""Blocks for a median. Chosen, not swept."""


@dataclass(frozen=True)
class Lag:
    """Estimate of how long before its stamp a GPS velocity was true.

    Attributes:
        seconds: The lag.
        disagreement: RMS of GPS acceleration against accelerometer at this lag, m/s².
        contrast: That at the worst lag over that at the best.
    """

    seconds: float
    disagreement: float
    contrast: float


@dataclass(frozen=True)
class ImuNoise:
    """White noise densities that would look the same between neighbouring samples.

    Attributes:
        accel: Accelerometer, m/s²/√Hz.
        gyro: Gyroscope, rad/s/√Hz.
    """

    accel: float
    gyro: float


def gps_lag(recorded: Recorded) -> Lag | None:
    """The lag at which GPS velocities fit the accelerometer best.

    The DATE comparison (Feng et al. 2018, §3.4) with a short window is run at every lag of a
    grid; a parabola through the three best mean squares gives the lag between them. None where
    the flight does not show it: no GPS velocity, too little acceleration, or no minimum inside.
    """
    stamps = [s.stamp_ns for _, s in recorded.samples if isinstance(s, VelocitySample)]
    if len(stamps) < 2:
        return None
    interval_s = float(np.median(np.diff(stamps))) / NANOSECONDS
    window_s = min(max(WINDOW_FIXES * interval_s, 0.2), 60.0)
    window = DateParameters(noise_gain=0.0, max_lag_s=0.0, window_s=window_s)
    squares = [_mean_square(recorded, window, lag) for lag in LAGS_S]
    if not all(squares):
        return None
    best = int(np.argmin(squares))
    contrast = math.sqrt(max(squares) / squares[best])
    if best in (0, len(LAGS_S) - 1) or contrast < MIN_CONTRAST:
        return None
    before, least, after = squares[best - 1 : best + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * least + after)
    return Lag(LAGS_S[best] + shift * LAG_STEP_S, math.sqrt(least), contrast)


def _mean_square(recorded: Recorded, window: DateParameters, lag_s: float) -> float:
    """Mean square of Δa over the flight at a lag, m²/s⁴; 0 if it was never evaluated."""
    parameters = dataclasses.replace(window, gps_lag_s=lag_s)
    scores = [v.score for v in judge(recorded, lambda: DateDetector(parameters)) if v.values]
    return float(np.mean(np.square(scores))) if scores else 0.0


def imu_noise(recorded: Recorded) -> ImuNoise | None:
    """Noise in forward flight, vibration included, from second differences of the readings.

    A second difference of white noise has six times its variance and hardly any of the
    vehicle's motion. The variance of each second is taken over all axes; the median over the
    flight leaves shocks and gaps out. It is the noise near half the sampling rate: vibration
    there counts in full, slow errors (bias, tilt, lag) not at all. None if it never flew.
    """
    attitudes = recorded.attitudes
    if len(attitudes) < 3:
        return None
    stamps = np.array([sample.stamp_ns for sample in attitudes])
    readings = np.array([(*s.specific_force, *s.angular_velocity) for s in attitudes])
    step_s = float(np.median(np.diff(stamps))) / NANOSECONDS
    size = max(1, round(BLOCK_S / step_s))
    moving = _moving(recorded, stamps[1:-1])
    squares = np.square(np.diff(readings, n=2, axis=0))
    blocks = [
        squares[i : i + size].reshape(-1, 2, 3).mean(axis=(0, 2))
        for i in range(0, len(squares) - size + 1, size)
        if moving[i : i + size].all()
    ]
    if len(blocks) < MIN_BLOCKS:
        return None
    accel, gyro = np.sqrt(np.median(blocks, axis=0) / 6.0 * step_s).tolist()
    return ImuNoise(accel, gyro)


def _moving(recorded: Recorded, stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Whether the GPS moves at each stamp."""
    velocities = [s for _, s in recorded.samples if isinstance(s, VelocitySample)]
    if not velocities:
        return np.zeros(len(stamps), dtype=bool)
    at = [sample.stamp_ns for sample in velocities]
    speeds = np.array([math.hypot(*sample.velocity[:2]) for sample in velocities])
    moving: npt.NDArray[np.bool_] = (
        speeds[np.maximum(np.searchsorted(at, stamps) - 1, 0)] > MIN_SPEED
    )
    return moving


def middle_half(values: Sequence[float]) -> tuple[float, float, float]:
    """Median, and the range that holds the middle half: what one odd flight does not move."""
    low, middle, high = np.percentile(values, [25.0, 50.0, 75.0]).tolist()
    return middle, low, high
