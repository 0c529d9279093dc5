# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The route `brake`: to full speed and to a stop, as hard as the vehicle can."""

from __future__ import annotations

import numpy as np

Knots = tuple[list[float], list[float]]
"""Times in seconds and the values at these times, linear in between."""

ACCELERATION = 4.0
"""m/s² to reach the speed."""
BRAKING = 6.0
"""m/s² to a stop: what a tilt of 31° gives."""


def braking(start_s: float, end_s: float, cruise: float, rng: np.random.Generator) -> Knots:
    """Speed of the route over time.

    Args:
        start_s: Command to fly forward, seconds from the start of the recording.
        end_s: When the last stop begins at the latest.
        cruise: Speed to reach, m/s.
        rng: Draws how long it flies and how long it stands.
    """
    times, speeds, now = [start_s], [0.0], start_s
    while True:
        fast = now + cruise / ACCELERATION
        brake = fast + rng.uniform(3.0, 6.0)
        stop = brake + cruise / BRAKING
        if brake > end_s:
            return times, speeds
        now = stop + rng.uniform(2.0, 5.0)
        times += [fast, brake, stop, now]
        speeds += [cruise, cruise, 0.0, 0.0]
