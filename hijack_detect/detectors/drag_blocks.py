# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attitude and GPS velocity to blocks of specific force against motion over ground."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hijack_detect.detectors.attitude_window import AttitudeWindow
from hijack_detect.estimation.drag_filter import AirBlock
from hijack_detect.estimation.rotation import Array, matrices
from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample

CONFIRM_S = 2.0
"""A change of phase must last this long. Chosen, not swept."""
MEMORY_S = 60.0
"""What shaking is usual is the mean over about this time in the air. Chosen, not swept."""
STANDING_SPEED = 0.7
"""m/s; a GPS reports less when the vehicle stands. Chosen, not swept."""


class FlightPhase:
    """Motion means flight; standing without the shaking of motors means landed.

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


LOADS = (4.0, 20.0)
"""m/s²; outside, the vehicle falls or tumbles. Chosen, not swept."""
JITTER_S = 0.05
"""A block is full when it is short of its length by no more than this. Chosen, not swept."""


@dataclass(frozen=True, slots=True)
class FlightBlock:
    """One block, and the measures of the phase of flight.

    Attributes:
        air: What the filter uses.
        speed: Over ground, m/s.
        climb: m/s.
        load: Length of the mean specific force, m/s².
        shaking: Standard deviation of the horizontal specific force between two GPS velocities,
            m/s².
        heading_variance: Largest, rad².
    """

    air: AirBlock
    speed: float
    climb: float
    load: float
    shaking: float
    heading_variance: float

    @property
    def tumbles(self) -> bool:
        """Whether the vehicle falls or tumbles by its load."""
        return not LOADS[0] < self.load < LOADS[1]


class BlockBuilder:
    """Joins the intervals between successive GPS velocities to blocks.

    An attitude belongs to the interval in which it was measured, so GPS velocities are moved back
    by their lag. An interval without orientation, or too long, begins a new block.
    """

    def __init__(self, block_s: float, max_gap_s: float, lag_s: float) -> None:
        """Start empty.

        Args:
            block_s: Length of a block.
            max_gap_s: Longest interval.
            lag_s: Largest lag of a GPS velocity; older attitudes are forgotten.
        """
        self._block_s, self._max_gap_ns = block_s - JITTER_S, round(max_gap_s * NANOSECONDS)
        self._attitudes = AttitudeWindow(2 * max_gap_s + lag_s)
        self._last: tuple[int, Array] | None = None
        self._parts: list[tuple[float, Array]] = []
        self._worst = 0.0

    def attitude(self, sample: AttitudeSample) -> None:
        """Take an attitude."""
        self._attitudes.add(sample)

    def velocity(self, stamp_ns: int, valid_ns: int, velocity: Array) -> FlightBlock | None:
        """Take a GPS velocity; return a block that became full.

        Args:
            stamp_ns: Stamp of its message.
            valid_ns: When it was true.
            velocity: ENU, m/s.
        """
        last, self._last = self._last, (valid_ns, velocity)
        if last is None or not 0 < valid_ns - last[0] <= self._max_gap_ns:
            self._clear()
            return None
        samples = self._attitudes.take(last[0], valid_ns)
        if not samples or any(sample.orientation is None for sample in samples):
            self._clear()
            return None
        seconds = (valid_ns - last[0]) / NANOSECONDS
        force = np.array([sample.specific_force for sample in samples])
        turn = matrices(np.array([sample.orientation for sample in samples])).mean(axis=0).T
        mean_velocity = 0.5 * (velocity + last[1])
        shaking = float(np.sum(np.var(force[:, :2], axis=0)))
        part = np.concatenate(
            [turn[:2, :2].ravel(), turn[:2] @ mean_velocity, force.mean(axis=0), mean_velocity]
        )
        self._parts.append((seconds, np.append(part, shaking)))
        self._worst = max(self._worst, *(sample.heading_variance for sample in samples))
        total = math.fsum(length for length, _ in self._parts)
        return self._finish(stamp_ns, total) if total >= self._block_s else None

    def _finish(self, stamp_ns: int, seconds: float) -> FlightBlock:
        mean = sum((length / seconds * part for length, part in self._parts), np.zeros(13))
        worst = self._worst
        self._clear()
        east, north, climb = mean[9:12].tolist()
        return FlightBlock(
            AirBlock(stamp_ns, seconds, mean[:4].reshape(2, 2), mean[4:6], mean[6:8]),
            math.hypot(east, north),
            climb,
            float(np.linalg.norm(mean[6:9])),
            math.sqrt(float(mean[12])),
            worst,
        )

    def _clear(self) -> None:
        self._parts, self._worst = [], 0.0
