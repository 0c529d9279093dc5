# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Flights of the closed-loop simulator, clean and under one size of attack for each class.

They are for detection rates with narrow intervals: at scale 10 there are 300 clean flights, half
of them curved, and 300 of every attack. The autopilot believes the spoofed GPS, so the attack
moves the vehicle.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hijack_detect.evaluation.trials.cases import SETTLED_S, SimulatedCase, check_scale
from hijack_detect.evaluation.trials.families import (
    Size,
    climb,
    drift,
    freeze,
    jump,
    scenario_of,
    turn_away,
)
from hijack_detect.simulation.plan import FlightPlan, forward_end_s, forward_start_s

FIRST_SEED, SEEDS_OF_A_CLASS = 60_000_000, 10_000
FLIGHTS = 30
"""Flights of each class at scale 1; each of the two clean classes has half as many."""
ROUTES = ("straight", "curved")
ATTACK_S = 40.0
"""Least route left after the onset; the attack itself does not end. Chosen, not swept."""

CLASSES: Mapping[str, Size] = {
    "drift_0.4": drift(0.4, 4.0),
    "drift_0.6": drift(0.6, 4.0),
    "drift_1.0": drift(1.0, 4.0),
    "drift_0.2": drift(0.2, 4.0),
    "position_only": drift(0.4, 4.0, velocity_consistent=False),
    "jump_20": jump(20.0),
    "jump_8": jump(8.0),
    "freeze": freeze("frozen"),
    "altitude_1": climb(1.0, side=-1.0),
    "turn_away": turn_away(),
}
"""Attacks by class. The reported altitude sinks, so the vehicle climbs and meets no ground."""


def limits(scale: int = 1) -> list[SimulatedCase]:
    """Clean flights, and as many under each attack.

    A larger scale adds flights and changes none.

    Args:
        scale: How many times 30 flights of each class.

    Raises:
        ValueError: The scale is not within 1 to MAX_SCALE.
    """
    check_scale(scale)
    clean = [
        SimulatedCase(
            f"clean_{route}_{number}",
            f"clean_{route}",
            FlightPlan(route),
            FIRST_SEED + place * SEEDS_OF_A_CLASS + number,
        )
        for place, route in enumerate(ROUTES)
        for number in range(FLIGHTS * scale // 2)
    ]
    return clean + [
        _attacked(name, number) for name in CLASSES for number in range(FLIGHTS * scale)
    ]


def _attacked(name: str, number: int) -> SimulatedCase:
    """A flight of a class; its seed decides onset and bearing."""
    seed = FIRST_SEED + (len(ROUTES) + list(CLASSES).index(name)) * SEEDS_OF_A_CLASS + number
    plan = FlightPlan(ROUTES[number % len(ROUTES)])
    latest_s = forward_end_s(plan) - ATTACK_S
    onset_s = np.random.default_rng(seed).uniform(forward_start_s(plan) + SETTLED_S, latest_s)
    flight = f"{name}_{number}"
    scenario = scenario_of(name, CLASSES[name], flight, round(float(onset_s), 1))
    return SimulatedCase(flight, name, plan, seed, scenario)
