# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Clean flights that resemble attacked ones, by name.

The seed draws when a disturbance begins, from where it comes and how strong it is, from a
generator of its own; generate the flight with the same seed. Every disturbance lies in the
forward flight, so that the monitor has settled before it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from hijack_detect.simulation.disturbances import (
    Anomaly,
    Disturbances,
    Gust,
    Jump,
    Outage,
    Pulse,
    Spin,
    Vibration,
)
from hijack_detect.simulation.plan import FlightPlan, forward_end_s, forward_start_s
from hijack_detect.streams.samples import Vector3

SETTLED_S = 20.0
"""Earliest disturbance after the command to fly forward. Chosen: the detectors are ready."""
GUST_M_S = 8.0
"""Sizes of the disturbances are chosen: docs/simulator.md has what each does to a flight."""
ANOMALY_T = 20e-6
ANOMALY_S = 20.0
OUTAGE_S = 20.0
JUMP_M = 2.0
ROUTES = ("curved", "straight")
"""Even seeds fly the first, odd ones the second, where a flight is not of a certain route."""

Plan = Callable[[int], FlightPlan]


def strong_wind(seed: int) -> FlightPlan:
    """A mean of 8 m/s with a turbulence of a fifth of it, from the ground on."""
    disturbances = Disturbances(turbulence_m_s=0.2 * GUST_M_S)
    return FlightPlan(_route(seed), wind_m_s=GUST_M_S, disturbances=disturbances)


def gusts(seed: int) -> FlightPlan:
    """1-cos gusts of 8 m/s from any side that rise within 1 to 3 s, every 6 to 10 s."""
    rng, plan = _rng(seed), FlightPlan(_route(seed), wind_m_s=2.0)
    found, now = [], forward_start_s(plan) + SETTLED_S
    while now < forward_end_s(plan) - 6.0:
        pulse = Pulse(now, rng.uniform(1.0, 3.0))
        found.append(Gust(pulse, _horizontal(GUST_M_S, rng)))
        now += rng.uniform(6.0, 10.0)
    return FlightPlan(plan.route, wind_m_s=2.0, disturbances=Disturbances(gusts=tuple(found)))


def gust_front(seed: int) -> FlightPlan:
    """A weak wind rises by 8 m/s within 1 to 3 s and falls again after 15 s."""
    rng = _rng(seed)
    pulse = Pulse(_begin(rng), rng.uniform(1.0, 3.0), 15.0)
    front = Gust(pulse, _horizontal(GUST_M_S, rng))
    return FlightPlan(_route(seed), wind_m_s=1.0, disturbances=Disturbances(gusts=(front,)))


def hard_braking(seed: int) -> FlightPlan:
    """To 8 to 12 m/s with 4 m/s² and to a stop with 6 m/s², again and again."""
    return FlightPlan("brake", speed=float(_rng(seed).uniform(8.0, 12.0)))


def spin_in_hover(seed: int) -> FlightPlan:
    """Three spins of 90 to 180 °/s for 4 to 8 s, standing."""
    rng = _rng(seed)
    spins = tuple(_spin(rng, start, rng.uniform(1.0, 4.0)) for start in (42.0, 60.0, 78.0))
    return FlightPlan("hover", disturbances=Disturbances(spins=spins))


def spin_in_flight(seed: int) -> FlightPlan:
    """Two spins of one or two whole turns with 90 to 180 °/s while it flies on."""
    rng = _rng(seed)
    spins = tuple(_spin(rng, start, float(rng.integers(1, 3))) for start in (45.0, 68.0))
    return FlightPlan(_route(seed), disturbances=Disturbances(spins=spins))


def compass_anomaly(seed: int) -> FlightPlan:
    """A foreign field of 20 µT from any side for 20 s, which comes and goes within 1 s."""
    rng = _rng(seed)
    east, north, _ = _horizontal(1.0, rng)
    up = rng.uniform(-1.0, 1.0)
    scale = ANOMALY_T / math.hypot(1.0, up)
    anomaly = Anomaly(
        Pulse(_begin(rng), 1.0, ANOMALY_S - 2.0), (scale * east, scale * north, scale * up)
    )
    return FlightPlan(_route(seed), disturbances=Disturbances(anomalies=(anomaly,)))


def gps_outage(seed: int) -> FlightPlan:
    """The receiver is silent for 20 s, and the autopilot flies on by its inertial navigation."""
    outage = Outage(round(_begin(_rng(seed)), 1), OUTAGE_S)
    return FlightPlan(_route(seed), disturbances=Disturbances(outages=(outage,)))


def receiver_jump(seed: int) -> FlightPlan:
    """The fixes step aside by 2 m and stay there; the reported velocity does not."""
    rng = _rng(seed)
    jump = Jump(_begin(rng), _horizontal(JUMP_M, rng))
    return FlightPlan(_route(seed), disturbances=Disturbances(jumps=(jump,)))


def vibration(seed: int) -> FlightPlan:
    """3 to 5 m/s² rms on each axis from rotors at 80 to 140 Hz, folded by the sampling."""
    rng = _rng(seed)
    strong = Vibration(float(rng.uniform(3.0, 5.0)), float(rng.uniform(80.0, 140.0)))
    return FlightPlan(_route(seed), disturbances=Disturbances(vibration=strong))


HARD_FLIGHTS: Mapping[str, Plan] = {
    "strong_wind": strong_wind,
    "gusts": gusts,
    "gust_front": gust_front,
    "hard_braking": hard_braking,
    "spin_in_hover": spin_in_hover,
    "spin_in_flight": spin_in_flight,
    "compass_anomaly": compass_anomaly,
    "gps_outage": gps_outage,
    "receiver_jump": receiver_jump,
    "vibration": vibration,
}
"""Makers of the plans by name; the argument is the seed, which `generate_flight` needs too."""


def _rng(seed: int) -> np.random.Generator:
    """A generator that shares nothing with those of the flight of the same seed."""
    return np.random.default_rng([seed, 4242])


def _route(seed: int) -> str:
    return ROUTES[seed % len(ROUTES)]


def _begin(rng: np.random.Generator) -> float:
    """When a single disturbance begins; at least 20 s of the route come after 20 s of it."""
    plan = FlightPlan()
    first = forward_start_s(plan) + SETTLED_S
    return float(rng.uniform(first, forward_end_s(plan) - 40.0))


def _horizontal(length: float, rng: np.random.Generator) -> Vector3:
    """A vector of some length in any direction, ENU."""
    angle = rng.uniform(-math.pi, math.pi)
    return (length * math.cos(angle), length * math.sin(angle), 0.0)


def _spin(rng: np.random.Generator, start_s: float, turns: float) -> Spin:
    """A spin to either side."""
    side = float(rng.choice([-1.0, 1.0]))
    return Spin(start_s, side * turns, float(rng.uniform(90.0, 180.0)))
