# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What differs from flight to flight: the vehicle, the weather and the sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hijack_detect.simulation.plan import FlightPlan


@dataclass(frozen=True)
class Conditions:
    """One draw of everything that a plan leaves open, so that seeds make a population.

    Attributes:
        speed: Ground speed on the route, m/s.
        first_course: Radians counter-clockwise from East.
        first_yaw: Heading on the ground, radians counter-clockwise from East.
        wind_m_s: Mean wind, m/s.
        wind_direction: Where the air moves to, radians counter-clockwise from East.
        gust_m_s: Standard deviation of the horizontal gusts along each axis, m/s.
        gust_s: Time constant of the gusts, seconds.
        drag: Linear rotor drag over mass, 1/s.
        drag_quadratic: Quadratic drag over mass, 1/m.
        compass_error: Constant heading error of the autopilot, radians.
        accelerometer_error: Constant error of the acceleration that the autopilot integrates,
            m/s² in ENU: what its accelerometer bias and its tilt error of about 0.4° leave.
        gps_lag_s: How long before its stamp a fix was true, seconds.
        fix_noise_m: Deviation of the correlated noise of a fix, East and North each, metres;
            1.5 times as much up.
        fix_noise_s: Time constant of that noise, seconds.
        fix_white_m: White noise of a fix, metres.
        velocity_noise_m_s: White noise of the GPS velocity, m/s.
        satellites: Mean number of satellites.
        imu_noise: White noise of the IMU in units of the usual one.
        vibration: Amplitude of the vibration in units of the usual one.
        bias_wander: In-flight wander of the IMU's bias in units of the usual one.
    """

    speed: float
    first_course: float
    first_yaw: float
    wind_m_s: float
    wind_direction: float
    gust_m_s: float
    gust_s: float
    drag: float
    drag_quadratic: float
    compass_error: float
    accelerometer_error: tuple[float, float, float]
    gps_lag_s: float
    fix_noise_m: float
    fix_noise_s: float
    fix_white_m: float
    velocity_noise_m_s: float
    satellites: float
    imu_noise: float
    vibration: float
    bias_wander: float


def draw_conditions(plan: FlightPlan, rng: np.random.Generator) -> Conditions:
    """Draw the conditions of a flight; values of the plan replace drawn ones.

    The ranges are those of recorded small multirotors: drag of 0.21 to 0.30 1/s with little
    quadratic part, a GPS lag that differs from vehicle to vehicle, gusts of 5 to 20 % of the
    wind.
    """
    speed = _asked(plan.speed, rng.uniform(6.0, 9.0))
    wind = _asked(plan.wind_m_s, rng.uniform(0.0, 5.0))
    course = rng.uniform(-np.pi, np.pi)
    east, north, up = rng.normal(0.0, 0.07, 3).tolist()
    return Conditions(
        speed=speed,
        first_course=course,
        first_yaw=course + rng.uniform(0.5, 1.5) * float(rng.choice([-1.0, 1.0])),
        wind_m_s=wind,
        wind_direction=rng.uniform(-np.pi, np.pi),
        gust_m_s=_asked(plan.disturbances.turbulence_m_s, rng.uniform(0.05, 0.2) * wind),
        gust_s=rng.uniform(3.0, 10.0),
        drag=rng.uniform(0.21, 0.30),
        drag_quadratic=rng.uniform(0.0, 0.01),
        compass_error=rng.normal(0.0, np.radians(1.5)),
        accelerometer_error=(east, north, up),
        gps_lag_s=rng.uniform(0.1, 0.2),
        fix_noise_m=rng.uniform(0.3, 0.6),
        fix_noise_s=rng.uniform(40.0, 100.0),
        fix_white_m=rng.uniform(0.02, 0.05),
        velocity_noise_m_s=rng.uniform(0.05, 0.11),
        satellites=rng.uniform(9.0, 17.0),
        imu_noise=rng.uniform(0.6, 1.4),
        vibration=rng.uniform(0.5, 1.5),
        bias_wander=rng.uniform(0.5, 1.5),
    )


def _asked(asked: float | None, drawn: float) -> float:
    """The value of the plan, or else the drawn one."""
    return drawn if asked is None else asked
