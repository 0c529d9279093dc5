# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Whether a multirotor is in the air, from GPS velocity and the shaking of its accelerometer."""

from __future__ import annotations

import math

from hijack_detect.detectors.drag_blocks import FlightBlock

CONFIRM_S = 2.0
"""A change of phase must last this long."""
MEMORY_S = 60.0
"""What shaking is usual is the mean over about this time in the air."""
STANDING_SPEED = 0.7
"""m/s; a GPS reports less when the vehicle stands."""


class FlightPhase:
    """Motion says that it flies; standing and no shaking of motors, that it has landed.

    A hover shakes as motion does, so it goes on flying; a vehicle that was never in motion is on
    the ground.
    """

    def __init__(self, moving_speed: float, still_share: float) -> None:
        """Start on the ground; see the parameters of these names."""
        self._moving_speed, self._still_share = moving_speed, still_share
        self._evidence_s = 0.0
        self._shaking = 0.0
        self.air_s = 0.0
        """Time in the air, 0 on the ground."""

    def update(self, block: FlightBlock) -> bool:
        """Take the next block; return whether the phase has just changed."""
        seconds = block.air.seconds
        flying = self.air_s > 0.0
        if flying:
            standing = block.speed < STANDING_SPEED and abs(block.climb) < STANDING_SPEED
            against = standing and block.shaking < self._still_share * self._shaking
        else:
            speed = max(block.speed, 2.0 * abs(block.climb))
            against = speed > self._moving_speed
        self._evidence_s = self._evidence_s + seconds if against else 0.0
        changed = self._evidence_s >= CONFIRM_S
        if changed:
            self._evidence_s = 0.0
            self.air_s = 0.0 if flying else seconds
            self._shaking = block.shaking
        elif flying:
            self.air_s += seconds
            share = min(1.0, seconds / min(MEMORY_S, self.air_s))
            square = self._shaking**2 + share * (block.shaking**2 - self._shaking**2)
            self._shaking = math.sqrt(square)
        return changed
