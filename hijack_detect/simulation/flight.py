# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One simulated flight: the truth, and the samples of the sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hijack_detect.simulation import sensors
from hijack_detect.simulation.conditions import Conditions, draw_conditions
from hijack_detect.simulation.gps import Gps, HonestReceiver, Reading, Receiver
from hijack_detect.simulation.motion import IMU_HZ, Motion, fly
from hijack_detect.simulation.noise import Array, gauss_markov
from hijack_detect.simulation.plan import FlightPlan, forward_end_s, forward_start_s
from hijack_detect.simulation.route import Route, plan_route
from hijack_detect.streams.samples import (
    FixSample,
    ImuSample,
    MagneticSample,
    Quaternion,
    SatelliteSample,
    VelocitySample,
)

VERTICAL_GUSTS = 0.4
"""Deviation of the vertical gusts over that of the horizontal ones, near the ground. Chosen."""


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


@dataclass(frozen=True)
class Flight:
    """A simulated flight.

    Attributes:
        plan: The plan.
        conditions: What the seed made of it: vehicle, weather, sensors.
        route: The planned motion, 50 rows a second.
        motion: True motion, attitude, rates and forces, a hundred times a second.
        imu: IMU samples, 100 Hz.
        fixes: GPS fixes as reported, 5 Hz, stamped on arrival.
        measured_fixes: What an honest receiver would have reported, with the stamps of `fixes`.
        velocities: GPS velocities as reported, with the stamps of the fixes.
        satellites: Numbers of satellites as reported, with the stamps of the fixes.
        magnetics: Magnetometer samples, 10 Hz.
        pressures: Static pressure in pascal, 10 Hz.
        truth_fixes: True positions, 10 Hz.
        truth_attitudes: True attitudes (FLU to ENU) at the stamps of `truth_fixes`.
        forward_start_s: Start of the route, seconds from the start of the recording.
        forward_end_s: Start of braking, unless an attack made the target wait.
    """

    plan: FlightPlan
    conditions: Conditions
    route: Route
    motion: Motion
    imu: list[ImuSample]
    fixes: list[FixSample]
    measured_fixes: list[FixSample]
    velocities: list[VelocitySample]
    satellites: list[SatelliteSample]
    magnetics: list[MagneticSample]
    pressures: list[Reading]
    truth_fixes: list[FixSample]
    truth_attitudes: list[Quaternion]
    forward_start_s: float
    forward_end_s: float


def generate_flight(plan: FlightPlan, seed: int, receiver: Receiver | None = None) -> Flight:
    """Simulate a flight; the same plan, seed and receiver give the same flight.

    Conditions, route, wind and each sensor draw from generators of their own, so that a change
    to one leaves the others as they were, and a spoofed flight differs from the honest one of
    the same seed by nothing but the attack.

    Args:
        plan: What to fly.
        seed: A whole number, not negative.
        receiver: Stands between what is measured and what is reported; the autopilot sees
            nothing else of the GPS. None is an honest receiver.

    Raises:
        ValueError: The seed is negative.
    """
    if seed < 0:
        raise ValueError(f"seed is {seed}, it must not be negative")
    streams = [np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(8)]
    conditions = draw_conditions(plan, streams[0])
    route = plan_route(plan, conditions, streams[1])
    air = wind(plan, conditions, round(plan.duration_s * IMU_HZ) + 1, IMU_HZ, streams[2])
    gps = Gps(plan, conditions, receiver or HonestReceiver(), streams[3])
    motion = fly(route, conditions, air, gps)
    truth_fixes, truth_attitudes = sensors.truth(plan, motion)
    return Flight(
        plan=plan,
        conditions=conditions,
        route=route,
        motion=motion,
        imu=sensors.imu_samples(plan, conditions, motion, streams[4], streams[7]),
        fixes=gps.fixes,
        measured_fixes=gps.measured_fixes,
        velocities=gps.velocities,
        satellites=gps.satellites,
        magnetics=sensors.magnetic_samples(plan, motion, streams[5]),
        pressures=sensors.pressure_readings(plan, motion, streams[6]),
        truth_fixes=truth_fixes,
        truth_attitudes=truth_attitudes,
        forward_start_s=forward_start_s(plan),
        forward_end_s=forward_end_s(plan),
    )
