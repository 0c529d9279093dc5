"""What real sensors would say of a motion: bias, noise, vibration, lag and resolution.

Every output is rounded to the resolution of a common part. So a bag made on another processor,
whose sine differs in the last bit, is still the same bag.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pymap3d

from hijack_detect.estimation.rotation import matrices
from hijack_detect.simulation.kinematics import RATE_HZ, Array, Kinematics
from hijack_detect.simulation.motion import IMU_HZ, Motion
from hijack_detect.simulation.plan import FlightPlan, Place
from hijack_detect.streams.samples import (
    FixSample,
    ImuSample,
    MagneticSample,
    Quaternion,
    Vector3,
    VelocitySample,
)

GPS_HZ = 5
GPS_LAG_S = 0.15
"""A fix is stamped on arrival and tells where the vehicle was this long before."""
SLOW_HZ = 10
"""Rate of magnetometer, barometer and truth."""
GPS_PHASE_S = 0.163
"""Arrival of the first fix: the receiver's clock is not the IMU's."""


class Reading(NamedTuple):
    """A value with its stamp in nanoseconds: pascal, or a number of satellites."""

    stamp_ns: int
    value: float


def imu_samples(plan: FlightPlan, motion: Motion, rng: np.random.Generator) -> list[ImuSample]:
    """Bias of about 0.3 °/s and 0.1 m/s², white noise, and vibration of the motors in flight."""
    size = (len(motion.offsets_ns), 3)
    flying = motion.airborne[:, None]
    time = motion.offsets_ns[:, None] / 1e9
    phase = rng.uniform(-np.pi, np.pi, (2, 3))
    gyro = motion.angular_velocity + rng.normal(0.0, np.radians(0.3), 3)
    gyro = gyro + (0.001 + 0.007 * flying) * rng.normal(size=size)
    gyro = gyro + 0.006 * flying * np.sin(2.0 * np.pi * 19.3 * time + phase[0])
    force = motion.specific_force + rng.normal(0.0, 0.1, 3)
    force = force + (0.02 + 0.09 * flying) * rng.normal(size=size)
    force = force + 0.12 * flying * np.sin(2.0 * np.pi * 21.7 * time + phase[1])
    return [
        ImuSample(stamp, rate, felt)
        for stamp, rate, felt in zip(
            _stamps(plan, motion.offsets_ns),
            _vectors(_rounded(gyro, 2000)),
            _vectors(_rounded(force, 400)),
            strict=True,
        )
    ]


def gps_samples(
    plan: FlightPlan, path: Kinematics, rng: np.random.Generator
) -> tuple[list[FixSample], list[VelocitySample], list[Reading]]:
    """Fixes, velocities and numbers of satellites, five times a second, all with the same lag.

    Position: correlated noise of 0.5 m (0.8 m up) over 60 s and white noise of 0.03 m.
    Velocity: white noise of 0.08 m/s.
    """
    arrival = np.arange(GPS_PHASE_S, path.time_s[-1], 1.0 / GPS_HZ)
    measured = np.round((arrival - GPS_LAG_S) * RATE_HZ).astype(np.int64)
    stamps = _stamps(plan, np.round(arrival * 1e3).astype(np.int64) * 1_000_000)
    size = (len(arrival), 3)
    noise = _correlated(rng.normal(size=size), 60.0) * np.array([0.5, 0.5, 0.8])
    position = path.position[measured] + noise + 0.03 * rng.normal(size=size)
    velocity = path.velocity[measured] + 0.08 * rng.normal(size=size)
    satellites = np.round(13.0 + 1.2 * _correlated(rng.normal(size=size), 20.0)[:, 0])
    fixes = [
        FixSample(stamp, *place)
        for stamp, place in zip(
            stamps, _geodetic(plan.place, position, 10_000_000, 1000), strict=True
        )
    ]
    velocities = [
        VelocitySample(stamp, vector)
        for stamp, vector in zip(stamps, _vectors(_rounded(velocity, 1000)), strict=True)
    ]
    return fixes, velocities, [Reading(*pair) for pair in zip(stamps, satellites, strict=True)]


def magnetic_samples(
    plan: FlightPlan, motion: Motion, rng: np.random.Generator
) -> list[MagneticSample]:
    """The field of the place in body axes: hard iron of about 0.5 µT, noise of 0.3 µT."""
    step = IMU_HZ // SLOW_HZ
    field = np.array(plan.place.field_enu_t) @ matrices(motion.quaternion[::step])
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
    drift = _correlated(rng.normal(size=(len(altitude), 1)), 100.0, SLOW_HZ)[:, 0]
    pascal = 101_325.0 * (1.0 - 2.25577e-5 * altitude) ** 5.25588
    pascal = pascal + 5.0 * drift + 2.0 * rng.normal(size=len(altitude))
    stamps = _stamps(plan, motion.offsets_ns[::step])
    return [Reading(*pair) for pair in zip(stamps, _rounded(pascal, 2).tolist(), strict=True)]


def truth(plan: FlightPlan, motion: Motion) -> tuple[list[FixSample], list[Quaternion]]:
    """True position and attitude (FLU to ENU) at the same ten stamps a second."""
    step = IMU_HZ // SLOW_HZ
    stamps = _stamps(plan, motion.offsets_ns[::step])
    places = _geodetic(plan.place, motion.position[::step], 1_000_000_000, 10_000)
    fixes = [FixSample(stamp, *place) for stamp, place in zip(stamps, places, strict=True)]
    rows = _rounded(motion.quaternion[::step], 100_000_000).tolist()
    return fixes, [(x, y, z, w) for x, y, z, w in rows]


def _correlated(white: Array, time_constant_s: float, rate_hz: float = GPS_HZ) -> Array:
    """Turn unit white noise (n, m) into a Gauss-Markov process of unit deviation."""
    keep = float(np.exp(-1.0 / (time_constant_s * rate_hz)))
    out = white.copy()
    for index in range(1, len(out)):
        out[index] = keep * out[index - 1] + np.sqrt(1.0 - keep * keep) * white[index]
    return out


def _geodetic(place: Place, position: Array, per_degree: int, per_metre: int) -> list[Vector3]:
    latitude, longitude, altitude = pymap3d.enu2geodetic(
        *position.T, place.latitude_deg, place.longitude_deg, place.altitude_m
    )
    columns = [
        _rounded(latitude, per_degree),
        _rounded(longitude, per_degree),
        _rounded(altitude, per_metre),
    ]
    return _vectors(np.stack(columns, axis=1))


def _rounded(values: Array, steps_per_unit: int) -> Array:
    """Return the values in whole steps, without negative zeros."""
    rounded: Array = np.round(values * steps_per_unit) / steps_per_unit + 0.0
    return rounded


def _vectors(rows: Array) -> list[Vector3]:
    return [(x, y, z) for x, y, z in rows.tolist()]


def _stamps(plan: FlightPlan, offsets_ns: npt.NDArray[np.int64]) -> list[int]:
    return [plan.start_ns + offset for offset in offsets_ns.tolist()]
