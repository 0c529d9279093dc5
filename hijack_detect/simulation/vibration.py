# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Strong vibration as a sampled IMU reads it: what turns faster than half the rate is folded.

Each of the four rotors shakes with an amplitude and a direction of its own, at a speed that
wanders about the common one. A sample is the value at its time, so that a rotor near the sampling
rate is read as a slow swing of metres per second squared: the worst that a detector meets.
"""

from __future__ import annotations

import numpy as np

from hijack_detect.simulation.disturbances import Vibration
from hijack_detect.simulation.noise import Array, gauss_markov

ROTORS = 4
REGULATED_S = 1.0
"""Time constant with which the speed of a rotor wanders, seconds."""
GYRO_PER_FORCE = 0.05
"""rad/s of the gyroscope per m/s² of the accelerometer, as in the usual vibration."""


def shaking(
    vibration: Vibration, count: int, rate_hz: float, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Angular velocity (rad/s) and specific force (m/s²) that the vibration adds, each (count, 3).

    The rms of the force is that of the vibration on each axis, in the mean over frequencies.

    Args:
        vibration: How strong and how fast.
        count: Number of samples.
        rate_hz: Samples a second.
        rng: Draws amplitudes, phases and the wandering of the rotors.
    """
    wander = gauss_markov(rng.normal(size=(count, ROTORS)), REGULATED_S, rate_hz)
    hertz = vibration.rotor_hz + vibration.wander_hz * wander
    turned = 2.0 * np.pi * np.cumsum(hertz, axis=0) / rate_hz
    rate, force = (
        np.sqrt(2.0)
        * np.einsum(
            "nij,ij->nj",
            np.sin(turned[:, :, None] + rng.uniform(-np.pi, np.pi, (ROTORS, 3))),
            _shares(rng),
        )
        for _ in range(2)
    )
    return (GYRO_PER_FORCE * vibration.force_rms) * rate, vibration.force_rms * force


def _shares(rng: np.random.Generator) -> Array:
    """Amplitudes of the rotors on each axis, (ROTORS, 3); the squares of an axis sum to one."""
    drawn = rng.uniform(0.3, 1.0, (ROTORS, 3))
    shares: Array = drawn / np.linalg.norm(drawn, axis=0)
    return shares
