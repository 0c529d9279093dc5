# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A multirotor as an airspeed sensor: wind, drag and accelerometer bias from specific force.

    f = -(k + q |a|) a + b,    a = V - A w

in body x and y (`drag_model`): specific force f, velocity over ground V, wind w (East, North)
turned by A, and bias b, which is also what a tilted mounting of the sensor adds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hijack_detect.estimation.kalman import update
from hijack_detect.estimation.rotation import Array
from hijack_detect.parameters import param

SMALLEST_DRAG = 0.02
"""1/s; no filter believes less, where a wind would be infinite. Chosen, not swept."""


def drag_force(air: Array, drag: float, quadratic: float) -> tuple[Array, Array, Array]:
    """Specific force f (n, 2), m/s², and its derivatives (n, 2, 2) by the velocity and by (k, q).

    Args:
        air: Velocity through the air, body x and y, shape (n, 2), m/s.
        drag: k, 1/s.
        quadratic: q, 1/m.
    """
    speed = np.sqrt(np.sum(air**2, axis=1) + 1e-6)[:, None]
    resistance = drag + quadratic * speed
    by_air = -resistance[:, :, None] * np.eye(2) - quadratic * (
        air[:, :, None] * air[:, None, :] / speed[:, :, None]
    )
    return -resistance * air, by_air, np.stack([-air, -speed * air], axis=2)


HUBER = 2.0
"""Residuals beyond this many standard deviations count linearly: gusts and bad samples.
Chosen, not swept."""
MEMORY_S = 30.0
"""The residual is that of about this long. Chosen, not swept."""
CLIP = 4.0
"""One force counts as this many residuals at most. Chosen, not swept."""


FORCE = 0.08
"""m/s²: the residual is taken to be at least this. Chosen: the noise of a MEMS accelerometer
(400 µg/√Hz, MPU-6000) over 0.2 s is a tenth of it, so it stands for what is not white."""
FIRST_RESIDUAL = 0.25
"""m/s²: the residual before it is measured. Chosen: about half of what `drag` believes at most."""
FIRST_WIND = 6.0
"""m/s, standard deviation of the first wind along each axis. Chosen: 95 % of winds are then below
2.45 times as much (Rayleigh), 15 m/s, and small multirotors are rated for 10 to 12 m/s."""
DRAG_WALK = 0.002
"""1/s/√s, random walk of k. Chosen: 0.05 in ten minutes, less than it differs between vehicles."""
BIAS_WALK = 0.005
"""m/s²/√s, random walk of the bias. 0.003 to 0.01 fit the accelerometers of 11 of 13 recorded
flights best, see `accel_bias_walk` of coast."""


def first_drag() -> Any:
    """Declare the drag k of a vehicle that is not learnt yet."""
    return param(
        0.25,
        "Drag k of the vehicle before it is learnt: specific force per airspeed. Quadrotors have "
        "0.15 to 0.35.",
        source="measured: the middle of recorded quadrotors",
        basic=True,
        unit="1/s",
        low=0.02,
        high=2.0,
    )


def first_drag_sigma() -> Any:
    """Declare how well `first_drag` is known."""
    return param(
        0.08,
        "Standard deviation of `drag`. Lower it for a vehicle that was measured.",
        source="chosen, not swept: wider than the scatter of recorded quadrotors",
        basic=True,
        unit="1/s",
        low=0.001,
        high=2.0,
    )


def first_quadratic_sigma(default: float) -> Any:
    """Declare the standard deviation of the drag q, whose mean is 0."""
    return param(
        default,
        "Standard deviation of the drag q that grows with airspeed, which most quadrotors lack.",
        source="chosen, not swept",
        unit="1/m",
        low=0.0001,
        high=1.0,
    )


@dataclass(frozen=True)
class DragNoise:
    """What a filter assumes of wind and vehicle.

    Attributes:
        correlation_s: How long a gust keeps the force away from the model, s.
        drag: Mean and deviation of the first k, 1/s.
        quadratic_sigma: Deviation of the first q, whose mean is 0, 1/m.
        bias: Deviation of the first bias, m/s².
        wind_walk: Random walk of the wind, m/s/√s.
    """

    correlation_s: float
    drag: tuple[float, float]
    quadratic_sigma: float
    bias: float
    wind_walk: float

    @property
    def sigmas(self) -> tuple[float, ...]:
        """First standard deviations of wind (2), k, q and bias (2)."""
        return (FIRST_WIND, FIRST_WIND, self.drag[1], self.quadratic_sigma, self.bias, self.bias)

    @property
    def walks(self) -> tuple[float, ...]:
        """Random walks of wind (2), k, q and bias (2)."""
        wind = self.wind_walk
        return (wind, wind, DRAG_WALK, 0.0, BIAS_WALK, BIAS_WALK)

    def variance(self, residual: float, seconds: float) -> float:
        """Variance of the force of a block, of which this many follow within one gust."""
        return max(FORCE, residual) ** 2 * max(1.0, 2.0 * self.correlation_s / seconds)


class ForceNoise:
    """Variance of the force about the model, learnt while it is used."""

    def __init__(self, noise: DragNoise) -> None:
        """Start with the first residual."""
        self._noise = noise
        self.residual = FIRST_RESIDUAL
        """Root mean square of what is left of the force, m/s²."""

    def variance(self, spread: Array, innovation: Array, seconds: float) -> float:
        """Variance for one measurement, larger for an outlier; what is left of it is learnt.

        Args:
            spread: Covariance of the expected force, (m/s²)², shape (2, 2).
            innovation: Measured minus expected, m/s², shape (2,).
            seconds: Length of the interval that the force is the mean of.
        """
        r, eye = self._noise.variance(self.residual, seconds), np.eye(2)
        size = math.sqrt(0.5 * float(innovation @ np.linalg.solve(spread + r * eye, innovation)))
        r *= max(1.0, size / HUBER)
        left = r * np.linalg.solve(spread + r * eye, innovation)
        square = min(0.5 * float(left @ left), (CLIP * self.residual) ** 2)
        memory = min(1.0, seconds / MEMORY_S)
        self.residual = math.sqrt(self.residual**2 + memory * (square - self.residual**2))
        return r


WIND, DRAG, QUADRATIC, BIAS = slice(0, 2), 2, 3, slice(4, 6)
"""Where the state holds what."""
ITERATIONS = 3
"""Of the update about its own solution. Chosen, not swept."""


@dataclass(frozen=True, slots=True)
class AirBlock:
    """Means over some tenths of a second.

    Attributes:
        stamp_ns: Stamp of the newest GPS velocity in it.
        seconds: How long it is.
        turn: A, shape (2, 2), from East and North to body x and y.
        velocity: V, shape (2,), m/s over ground in body x and y.
        force: f, shape (2,), m/s² in body x and y.
    """

    stamp_ns: int
    seconds: float
    turn: Array
    velocity: Array
    force: Array


@dataclass(frozen=True, slots=True)
class WindChange:
    """By how much the wind must have changed for the GPS velocity to be true.

    Attributes:
        change: East and North, m/s.
        covariance: Of `change`, (m/s)²; as large as the prior where the flight does not show it.
    """

    change: Array
    covariance: Array

    @property
    def size(self) -> float:
        """m/s."""
        return math.hypot(*self.change.tolist())

    @property
    def sigma(self) -> float:
        """Standard deviation along the direction that is known worst, m/s."""
        return math.sqrt(float(np.linalg.eigvalsh(self.covariance)[-1]))

    @property
    def sigma_along(self) -> float:
        """Standard deviation along the change itself, m/s; the largest where there is none."""
        size = self.size
        if size == 0.0:
            return self.sigma
        unit = self.change / size
        return math.sqrt(float(unit @ self.covariance @ unit))


class DragFilter:
    """Extended Kalman filter on wind (East, North), k, q and bias (x, y).

    Attributes:
        state: Shape (6,).
        covariance: Shape (6, 6).
    """

    def __init__(self, noise: DragNoise) -> None:
        """Start with what is known of any multirotor."""
        self._noise = n = noise
        self.state: Array = np.array([0.0, 0.0, n.drag[0], 0.0, 0.0, 0.0])
        self.covariance: Array = np.diag(np.square(n.sigmas))
        self._force = ForceNoise(n)
        self._walk = np.diag(np.square(n.walks))

    def figures(self) -> dict[str, float]:
        """Wind, drag and bias by name, as a verdict has them."""
        east, north = self.state[WIND].tolist()
        bias_x, bias_y = self.state[BIAS].tolist()
        return {
            "wind_speed": self.wind_speed,
            "wind_east": east,
            "wind_north": north,
            "drag": float(self.state[DRAG]),
            "bias_x": bias_x,
            "bias_y": bias_y,
        }

    def copy(self) -> DragFilter:
        """A filter that goes on from here by itself."""
        other = DragFilter(self._noise)
        other.state, other.covariance = self.state, self.covariance
        other._force.residual = self.residual
        return other

    @property
    def residual(self) -> float:
        """Root mean square of the force about the model, see ForceNoise, m/s²."""
        return self._force.residual

    @property
    def wind_speed(self) -> float:
        """m/s."""
        return math.hypot(*self.state[WIND].tolist())

    @property
    def drag_sigma(self) -> float:
        """Standard deviation of k, 1/s."""
        return math.sqrt(float(self.covariance[DRAG, DRAG]))

    def forget_wind(self) -> None:
        """Another flight: the wind may be any, the vehicle is the same."""
        self.state = self.state.copy()
        self.state[WIND] = 0.0
        self.covariance = self.covariance.copy()
        self.covariance[WIND] = self.covariance[:, WIND] = 0.0
        self.covariance[0, 0] = self.covariance[1, 1] = FIRST_WIND**2

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.covariance = self.covariance + self._walk * seconds

    def update(self, block: AirBlock) -> None:
        """Use one block."""
        residual, h = _linearized(
            self.state, block.turn[None], block.velocity[None], block.force[None]
        )
        spread = h[0] @ self.covariance @ h[0].T
        variance = self._force.variance(spread, residual[0], block.seconds)
        found, self.covariance = update(self.covariance, h[0], residual[0], np.full(2, variance))
        self.state = self.state + found.correction
        self.state[DRAG] = max(float(self.state[DRAG]), SMALLEST_DRAG)

    def wind_change(self, blocks: Sequence[AirBlock], prior: float) -> WindChange:
        """The change of wind between this filter and later blocks, drag and bias kept.

        A least-squares fit of the wind before, the change, k, q and bias to the blocks, with this
        filter's state as prior knowledge: what wind and bias are known to have in common is used,
        and shows in the covariance where it is not enough.

        Args:
            blocks: At least one.
            prior: Standard deviation of a change, m/s.
        """
        turn = np.array([block.turn for block in blocks])
        velocity = np.array([block.velocity for block in blocks])
        force = np.array([block.force for block in blocks])
        seconds = math.fsum(block.seconds for block in blocks) / len(blocks)
        r = self._noise.variance(self.residual, seconds)
        known = np.zeros((8, 8))
        known[:6, :6] = np.linalg.inv(self.covariance)
        known[6, 6] = known[7, 7] = prior**-2
        first = np.concatenate([self.state, [0.0, 0.0]])
        x = first
        for _ in range(ITERATIONS):
            now = x[:6].copy()
            now[WIND] += x[6:]
            now[DRAG] = max(float(now[DRAG]), SMALLEST_DRAG)
            residual, h6 = _linearized(now, turn, velocity, force)
            h = np.concatenate([h6, h6[:, :, WIND]], axis=2)
            scale = max(self.residual, FORCE)
            sizes = np.sqrt(0.5 * np.sum(residual**2, axis=1)) / scale
            weight = np.minimum(1.0, HUBER / np.maximum(sizes, 1e-9)) / r
            information = known + np.einsum("n,nij,nik->jk", weight, h, h)
            target = residual + h @ x
            right = known @ first + np.einsum("n,nij,ni->j", weight, h, target)
            x = np.linalg.solve(information, right)
        return WindChange(x[6:], np.linalg.inv(information)[6:, 6:])


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A copy of the filter at a stamp, ns."""

    stamp_ns: int
    filter: DragFilter


def _linearized(state: Array, turn: Array, velocity: Array, force: Array) -> tuple[Array, Array]:
    """Residuals (n, 2) of the model and its derivative (n, 2, 6) by the state."""
    air = velocity - turn @ state[WIND]
    expected, by_air, by_drag = drag_force(air, float(state[DRAG]), float(state[QUADRATIC]))
    residual = force - (expected + state[BIAS])
    h = np.empty((len(air), 2, 6))
    h[:, :, WIND] = -by_air @ turn
    h[:, :, DRAG : QUADRATIC + 1] = by_drag
    h[:, :, BIAS] = np.eye(2)
    return residual, h
