"""How the vehicle moves: velocity commands, smoothed, integrated and differentiated.

All arrays are on one grid of a thousand points a second; world vectors are ENU.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hijack_detect.simulation.plan import (
    CLIMB_RATE,
    GROUND_S,
    RAMP_S,
    FlightPlan,
    climb_end_s,
    forward_end_s,
    forward_start_s,
)

Array = npt.NDArray[np.float64]

RATE_HZ = 1000
ACCELERATION_S = 4.0
"""Seconds to reach or to leave the speed of the route."""
SMOOTHING_S = 0.4
"""Width of each of three moving averages: about how fast a multirotor tilts."""
YAW_LAG_S = 0.3
"""Mean lag of the nose behind the course."""


@dataclass(frozen=True)
class Kinematics:
    """The motion of the vehicle, without its attitude.

    Attributes:
        time_s: Seconds from the start, shape (n,).
        position: Metres from the start in ENU, shape (n, 3): the integral of the velocity.
        velocity: m/s in ENU, shape (n, 3).
        acceleration: m/s² in ENU, shape (n, 3): the derivative of the velocity.
        course: Commanded course after smoothing, radians counter-clockwise from East, unwrapped.
        yaw: Direction of the nose, radians counter-clockwise from East, unwrapped.
        airborne: 0 on the ground, 1 in flight.
        wind: m/s in ENU, where the air moves to, shape (n, 3).
    """

    time_s: Array
    position: Array
    velocity: Array
    acceleration: Array
    course: Array
    yaw: Array
    airborne: Array
    wind: Array


def kinematics(plan: FlightPlan, rng: np.random.Generator) -> Kinematics:
    """Make the motion of a plan; `rng` chooses course, turns, wind and wander."""
    time = np.arange(round(plan.duration_s * RATE_HZ) + 1) / RATE_HZ
    first = rng.uniform(-np.pi, np.pi)
    times, angles = _turns(plan, rng)
    course_command = first + np.interp(time, times, angles)

    start, end = forward_start_s(plan), forward_end_s(plan)
    speed = np.interp(
        time,
        [start, start + ACCELERATION_S, end, end + ACCELERATION_S],
        [0.0, plan.speed, plan.speed, 0.0],
    )
    climb_end = climb_end_s(plan)
    climb = np.interp(
        time,
        [GROUND_S, GROUND_S + RAMP_S, climb_end - RAMP_S, climb_end],
        [0.0, CLIMB_RATE, CLIMB_RATE, 0.0],
    )
    climb *= plan.height_m / (float(np.sum(climb)) / RATE_HZ)

    align = start - 5.0
    before = first + rng.uniform(0.5, 1.5) * rng.choice([-1.0, 1.0])
    yaw_command = np.where(
        time < start, np.interp(time, [align, align + 3.0], [before, first]), course_command
    )
    course = _smooth(course_command)
    yaw = moving_average(_smooth(yaw_command), 2 * YAW_LAG_S)
    airborne = _smooth((time >= GROUND_S).astype(float))
    yaw += 0.01 * airborne * _wave(time, rng)

    speed = _smooth(speed)
    velocity = np.stack([speed * np.cos(course), speed * np.sin(course), _smooth(climb)], axis=1)
    velocity[:, 0] += 0.06 * airborne * _wave(time, rng)
    velocity[:, 1] += 0.06 * airborne * _wave(time, rng)
    velocity[:, 2] += 0.03 * airborne * _wave(time, rng)
    return Kinematics(
        time_s=time,
        position=integrate(velocity),
        velocity=velocity,
        acceleration=np.gradient(velocity, 1.0 / RATE_HZ, axis=0),
        course=course,
        yaw=yaw,
        airborne=airborne,
        wind=_wind(time, rng),
    )


def moving_average(signal: Array, width_s: float) -> Array:
    """Mean of the last `width_s` seconds, the first value standing for all before it."""
    width = round(width_s * RATE_HZ)
    total = np.cumsum(np.concatenate([np.full(width, signal[0]), signal]) - signal[0])
    mean: Array = signal[0] + (total[width:] - total[:-width]) / width
    return mean


def integrate(velocity: Array) -> Array:
    """Trapezoidal integral from zero; at this rate within a micrometre of the exact one."""
    steps = (velocity[1:] + velocity[:-1]) / (2.0 * RATE_HZ)
    return np.concatenate([np.zeros((1, velocity.shape[1])), np.cumsum(steps, axis=0)])


def _smooth(command: Array) -> Array:
    for _ in range(3):
        command = moving_average(command, SMOOTHING_S)
    return command


def _turns(plan: FlightPlan, rng: np.random.Generator) -> tuple[list[float], list[float]]:
    """Return the knots of the course command relative to the first course."""
    times, angles = [0.0], [0.0]
    if plan.route == "straight":
        return times, angles
    start = forward_start_s(plan) + ACCELERATION_S + 4.0
    leg = 2.0
    while True:
        turn = np.radians(rng.uniform(50.0, 110.0)) * rng.choice([-1.0, 1.0])
        end = start + abs(turn) / np.radians(rng.uniform(18.0, 26.0))
        if end > forward_end_s(plan) - 3.0:
            return times, angles
        times += [start, end]
        angles += [angles[-1], angles[-1] + turn]
        start = end + leg
        leg = rng.uniform(4.0, 11.0)


def _wind(time: Array, rng: np.random.Generator) -> Array:
    """Return a constant wind of 2 to 4 m/s from anywhere, with slow gusts of about 0.4 m/s."""
    speed, direction = rng.uniform(2.0, 4.0), rng.uniform(-np.pi, np.pi)
    east = speed * np.cos(direction) + 0.4 * _wave(time, rng)
    north = speed * np.sin(direction) + 0.4 * _wave(time, rng)
    return np.stack([east, north, np.zeros_like(time)], axis=1)


def _wave(time: Array, rng: np.random.Generator) -> Array:
    """Return a smooth random signal of unit deviation, 0.04 to 0.3 Hz."""
    total = np.zeros_like(time)
    for _ in range(4):
        frequency, phase = rng.uniform(0.04, 0.3), rng.uniform(-np.pi, np.pi)
        total += np.sin(2.0 * np.pi * frequency * time + phase)
    unit: Array = total / np.sqrt(2.0)
    return unit
