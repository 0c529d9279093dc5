# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Generated sets of flights to judge methods on; the seeds are fixed, so everyone gets the same.

`feng2018` is the experiment of Feng 2018, §5: 25 clean flights on straight and 25 on curved
routes, and 50 flights that are hijacked. There an array of fake fixes takes the place of the
receiver from a time set in advance. The fake track goes on in the direction of flight, straight
or turning, and the autopilot, which believes it, flies the real vehicle off its route.

The paper does not state where its fake fixes came from. Drawn by computer, as in `feng2018`, their
course is exactly constant between turns, which no receiver's is. `feng2018_noisy` is the same
with noise on the fake fixes, as if they had been recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from hijack_detect.evaluation.trials.basan2022 import basan2022
from hijack_detect.evaluation.trials.cases import SETTLED_S, SimulatedCase, check_scale
from hijack_detect.evaluation.trials.fake_tracks import ATTACK_S, TRACKS, fake_track
from hijack_detect.evaluation.trials.limits import limits
from hijack_detect.simulation.hard_flights import HARD_FLIGHTS
from hijack_detect.simulation.plan import FlightPlan, forward_end_s, forward_start_s

STRAIGHT_SEED, CURVED_SEED, HIJACKED_SEED = 10_000, 20_000, 30_000
"""First seed of each class; every further flight has the next one."""

NOISE_M = 0.03
"""Noise of recorded fake fixes, East and North each: 0.1 m/s in their velocity. Chosen, not
swept."""


def feng2018(scale: int = 1, *, noise_m: float = 0.0) -> list[SimulatedCase]:
    """The experiment of Feng 2018, §5, with `scale` times as many flights.

    A larger scale adds flights and changes none.

    Args:
        scale: How many times 100 flights.
        noise_m: Standard deviation of the noise on the fake fixes, metres.

    Raises:
        ValueError: The scale is not within 1 to MAX_SCALE.
    """
    check_scale(scale)
    clean = [
        SimulatedCase(f"{route}_{first + index}", route, FlightPlan(route), first + index)
        for route, first in (("straight", STRAIGHT_SEED), ("curved", CURVED_SEED))
        for index in range(25 * scale)
    ]
    return clean + [hijacked_case(HIJACKED_SEED + index, noise_m) for index in range(50 * scale)]


def hijacked_case(seed: int, noise_m: float = 0.0) -> SimulatedCase:
    """A flight with a fake track: even seeds fly a straight route, odd ones a curved one."""
    plan = FlightPlan("straight" if seed % 2 == 0 else "curved")
    rng = np.random.default_rng(seed)
    shape = str(rng.choice(TRACKS))
    onset = rng.uniform(forward_start_s(plan) + SETTLED_S, forward_end_s(plan) - ATTACK_S)
    scenario = fake_track(shape, round(onset, 1), rng, noise_m)
    return SimulatedCase(f"hijacked_{seed}_{plan.route}_{shape}", "hijacked", plan, seed, scenario)


HARD_SEED, SEEDS_OF_A_CLASS = 70_000_000, 10_000
FLIGHTS = 10
"""Flights of each class at scale 1."""


def hard(scale: int = 1) -> list[SimulatedCase]:
    """As many flights of each of the HARD_FLIGHTS.

    A larger scale adds flights and changes none.

    Args:
        scale: How many times 10 flights of each class.

    Raises:
        ValueError: The scale is not within 1 to MAX_SCALE.
    """
    check_scale(scale)
    return [hard_case(name, number) for name in HARD_FLIGHTS for number in range(FLIGHTS * scale)]


def hard_case(name: str, number: int) -> SimulatedCase:
    """A flight of a class by its number within the class.

    Raises:
        KeyError: There is no such class.
    """
    seed = HARD_SEED + list(HARD_FLIGHTS).index(name) * SEEDS_OF_A_CLASS + number
    return SimulatedCase(f"{name}_{number}", name, HARD_FLIGHTS[name](seed), seed)


PROTOCOLS: Mapping[str, Callable[[int], list[SimulatedCase]]] = {
    "feng2018": feng2018,
    "feng2018_noisy": partial(feng2018, noise_m=NOISE_M),
    "basan2022": basan2022,
    "limits": limits,
    "hard": hard,
}
"""Makers of the cases by name of the protocol; the argument is the scale."""
