# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The experiment of Basan et al. 2022, §3: flights whose GPS is forged softly or hard.

The paper gives the standard deviation of the forged altitude (Table 4) and names which parameters
each mode forges (§3.1); everything else is chosen here, before any result was seen. Soft: the
altitude, the number of satellites (9 to 19, the fifth experiment of Table 1) and the noise level.
Hard: also position and velocity, with their own noise, on a position that moves to the
attacker's side; in the second hard mode faster. Every value is drawn for every fix.

`smooth` is not in the paper: the soft mode with values that wander slowly, as a careful attacker
would let them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hijack_detect.evaluation.trials.cases import (
    HIJACKED,
    SETTLED_S,
    BagCase,
    Case,
    SimulatedCase,
    check_scale,
)
from hijack_detect.evaluation.trials.corpus import corpus_cases
from hijack_detect.simulation.plan import FlightPlan, forward_end_s, forward_start_s
from hijack_detect.spoofing.scenario import Scenario, parse_scenario

SOFT: Mapping[str, Any] = {
    "altitude_sigma_m": 4.214443,
    "satellites": [9, 19],
    "accuracy_m": [1.0, 5.0],
}
HARD: Mapping[str, Any] = {**SOFT, "horizontal_sigma_m": 2.0, "velocity_sigma_m_s": 0.5}
MODES: Mapping[str, Mapping[str, Any]] = {
    "soft": SOFT,
    "hard_1": {
        **HARD,
        "altitude_sigma_m": 5.51863,
        "drift_speed_m_s": 2.0,
        "onset_acceleration_m_s2": 0.5,
    },
    "hard_2": {
        **HARD,
        "altitude_sigma_m": 8.342719,
        "drift_speed_m_s": 8.0,
        "onset_acceleration_m_s2": 2.0,
    },
    "smooth": {**SOFT, "correlation_s": 10.0},
}
"""Values of the attack model `forge` by class of flight."""

CLEAN_SEED, FORGED_SEED, SEEDS_OF_A_MODE = 50_000, 60_000, 10_000
FLIGHTS = 25
"""Flights of each class at scale 1."""
ROUTES = ("straight", "curved", "survey", "hover")
ATTACK_S = 30.0
"""Chosen, not swept; the paper notifies within 5 to 30 s."""


def basan2022(scale: int = 1) -> list[SimulatedCase]:
    """Simulated flights: clean ones, and as many of each mode, in closed loop.

    A larger scale adds flights and changes none.

    Args:
        scale: How many times 25 flights of each class.

    Raises:
        ValueError: The scale is not within 1 to MAX_SCALE.
    """
    check_scale(scale)
    numbers = range(FLIGHTS * scale)
    clean = [
        SimulatedCase(f"clean_{number}_{route}", "clean", FlightPlan(route), CLEAN_SEED + number)
        for number, route in ((number, ROUTES[number % len(ROUTES)]) for number in numbers)
    ]
    return clean + [_forged(mode, number) for mode in MODES for number in numbers]


def basan2022_on(corpus: Path, onsets: int) -> list[Case]:
    """The flights of a folder that are not attacked, and each mode put into them.

    Args:
        corpus: The folder.
        onsets: Attacks of each mode on each flight, in its forward flight.

    Raises:
        BagError: The folder cannot be listed, or there is no bag in it.
    """
    # The onsets depend on how long an attack lasts, which is the same in every mode.
    found = corpus_cases(corpus, forged(next(iter(MODES)), 0.0, FORGED_SEED), onsets)
    clean = [case for case in found if not case.injected and case.kind != HIJACKED]
    cases: list[Case] = [dataclasses.replace(case, kind="clean") for case in clean]
    for place, mode in enumerate(MODES):
        attack = forged(mode, 0.0, FORGED_SEED + place)
        cases += [_attacked(case, mode, attack) for case in found if case.scenario is not None]
    return cases


def _attacked(case: BagCase, mode: str, attack: Scenario) -> BagCase:
    """A recorded flight with the attack of a mode at the onset of the one that it has."""
    assert case.scenario is not None
    moved = attack.moved_to(case.scenario.segments[0].start_s)
    return dataclasses.replace(case, name=f"{mode}_{case.name}", kind=mode, scenario=moved)


def _forged(mode: str, number: int) -> SimulatedCase:
    """A simulated flight with an attack whose onset and direction its seed decides."""
    seed = FORGED_SEED + SEEDS_OF_A_MODE * list(MODES).index(mode) + number
    plan = FlightPlan(ROUTES[number % len(ROUTES)])
    latest_s = forward_end_s(plan) - ATTACK_S
    onset_s = np.random.default_rng(seed).uniform(forward_start_s(plan) + SETTLED_S, latest_s)
    scenario = forged(mode, round(onset_s, 1), seed)
    return SimulatedCase(f"{mode}_{number}_{plan.route}", mode, plan, seed, scenario)


def forged(mode: str, onset_s: float, seed: int) -> Scenario:
    """The attack of a mode from an onset on, for ATTACK_S.

    Args:
        mode: One of MODES.
        onset_s: Seconds after the flight's first message.
        seed: Draws the direction of the displacement, then every value.
    """
    bearing = float(np.random.default_rng([seed, 1]).uniform(0.0, 360.0))
    model = {"type": "forge", "seed": seed, "bearing_deg": bearing, **MODES[mode]}
    segment = {"name": mode, "start": onset_s, "end": onset_s + ATTACK_S, "model": model}
    return parse_scenario({"segments": [segment]}, f"{mode} mode")
