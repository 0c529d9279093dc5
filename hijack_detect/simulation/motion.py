# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The true motion of a flight, and the loop that makes it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hijack_detect.simulation.autopilot import Autopilot, Command
from hijack_detect.simulation.conditions import Conditions
from hijack_detect.simulation.gps import Gps
from hijack_detect.simulation.navigation import Navigation
from hijack_detect.simulation.noise import Array
from hijack_detect.simulation.plan import GROUND_S
from hijack_detect.simulation.route import RATE_HZ, Route
from hijack_detect.simulation.vehicle import Multirotor
from hijack_detect.streams.samples import Vector3

IMU_HZ = 100
"""Chosen: the rate of companion links; Feng 2018, section 5, has 50 Hz."""
STEPS = 2
"""Steps of the dynamics for each IMU sample. Chosen; Heun's method keeps energy to twelve digits
(docs/simulator.md)."""


@dataclass(frozen=True)
class Motion:
    """Truth at the rate of the IMU; vectors of shape (n, 3).

    Attributes:
        offsets_ns: Time from the start, nanoseconds.
        position: Metres in ENU.
        velocity: m/s in ENU.
        acceleration: m/s² in ENU.
        quaternion: (x, y, z, w), turns FLU into ENU, shape (n, 4).
        angular_velocity: rad/s in FLU: the constant rate that turns the attitude of the sample
            before into this one, so that q[k] = q[k-1] exp(angular_velocity[k] / IMU_HZ).
        specific_force: m/s² in FLU: Rᵀ (acceleration - gravity).
        airborne: 0 on the ground, 1 in flight, shape (n,).
        target: The point of the route that the autopilot steers for, metres in ENU.
        wind: m/s in ENU, where the air moves to.
    """

    offsets_ns: npt.NDArray[np.int64]
    position: Array
    velocity: Array
    acceleration: Array
    quaternion: Array
    angular_velocity: Array
    specific_force: Array
    airborne: Array
    target: Array
    wind: Array


def fly(route: Route, conditions: Conditions, air: Array, gps: Gps) -> Motion:
    """Fly a route in closed loop: the vehicle obeys the autopilot, and the autopilot its GPS.

    Args:
        route: The planned motion.
        conditions: Vehicle and sensors.
        air: Wind at the rate of the IMU, m/s in ENU, shape (n, 3); as long as the flight.
        gps: Receives the true state of its own time, returns the reported one.
    """
    autopilot = Autopilot(route, conditions.compass_error)
    navigation = Navigation(1.0 / RATE_HZ)
    first_yaw = float(route.yaw[0])
    level = (0.0, 0.0, float(np.sin(first_yaw / 2.0)), float(np.cos(first_yaw / 2.0)))
    vehicle = Multirotor(conditions.drag, conditions.drag_quadratic, level)
    command = Command(0.0, level)
    drift = [error / RATE_HZ for error in conditions.accelerometer_error]
    beliefs: list[tuple[Vector3, Vector3]] = []
    rows = []
    every, step_s = IMU_HZ // RATE_HZ, 1.0 / (IMU_HZ * STEPS)
    felt = vehicle.velocity
    for index, wind in enumerate(zip(*air.T.tolist(), strict=True)):
        if index % every == 0:
            now_s = index / IMU_HZ
            beliefs.append((vehicle.position, vehicle.velocity))
            x, y, z = (
                new - old + off for new, old, off in zip(vehicle.velocity, felt, drift, strict=True)
            )
            felt = vehicle.velocity
            navigation.predict((x, y, z))
            if gps.arrived(now_s):
                reported = gps.report(*_between(beliefs, gps.measured_s * RATE_HZ))
                navigation.correct(*reported, vehicle.position[2], now_s)
            elif gps.missed(now_s):
                navigation.miss(vehicle.position[2], now_s)
            wanted = autopilot.command(
                navigation.position, navigation.velocity, flying=not vehicle.on_ground
            )
            if now_s >= GROUND_S:
                command = wanted
        rows.append(
            (
                *vehicle.position,
                *vehicle.velocity,
                *vehicle.acceleration,
                *vehicle.attitude,
                *vehicle.specific_force,
                *autopilot.target,
                0.0 if vehicle.on_ground else 1.0,
            )
        )
        for _ in range(STEPS):
            vehicle.step(command.thrust, command.attitude, wind, step_s)
    table = np.array(rows)
    return Motion(
        offsets_ns=np.arange(len(table), dtype=np.int64) * (1_000_000_000 // IMU_HZ),
        position=table[:, 0:3],
        velocity=table[:, 3:6],
        acceleration=table[:, 6:9],
        quaternion=table[:, 9:13],
        angular_velocity=body_rates(table[:, 9:13], 1.0 / IMU_HZ),
        specific_force=table[:, 13:16],
        airborne=table[:, 19],
        target=table[:, 16:19],
        wind=air,
    )


def body_rates(quaternion: Array, step_s: float) -> Array:
    """Return the constant body rate (rad/s) from each attitude to the next; the first is zero.

    Args:
        quaternion: Unit quaternions (x, y, z, w), shape (n, 4).
        step_s: Time between two of them, seconds.

    Returns:
        Rates in FLU, shape (n, 3).
    """
    x0, y0, z0, w0 = quaternion[:-1].T
    x1, y1, z1, w1 = quaternion[1:].T
    vector = np.stack(
        [
            w0 * x1 - x0 * w1 - y0 * z1 + z0 * y1,
            w0 * y1 + x0 * z1 - y0 * w1 - z0 * x1,
            w0 * z1 - x0 * y1 + y0 * x1 - z0 * w1,
        ],
        axis=1,
    )
    sine = np.linalg.norm(vector, axis=1)
    cosine = w0 * w1 + x0 * x1 + y0 * y1 + z0 * z1
    angle = 2.0 * np.arctan2(sine, cosine)
    scale = np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 2.0)
    return np.concatenate([np.zeros((1, 3)), scale[:, None] * vector / step_s])


def _between(states: list[tuple[Vector3, Vector3]], place: float) -> tuple[Vector3, Vector3]:
    """Interpolate position and velocity between two of the states, `place` counted in steps."""
    row = max(int(place), 0)
    part = max(place - row, 0.0)
    (p0, v0), (p1, v1) = states[row], states[min(row + 1, len(states) - 1)]
    return _mixed(p0, p1, part), _mixed(v0, v1, part)


def _mixed(a: Vector3, b: Vector3, part: float) -> Vector3:
    return (
        a[0] + part * (b[0] - a[0]),
        a[1] + part * (b[1] - a[1]),
        a[2] + part * (b[2] - a[2]),
    )
