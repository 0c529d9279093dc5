# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the attitude estimator."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.silence import sensor_patience


@dataclass(frozen=True)
class AttitudeParameters(Parameters):
    """Parameters of the attitude estimator: Feng et al. 2018, §3.5 and Eqs. 2-10."""

    method: str = param(
        "ekf",
        "`ekf`: the 15-state error-state filter of §3.5. `quaternion`: the bare quaternion "
        "integration of Eqs. 2-10, started level on the first course; its roll and pitch are "
        "never corrected, its gyro bias is the filter's, as in the paper.",
        source="Feng 2018, §3.5 and Eqs. 2-10",
        choices=("ekf", "quaternion"),
    )
    first_order: bool = param(
        False,
        "With `method: quaternion`: the paper's first-order update (Eqs. 5-6) instead of the "
        "exact one.",
        source="Feng 2018, Eqs. 5-6",
    )
    gps_lag_s: float = param(
        0.15,
        "Time from when a fix was true to its header stamp; 0.1-0.3 s with stamps of arrival, 0 "
        "when the stamps are of validity. Wrong by 0.1 s costs about 0.5° of tilt in manoeuvres.",
        source="measured: recorded receivers 0.02 to 0.28 s (docs/detectors.md)",
        basic=True,
        unit="s",
        low=0.0,
        high=1.0,
    )
    align_speed: float = param(
        3.0,
        "The heading is taken from the first course above this speed over ground (text under "
        "Eq. 10, with a gate: a hovering vehicle has no course).",
        source="Feng 2018, text under Eq. 10; the gate is chosen, not swept",
        basic=True,
        unit="m/s",
        low=0.5,
        high=50.0,
    )
    align_sigma_deg: float = param(
        30.0,
        "Standard deviation of that first heading: how far from its nose the vehicle may fly.",
        source="chosen, not swept",
        unit="deg",
        low=1.0,
        high=90.0,
    )
    settled_sigma_deg: float = param(
        7.0,
        "Orientation is published from when the filter's own heading uncertainty first falls "
        "below this; until then imu/data has none (REP-145).",
        source="chosen, not swept",
        unit="deg",
        low=0.1,
        high=90.0,
    )
    level_s: float = param(
        0.5,
        "Roll and pitch start from the mean accelerometer reading over this time.",
        source="chosen, not swept",
        unit="s",
        low=0.05,
        high=10.0,
    )
    max_imu_gap_s: float = param(
        1.0,
        "After a longer gap in the IMU data the filter takes position, velocity and tilt for "
        "unknown, and keeps biases and heading with what it may have turned; after 30 s, or before "
        "it has a heading, it restarts.",
        source="chosen, not swept",
        unit="s",
        low=0.05,
        high=10.0,
    )
    accel_noise: float = param(
        0.1,
        "Accelerometer noise density; vibration and aliasing included, so far above a data sheet.",
        source="chosen, not swept",
        unit="m/s²/√Hz",
        low=1e-4,
        high=10.0,
    )
    gyro_noise: float = param(
        0.003,
        "Gyroscope noise density.",
        source="chosen, not swept; recorded IMUs have 0.001 to 0.01 (gyro_noise of coast)",
        unit="rad/s/√Hz",
        low=1e-6,
        high=1.0,
    )
    accel_bias_walk: float = param(
        0.005,
        "Random walk of the accelerometer bias.",
        source="chosen; within the 0.003 to 0.01 that fit 11 of 13 recorded flights best (coast)",
        unit="m/s²/√s",
        low=0.0,
        high=1.0,
    )
    gyro_bias_walk: float = param(
        0.0007,
        "Random walk of the gyroscope bias; real biases move by 0.3°/s within a quarter minute.",
        source="physics: 0.3°/s in 15 s is two standard deviations",
        unit="rad/s/√s",
        low=0.0,
        high=0.1,
    )
    position_sigma: float = param(
        1.0,
        "Standard deviation of a fix, East and North.",
        source="chosen, not swept",
        basic=True,
        unit="m",
        low=0.01,
        high=100.0,
    )
    height_sigma: float = param(
        2.0,
        "Standard deviation of a fix, Up.",
        source="physics: vertical dilution is about twice the horizontal",
        unit="m",
        low=0.01,
        high=100.0,
    )
    velocity_sigma: float = param(
        0.2,
        "Standard deviation of a GPS velocity, each axis.",
        source="chosen, not swept",
        basic=True,
        unit="m/s",
        low=0.01,
        high=100.0,
    )
    use_mag: bool = param(
        True,
        "Use the magnetometer where there is one. Faithful: false (gyro, accelerometer and GPS "
        "alone); then the heading drifts on straight lines, where nothing shows it.",
        source="Feng 2018 has none; without one the heading drifts (docs/attitude.md)",
        basic=True,
    )
    mag_sigma_deg: float = param(
        10.0,
        "Standard deviation of the magnetic heading; large, since currents disturb it in bursts.",
        source="chosen, not swept",
        unit="deg",
        low=0.1,
        high=90.0,
    )
    mag_gate_deg: float = param(
        10.0,
        "A magnetic heading further than this, and than three standard deviations, from the "
        "filter's is not used: a current or a steel bridge. After 30 s of that it is used again.",
        source="chosen: that of mag_sigma_deg",
        unit="deg",
        low=1.0,
        high=180.0,
    )
    sensor_patience_s: float = sensor_patience()
