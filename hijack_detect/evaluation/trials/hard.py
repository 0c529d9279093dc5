# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Clean flights that are hard: gusts, braking, spins, a bent field, a GPS that fails honestly.

There is no attack in any, so every alarm is a false one. Each kind is a class of its own.
"""

from __future__ import annotations

from hijack_detect.evaluation.trials.cases import SimulatedCase
from hijack_detect.simulation.hard_flights import HARD_FLIGHTS

FIRST_SEED, SEEDS_OF_A_CLASS = 70_000_000, 10_000
FLIGHTS = 10
"""Flights of each class at scale 1."""
MAX_SCALE = 200


def hard(scale: int = 1) -> list[SimulatedCase]:
    """As many flights of each of the HARD_FLIGHTS.

    A larger scale adds flights and changes none.

    Args:
        scale: How many times 10 flights of each class.

    Raises:
        ValueError: The scale is not within 1 to MAX_SCALE.
    """
    if not 1 <= scale <= MAX_SCALE:
        raise ValueError(f"scale is {scale}, it must be within 1 to {MAX_SCALE}")
    return [hard_case(name, number) for name in HARD_FLIGHTS for number in range(FLIGHTS * scale)]


def hard_case(name: str, number: int) -> SimulatedCase:
    """A flight of a class by its number within the class.

    Raises:
        KeyError: There is no such class.
    """
    seed = FIRST_SEED + list(HARD_FLIGHTS).index(name) * SEEDS_OF_A_CLASS + number
    return SimulatedCase(f"{name}_{number}", name, HARD_FLIGHTS[name](seed), seed)
