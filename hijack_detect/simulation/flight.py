"""One simulated flight: the truth and what the sensors say of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hijack_detect.simulation import sensors
from hijack_detect.simulation.kinematics import Kinematics, kinematics
from hijack_detect.simulation.motion import Motion, motion
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.simulation.sensors import Reading
from hijack_detect.streams.samples import (
    FixSample,
    ImuSample,
    MagneticSample,
    Quaternion,
    VelocitySample,
)


@dataclass(frozen=True)
class Flight:
    """A simulated flight.

    Attributes:
        plan: What was asked for.
        path: True motion, a thousand times a second.
        motion: True motion, attitude, rates and forces, a hundred times a second.
        imu: IMU samples, 100 Hz.
        fixes: GPS fixes, 5 Hz, stamped on arrival.
        velocities: GPS velocities, with the stamps of the fixes.
        satellites: Numbers of satellites, with the stamps of the fixes.
        magnetics: Magnetometer samples, 10 Hz.
        pressures: Static pressure in pascal, 10 Hz.
        truth_fixes: True positions, 10 Hz.
        truth_attitudes: True attitudes (FLU to ENU) at the stamps of `truth_fixes`.
    """

    plan: FlightPlan
    path: Kinematics
    motion: Motion
    imu: list[ImuSample]
    fixes: list[FixSample]
    velocities: list[VelocitySample]
    satellites: list[Reading]
    magnetics: list[MagneticSample]
    pressures: list[Reading]
    truth_fixes: list[FixSample]
    truth_attitudes: list[Quaternion]


def generate_flight(plan: FlightPlan, seed: int) -> Flight:
    """Simulate a flight; the same plan and seed give the same flight.

    Motion and each sensor draw from generators of their own, so that a change to one sensor
    leaves the others as they were.

    Args:
        plan: What to fly.
        seed: A whole number, not negative.

    Raises:
        ValueError: The seed is negative.
    """
    if seed < 0:
        raise ValueError(f"seed is {seed}, it must not be negative")
    streams = [np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(5)]
    path = kinematics(plan, streams[0])
    moved = motion(path)
    fixes, velocities, satellites = sensors.gps_samples(plan, path, streams[2])
    truth_fixes, truth_attitudes = sensors.truth(plan, moved)
    return Flight(
        plan=plan,
        path=path,
        motion=moved,
        imu=sensors.imu_samples(plan, moved, streams[1]),
        fixes=fixes,
        velocities=velocities,
        satellites=satellites,
        magnetics=sensors.magnetic_samples(plan, moved, streams[3]),
        pressures=sensors.pressure_readings(plan, moved, streams[4]),
        truth_fixes=truth_fixes,
        truth_attitudes=truth_attitudes,
    )
