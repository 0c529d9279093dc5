# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Routes are as they are called, and can be flown."""

import math
from itertools import pairwise

import numpy as np
import pytest

from hijack_detect.simulation.conditions import draw_conditions
from hijack_detect.simulation.plan import ROUTES, FlightPlan, forward_end_s, forward_start_s
from hijack_detect.simulation.route import RATE_HZ, Route, plan_route


def route(kind: str, seed: int, **plan: float) -> Route:
    streams = [np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(2)]
    asked = FlightPlan(route=kind, **plan)  # type: ignore[arg-type]
    return plan_route(asked, draw_conditions(asked, streams[0]), streams[1])


def turns(planned: Route) -> list[tuple[float, float]]:
    """Start and end of each turn of more than 40°, seconds."""
    turning = np.abs(np.gradient(planned.course)) * RATE_HZ > math.radians(6.0)
    edges = np.flatnonzero(np.diff(turning.astype(int)))
    pairs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [
        (start / RATE_HZ, end / RATE_HZ)
        for start, end in pairs
        if abs(planned.course[end] - planned.course[start]) > math.radians(40.0)
    ]


@pytest.mark.parametrize("kind", ROUTES)
def test_every_route_is_smooth_and_flyable(kind: str) -> None:
    for seed in range(20):
        planned = route(kind, seed)
        speed = np.hypot(planned.velocity[:, 0], planned.velocity[:, 1])
        assert np.linalg.norm(planned.acceleration, axis=1).max() < 4.0
        assert speed[0] == speed[-1] == 0.0
        assert speed.max() < 9.01
        assert planned.position[-1, 2] == pytest.approx(20.0, abs=0.1)
        assert np.abs(np.diff(planned.yaw)).max() * RATE_HZ < math.radians(70.0)


def test_position_is_the_integral_of_the_velocity() -> None:
    planned = route("curved", 4)
    steps = (planned.velocity[1:] + planned.velocity[:-1]) / 2.0 / RATE_HZ
    assert np.allclose(np.diff(planned.position, axis=0), steps, atol=1e-12)


def test_a_straight_route_is_one_leg() -> None:
    planned = route("straight", 3)
    assert np.ptp(planned.course) == 0.0
    assert np.ptp(planned.yaw[round(30 * RATE_HZ) :]) == 0.0


def test_most_curved_routes_have_two_turns_in_quick_succession() -> None:
    """Feng 2018, section 5: at least two continuous turns within a short time in 80 %."""
    quick = 0
    for seed in range(100):
        found = turns(route("curved", seed))
        assert len(found) >= 3
        gaps = [after[0] - before[1] for before, after in pairwise(found)]
        quick += min(gaps) < 4.0
    assert quick >= 80


def test_a_survey_has_parallel_legs_and_sharp_turns() -> None:
    for seed in range(20):
        planned = route("survey", seed)
        found = turns(planned)
        assert len(found) >= 3
        assert all(end - start < 4.0 for start, end in found)
        quarter = (planned.course - planned.course[0]) / (math.pi / 2.0)
        legs = quarter[[round((end + 1.5) * RATE_HZ) for _, end in found]]
        assert np.allclose(legs, np.round(legs), atol=0.02)


def test_a_hover_stays_and_a_fixed_yaw_keeps_its_heading() -> None:
    assert np.all(route("hover", 1).velocity[:, :2] == 0.0)
    planned = route("fixed_yaw", 1)
    assert np.ptp(planned.yaw) == 0.0
    assert np.ptp(planned.course) > 0.5


def test_the_speed_is_the_one_asked_for() -> None:
    plan = FlightPlan(speed=12.0)
    planned = route("straight", 1, speed=12.0)
    cruise = slice(
        round((forward_start_s(plan) + 9.0) * RATE_HZ), round(forward_end_s(plan) * RATE_HZ)
    )
    assert np.allclose(np.linalg.norm(planned.velocity[cruise], axis=1), 12.0)


def test_a_long_plan_can_be_laid_out() -> None:
    for kind in ROUTES:
        assert len(route(kind, 1, duration_s=1000.0).yaw) == 1000 * RATE_HZ + 1
