# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The sensors other than GPS: bias, noise, vibration and resolution.

Every output is rounded to the resolution of a common part. So a bag made on another processor,
whose sine differs in the last bit, is still the same bag.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hijack_detect.estimation.rotation import matrices
from hijack_detect.simulation.conditions import Conditions
from hijack_detect.simulation.disturbances import Vibration
from hijack_detect.simulation.gps import Reading, geodetic
from hijack_detect.simulation.motion import IMU_HZ, Motion
from hijack_detect.simulation.noise import Array, gauss_markov, random_walk
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.streams.samples import (
    FixSample,
    ImuSample,
    MagneticSample,
    Quaternion,
    Vector3,
)

ROTORS = 4
REGULATED_S = 1.0
"""Time constant of the wander of a rotor's speed, seconds. Chosen, not swept."""
GYRO_PER_FORCE = 0.05
"""rad/s of the gyroscope per m/s² of the accelerometer, as in the usual vibration. Chosen."""


def shaking(
    vibration: Vibration, count: int, rate_hz: float, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Angular velocity (rad/s) and specific force (m/s²) that the vibration adds, each (count, 3).

    The rms of the force is that of the vibration on each axis, in the mean over frequencies.

    Args:
        vibration: How strong and how fast.
        count: Number of samples.
        rate_hz: Samples a second.
        rng: Draws amplitudes, phases and the wandering of the rotors.
    """
    wander = gauss_markov(rng.normal(size=(count, ROTORS)), REGULATED_S, rate_hz)
    hertz = vibration.rotor_hz + vibration.wander_hz * wander
    turned = 2.0 * np.pi * np.cumsum(hertz, axis=0) / rate_hz
    rate, force = (
        np.sqrt(2.0)
        * np.einsum(
            "nij,ij->nj",
            np.sin(turned[:, :, None] + rng.uniform(-np.pi, np.pi, (ROTORS, 3))),
            _shares(rng),
        )
        for _ in range(2)
    )
    return (GYRO_PER_FORCE * vibration.force_rms) * rate, vibration.force_rms * force


def _shares(rng: np.random.Generator) -> Array:
    """Amplitudes of the rotors on each axis, (ROTORS, 3); the squares of an axis sum to one."""
    drawn = rng.uniform(0.3, 1.0, (ROTORS, 3))
    shares: Array = drawn / np.linalg.norm(drawn, axis=0)
    return shares


SLOW_HZ = 10
"""Rate of magnetometer, barometer and truth."""
GYRO_BIAS = np.radians(0.3)
"""rad/s. Chosen, as the three below: a MEMS IMU of a small autopilot after its calibration."""
ACCELEROMETER_BIAS = 0.1
"""m/s²"""
GYRO_WANDER = np.radians(0.006)
"""Random walk of the gyro bias in flight, rad/s after one second: 0.06 °/s after 100 s."""
ACCELEROMETER_WANDER = 0.002
"""Random walk of the accelerometer bias in flight, m/s² after one second."""


def imu_samples(
    plan: FlightPlan,
    conditions: Conditions,
    motion: Motion,
    rng: np.random.Generator,
    strong: np.random.Generator,
) -> list[ImuSample]:
    """Bias that wanders in flight, white noise, and vibration of the motors.

    `strong` draws the strong vibration alone, if the plan has one.
    """
    size = (len(motion.offsets_ns), 3)
    flying = motion.airborne[:, None]
    time = motion.offsets_ns[:, None] / 1e9
    phase = rng.uniform(-np.pi, np.pi, (2, 3))
    hertz = rng.uniform(17.0, 23.0, 2)
    white, wander = conditions.imu_noise, conditions.bias_wander
    vibration = plan.disturbances.vibration
    if vibration is not None:
        white *= vibration.white
    shake = conditions.vibration * flying * np.sin(2.0 * np.pi * hertz[0] * time + phase[0])
    jolt = conditions.vibration * flying * np.sin(2.0 * np.pi * hertz[1] * time + phase[1])
    gyro = motion.angular_velocity + rng.normal(0.0, GYRO_BIAS, 3)
    gyro = gyro + random_walk(flying * rng.normal(size=size), wander * GYRO_WANDER, IMU_HZ)
    gyro = gyro + white * (0.001 + 0.007 * flying) * rng.normal(size=size) + 0.006 * shake
    force = motion.specific_force + rng.normal(0.0, ACCELEROMETER_BIAS, 3)
    walk = flying * rng.normal(size=size)
    force = force + random_walk(walk, wander * ACCELEROMETER_WANDER, IMU_HZ)
    force = force + white * (0.02 + 0.09 * flying) * rng.normal(size=size) + 0.12 * jolt
    if vibration is not None:
        turned, pushed = shaking(vibration, size[0], IMU_HZ, strong)
        gyro, force = gyro + flying * turned, force + flying * pushed
    return [
        ImuSample(stamp, rate, felt)
        for stamp, rate, felt in zip(
            _stamps(plan, motion.offsets_ns),
            _vectors(_rounded(gyro, 2000)),
            _vectors(_rounded(force, 400)),
            strict=True,
        )
    ]


def magnetic_samples(
    plan: FlightPlan, motion: Motion, rng: np.random.Generator
) -> list[MagneticSample]:
    """The field around the vehicle in body axes: hard iron of about 0.5 µT, noise of 0.3 µT."""
    step = IMU_HZ // SLOW_HZ
    around = plan.disturbances.field(motion.offsets_ns[::step] / 1e9)
    turned = matrices(motion.quaternion[::step])
    field = np.array(plan.place.field_enu_t) @ turned
    field = field + np.einsum("ni,nij->nj", around, turned)
    field = field + rng.normal(0.0, 0.5e-6, 3) + rng.normal(0.0, 0.3e-6, field.shape)
    return [
        MagneticSample(stamp, vector)
        for stamp, vector in zip(
            _stamps(plan, motion.offsets_ns[::step]),
            _vectors(_rounded(field, 8_000_000)),
            strict=True,
        )
    ]


def pressure_readings(plan: FlightPlan, motion: Motion, rng: np.random.Generator) -> list[Reading]:
    """Static pressure of the standard atmosphere, pascal: drift of 5 Pa, noise of 2 Pa."""
    step = IMU_HZ // SLOW_HZ
    altitude = plan.place.altitude_m + motion.position[::step, 2]
    drift = gauss_markov(rng.normal(size=(len(altitude), 1)), 100.0, SLOW_HZ)[:, 0]
    pascal = 101_325.0 * (1.0 - 2.25577e-5 * altitude) ** 5.25588
    pascal = pascal + 5.0 * drift + 2.0 * rng.normal(size=len(altitude))
    stamps = _stamps(plan, motion.offsets_ns[::step])
    return [Reading(*pair) for pair in zip(stamps, _rounded(pascal, 2).tolist(), strict=True)]


def truth(plan: FlightPlan, motion: Motion) -> tuple[list[FixSample], list[Quaternion]]:
    """True position and attitude (FLU to ENU) at the same ten stamps a second."""
    step = IMU_HZ // SLOW_HZ
    stamps = _stamps(plan, motion.offsets_ns[::step])
    places = geodetic(plan, motion.position[::step])
    fixes = [FixSample(stamp, *place) for stamp, place in zip(stamps, places, strict=True)]
    rows = _rounded(motion.quaternion[::step], 100_000_000).tolist()
    return fixes, [(x, y, z, w) for x, y, z, w in rows]


def _rounded(values: Array, steps_per_unit: int) -> Array:
    """Return the values in whole steps, without negative zeros."""
    rounded: Array = np.round(values * steps_per_unit) / steps_per_unit + 0.0
    return rounded


def _vectors(rows: Array) -> list[Vector3]:
    return [(x, y, z) for x, y, z in rows.tolist()]


def _stamps(plan: FlightPlan, offsets_ns: npt.NDArray[np.int64]) -> list[int]:
    return [plan.start_ns + offset for offset in offsets_ns.tolist()]
