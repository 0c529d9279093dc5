# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The air: a mean wind, and gusts that come and go."""

from __future__ import annotations

import math

import numpy as np

from hijack_detect.simulation.conditions import Conditions
from hijack_detect.simulation.noise import Array, gauss_markov
from hijack_detect.simulation.plan import FlightPlan

VERTICAL_GUSTS = 0.4
"""Deviation of the vertical gusts over that of the horizontal ones, near the ground."""


def wind(
    plan: FlightPlan, conditions: Conditions, count: int, rate_hz: float, rng: np.random.Generator
) -> Array:
    """Velocity of the air, m/s in ENU, shape (count, 3).

    Gusts are Gauss-Markov processes, the longitudinal form of the Dryden model; the discrete
    ones of the plan add to them.
    """
    mean = conditions.wind_m_s * np.array(
        [math.cos(conditions.wind_direction), math.sin(conditions.wind_direction), 0.0]
    )
    deviation = conditions.gust_m_s * np.array([1.0, 1.0, VERTICAL_GUSTS])
    noise = gauss_markov(rng.normal(size=(count, 3)), conditions.gust_s, rate_hz)
    return mean + deviation * noise + plan.disturbances.gust(np.arange(count) / rate_hz)
