# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The error of GPS velocities: coloured, and as large as this receiver shows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hijack_detect.estimation.kalman import Innovation
from hijack_detect.estimation.learning import NoiseScale
from hijack_detect.estimation.rotation import Array
from hijack_detect.streams.samples import NANOSECONDS

CLIP = 3.5
"""One innovation counts as this many times the usual one at most. Chosen, not swept."""
PRIOR_S = 5.0
"""The nominal noise weighs as much as this time of innovations. Chosen, not swept."""


@dataclass(frozen=True)
class VelocityNoise:
    """Model of the error of a GPS velocity beyond its white noise.

    On 13 recorded flights a velocity was wrong by 0.1 to 0.5 m/s for 0.5 to 2 s. A filter that
    takes this for white noise believes it after a few fixes, and tilts the vehicle. `sigma` and
    `time_s` are within those; the others are chosen, not swept.

    Attributes:
        sigma: Standard deviation of each axis, m/s.
        time_s: Time constant of its correlation (Gauss-Markov), s.
        worst: A receiver may be this many times as noisy as it should be.
        memory_s: The noise is learnt from about this time of innovations, s.
        delay_s: Which are older than this, so that no fix excuses itself, s.
    """

    sigma: float = 0.3
    time_s: float = 1.0
    worst: float = 5.0
    memory_s: float = 10.0
    delay_s: float = 3.0


class VelocityError:
    """Gauss-Markov error (East, North, Up) as a state, with a noise that is learnt in flight.

    The innovations of a receiver whose velocity jumps are larger than the filter expects. All
    its noise, white and coloured, is then taken as this many times larger; never smaller than
    nominal, and `VelocityNoise.worst` at most. A pull of 1 m/s² hardly shows in single
    innovations, so it cannot buy itself much of this.
    """

    def __init__(self, noise: VelocityNoise) -> None:
        """Start without an error, at the nominal noise."""
        self._noise = noise
        self._scale = NoiseScale(
            1.0,
            noise.worst,
            delay_s=noise.delay_s,
            memory_s=noise.memory_s,
            prior_s=PRIOR_S,
            clip=CLIP,
        )
        self._time_s = 0.0
        self.value: Array = np.zeros(3)
        """The estimate, m/s."""

    @property
    def sigmas(self) -> tuple[float, float, float]:
        """Standard deviations before anything is known, m/s."""
        return (self._noise.sigma,) * 3

    @property
    def scale(self) -> float:
        """Noise of the receiver as a multiple of the nominal one."""
        return self._scale.value

    def kept(self, seconds: float) -> float:
        """Share of the error that is left after some time: its Φ."""
        return math.exp(-seconds / self._noise.time_s)

    def propagate(self, seconds: float) -> None:
        """Time passes."""
        self.value = self.value * self.kept(seconds)
        self._time_s += seconds

    def walked(self, seconds: float) -> float:
        """Variance that a time adds: its Q, (m/s)²."""
        return (self.scale * self._noise.sigma) ** 2 * (1.0 - self.kept(seconds) ** 2)

    def learn(self, found: Innovation) -> None:
        """Take the innovation of a GPS velocity."""
        whitened = found.distance / len(found.residual)
        self._scale.add(round(self._time_s * NANOSECONDS), whitened * self.scale**2)
