# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Where the flight is meant to be: course and speed over time, smoothed and integrated."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hijack_detect.simulation.conditions import Conditions
from hijack_detect.simulation.noise import Array
from hijack_detect.simulation.plan import (
    CLIMB_RATE,
    GROUND_S,
    RAMP_S,
    FlightPlan,
    climb_end_s,
    forward_end_s,
    forward_start_s,
)

Knots = tuple[list[float], list[float]]
"""Times in seconds and the values at these times, linear in between."""

BRAKE_ROUTE_ACCELERATION = 4.0
"""m/s² to reach the speed. Chosen: a tilt of 22°."""
BRAKING = 6.0
"""m/s² to a stop. Chosen: a tilt of 31°, below the 35° of the autopilot."""


def braking(start_s: float, end_s: float, cruise: float, rng: np.random.Generator) -> Knots:
    """Speed of the route over time.

    Args:
        start_s: Command to fly forward, seconds from the start of the recording.
        end_s: When the last stop begins at the latest.
        cruise: Speed to reach, m/s.
        rng: Draws how long it flies and how long it stands.
    """
    times, speeds, now = [start_s], [0.0], start_s
    while True:
        fast = now + cruise / BRAKE_ROUTE_ACCELERATION
        brake = fast + rng.uniform(3.0, 6.0)
        stop = brake + cruise / BRAKING
        if brake > end_s:
            return times, speeds
        now = stop + rng.uniform(2.0, 5.0)
        times += [fast, brake, stop, now]
        speeds += [cruise, cruise, 0.0, 0.0]


RATE_HZ = 50
"""Rate of the autopilot and its route. Chosen."""
ACCELERATION = 2.0
"""m/s² to reach or to leave the speed of the route. Chosen: a tilt of 12°."""
SMOOTHING_S = 0.4
"""Width of each of three moving averages. Chosen: about as slow as a multirotor tilts."""
TURN_ACCELERATION = 2.8
"""Largest centripetal acceleration of a planned turn, m/s². Chosen: a bank of 16°."""
QUICK_PAIRS = 0.8
"""Share of the curved routes that begin with two turns in quick succession (Feng 2018, section 5:
80 %); most others have such a pair by chance."""
CORNER_SPEED = 2.0
"""Speed in the corners of a survey, m/s. Chosen, as the next."""
CORNER_S = 1.5
"""Seconds in which a corner of a survey is turned."""
MAX_YAW_RATE = math.radians(60.0)
"""Largest yaw rate of the autopilot, rad/s, but for a planned spin. Chosen, not swept."""


@dataclass(frozen=True)
class Route:
    """The planned motion, RATE_HZ rows a second from the start of the recording.

    Attributes:
        position: Metres from the start in ENU, shape (n, 3).
        velocity: m/s in ENU, shape (n, 3).
        acceleration: m/s² in ENU, shape (n, 3).
        course: Radians counter-clockwise from East, unwrapped, shape (n,).
        yaw: Planned heading, radians counter-clockwise from East, unwrapped, shape (n,).
        max_yaw_rate: How fast the nose is turned at most, rad/s.
    """

    position: Array
    velocity: Array
    acceleration: Array
    course: Array
    yaw: Array
    max_yaw_rate: float = MAX_YAW_RATE


def plan_route(plan: FlightPlan, conditions: Conditions, rng: np.random.Generator) -> Route:
    """Lay out the route of a plan; `rng` chooses the turns."""
    time = np.arange(round(plan.duration_s * RATE_HZ) + 1) / RATE_HZ
    start, end, cruise = forward_start_s(plan), forward_end_s(plan), conditions.speed
    ramp = cruise / ACCELERATION
    speeds: Knots = ([start, start + ramp, end, end + ramp], [0.0, cruise, cruise, 0.0])
    turns: Knots = ([0.0], [0.0])
    if plan.route == "hover":
        speeds = ([0.0], [0.0])
    elif plan.route == "survey":
        speeds, turns = _survey(plan, cruise, rng)
    elif plan.route == "brake":
        speeds = braking(forward_start_s(plan), forward_end_s(plan), cruise, rng)
    elif plan.route != "straight":
        turns = _curves(plan, cruise, rng)
    course = _smooth(conditions.first_course + np.interp(time, *turns))
    speed = _smooth(np.interp(time, *speeds))
    velocity = np.stack([speed * np.cos(course), speed * np.sin(course), _climb(plan, time)], 1)
    middle = (velocity[1:] + velocity[:-1]) / (2.0 * RATE_HZ)
    return Route(
        position=np.concatenate([np.zeros((1, 3)), np.cumsum(middle, axis=0)]),
        velocity=velocity,
        acceleration=np.gradient(velocity, 1.0 / RATE_HZ, axis=0),
        course=course,
        yaw=_yaw(plan, conditions, time, course) + _spun(plan, time),
        max_yaw_rate=_yaw_rate(plan),
    )


def _climb(plan: FlightPlan, time: Array) -> Array:
    """Rate of climb, m/s: smooth, and just as long as the height needs."""
    end = climb_end_s(plan)
    rate = np.interp(
        time, [GROUND_S, GROUND_S + RAMP_S, end - RAMP_S, end], [0.0, CLIMB_RATE, CLIMB_RATE, 0.0]
    )
    smooth: Array = _smooth(rate * (plan.height_m * RATE_HZ / float(np.sum(rate))))
    return smooth


def _yaw(plan: FlightPlan, conditions: Conditions, time: Array, course: Array) -> Array:
    """The nose turns to the first course before the route begins, and follows it from then on."""
    if plan.route in ("hover", "fixed_yaw"):
        return np.full(len(time), conditions.first_yaw)
    start = forward_start_s(plan)
    align = [start - 5.0, start - 2.0]
    before = np.interp(time, align, [conditions.first_yaw, conditions.first_course])
    return np.where(time < start, _smooth(before), course)


def _spun(plan: FlightPlan, time: Array) -> Array:
    """What the spins add to the heading, radians."""
    spun: Array = np.zeros(len(time))
    for spin in plan.disturbances.spins:
        spun += _smooth(spin.angle(time))
    return spun


def _yaw_rate(plan: FlightPlan) -> float:
    """How fast the nose may turn, rad/s."""
    spins = [math.radians(spin.rate_deg_s) for spin in plan.disturbances.spins]
    return max([MAX_YAW_RATE, *(1.1 * rate for rate in spins)])


def _curves(plan: FlightPlan, cruise: float, rng: np.random.Generator) -> Knots:
    """Turns of 50° to 110° to either side, with straight legs between them."""
    times, angles = [0.0], [0.0]
    start = forward_start_s(plan) + cruise / ACCELERATION + rng.uniform(2.0, 8.0)
    leg = 2.0 if rng.uniform() < QUICK_PAIRS else rng.uniform(4.0, 10.0)
    while True:
        turn = np.radians(rng.uniform(50.0, 110.0)) * rng.choice([-1.0, 1.0])
        rate = min(np.radians(rng.uniform(18.0, 26.0)), TURN_ACCELERATION / cruise)
        end = start + abs(turn) / rate
        if end > forward_end_s(plan) - 3.0:
            return times, angles
        times += [start, end]
        angles += [angles[-1], angles[-1] + turn]
        start = end + leg
        leg = rng.uniform(2.0, 10.0)


def _survey(plan: FlightPlan, cruise: float, rng: np.random.Generator) -> tuple[Knots, Knots]:
    """Speed and course of parallel legs: brake, turn 90°, cross over, turn 90°, fly back."""
    long_s, short_s = rng.uniform(8.0, 12.0), rng.uniform(2.0, 4.0)
    side = rng.choice([-1.0, 1.0])
    now, angle = forward_start_s(plan), 0.0
    end = forward_end_s(plan)
    times, speeds, turn_times, angles = [now], [0.0], [0.0], [0.0]
    corners = 0
    slow = min(CORNER_SPEED, cruise)
    ramp = 1.0 + (cruise - slow) / ACCELERATION
    while True:
        cruise_s = long_s if corners % 2 == 0 else short_s
        top = cruise if corners % 2 == 0 else 0.5 * (cruise + slow)
        corner = now + ramp + cruise_s + ramp
        if corner + CORNER_S + ramp > end:
            break
        times += [now + ramp, corner - ramp, corner, corner + CORNER_S]
        speeds += [top, top, slow, slow]
        turn_times += [corner, corner + CORNER_S]
        angles += [angle, angle + side * np.pi / 2.0]
        now, angle = corner + CORNER_S, angles[-1]
        corners += 1
        if corners % 2 == 0:
            side = -side
    times += [now + ramp, max(end, now + ramp + 0.1), max(end, now + ramp) + cruise / ACCELERATION]
    speeds += [cruise, cruise, 0.0]
    return (times, speeds), (turn_times, angles)


def _smooth(command: Array) -> Array:
    """Three moving averages over the last SMOOTHING_S seconds."""
    width = round(SMOOTHING_S * RATE_HZ)
    for _ in range(3):
        padded = np.concatenate([np.full(width, command[0]), command]) - command[0]
        total = np.cumsum(padded)
        command = command[0] + (total[width:] - total[:-width]) / width
    return command
