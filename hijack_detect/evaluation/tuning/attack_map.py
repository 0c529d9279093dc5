# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Map of the carry-offs that are seen: drift speed against onset acceleration."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hijack_detect.evaluation.scores.evaluate import run_cases
from hijack_detect.evaluation.scores.metrics import FlightOutcome, Proportion, summarise
from hijack_detect.evaluation.trials.cases import HIJACKED, SETTLED_S, SimulatedCase
from hijack_detect.evaluation.trials.limits import ATTACK_S
from hijack_detect.evaluation.trials.parallel import HERE, Failure, Pool
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.simulation.plan import FlightPlan, forward_end_s, forward_start_s
from hijack_detect.spoofing.scenario import Scenario, parse_scenario

SPEEDS = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Final speeds of the drift, m/s."""
ACCELERATIONS = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2)
"""Acceleration of the drift, m/s²."""
FLIGHTS = 6
"""Flights in each cell at scale 1, the same in every cell."""
FIRST_SEED = 50_000


@dataclass(frozen=True)
class Cell:
    """Result of one method for one size of attack.

    Attributes:
        method: The method.
        speed: Final speed of the drift, m/s; 0 for no attack at all, where a detection is
            chance: a false alarm in the same time of the same flights.
        acceleration: How fast it is gathered, m/s².
        detected: Flights whose first alarm is in the attack.
        median_s: Median time to detect, seconds, None without a detection.
    """

    method: str
    speed: float
    acceleration: float
    detected: Proportion
    median_s: float | None


def attack_cases(
    speed: float, acceleration: float, flights: int, *, first_seed: int = FIRST_SEED
) -> list[SimulatedCase]:
    """Flights under one size of attack: straight and curved in turn, to any side."""
    cases = []
    for seed in range(first_seed, first_seed + flights):
        plan = FlightPlan("straight" if seed % 2 == 0 else "curved")
        scenario = _carry_off(plan, seed, speed, acceleration)
        name = f"drift_{speed:g}_{acceleration:g}_{seed}"
        cases.append(SimulatedCase(name, HIJACKED, plan, seed, scenario))
    return cases


def attack_map(
    parameters: MonitorParameters,
    *,
    flights: int = FLIGHTS,
    speeds: Sequence[float] = SPEEDS,
    accelerations: Sequence[float] = ACCELERATIONS,
    pool: Pool = HERE,
    on_done: Callable[[int], None] | None = None,
) -> tuple[list[Cell], list[Failure]]:
    """Fly every size of attack on the closed-loop simulator, and once none at all.

    Args:
        parameters: Parameters of every part.
        flights: Flights for each size.
        speeds: Final speeds of the drift, m/s.
        accelerations: How fast it is gathered, m/s².
        pool: Where the flights are run.
        on_done: Called after each flight with the number of flights that are done.
    """
    sizes = attack_sizes(speeds, accelerations)
    cases = [case for size in sizes for case in attack_cases(*size, flights)]
    results = run_cases(cases, parameters, pool=pool, on_done=on_done)
    cells = []
    for index, size in enumerate(sizes):
        own = results[index * flights : (index + 1) * flights]
        done = [result for result in own if isinstance(result, FlightOutcome)]
        cells += [_cell(name, size, done) for name in (done[0].methods if done else ())]
    return cells, [result for result in results if isinstance(result, Failure)]


def attack_sizes(
    speeds: Sequence[float], accelerations: Sequence[float]
) -> list[tuple[float, float]]:
    """Speed and acceleration of every cell; the first is no attack."""
    return [(0.0, 1.0), *((speed, gain) for speed in speeds for gain in accelerations)]


def csv_text(cells: Sequence[Cell]) -> str:
    """The map as a table."""
    lines = ["method,speed_m_s,acceleration_m_s2,detected,flights,low95,high95,median_s"]
    for cell in cells:
        one, median = cell.detected, "" if cell.median_s is None else f"{cell.median_s:.2f}"
        lines.append(
            f"{cell.method},{cell.speed:g},{cell.acceleration:g},{one.count},{one.total},"
            f"{one.low:.4f},{one.high:.4f},{median}"
        )
    return "\n".join(lines) + "\n"


def _carry_off(plan: FlightPlan, seed: int, speed: float, acceleration: float) -> Scenario:
    """A drift at a time and to a side that depend on the seed alone."""
    rng = np.random.default_rng(seed)
    latest = forward_end_s(plan) - ATTACK_S
    onset = round(float(rng.uniform(forward_start_s(plan) + SETTLED_S, latest)), 1)
    model = {
        "type": "drift",
        "speed_m_s": speed,
        "onset_acceleration_m_s2": acceleration,
        "bearing_deg": round(float(rng.uniform(-180.0, 180.0)), 1),
        "relative": True,
    }
    segment = {"name": "carry-off", "start": onset, "end": onset + ATTACK_S, "model": model}
    return parse_scenario({"segments": [segment]}, "carry-off")


def _cell(method: str, size: tuple[float, float], flights: Sequence[FlightOutcome]) -> Cell:
    summary = summarise(flights, method)
    times = summary.time_to_detect_s
    return Cell(method, *size, summary.detected, None if times is None else times.median)
