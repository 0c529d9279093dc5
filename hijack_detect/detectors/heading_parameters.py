# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the heading detector."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.detectors.input_watch import patience
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.patience import sensor_patience


def _limit(default: float, seconds: int) -> float:
    limit: float = param(
        default,
        f"How far the estimator's heading may turn away from compass and gyro within {seconds} s. "
        "Take 1.5 times the largest of clean flights of the vehicle; raise it for a compass near "
        "motor currents.",
        unit="deg",
        low=1.0,
        high=180.0,
    )
    return limit


@dataclass(frozen=True)
class HeadingParameters(Parameters):
    """Parameters of the comparison of the headings of gyro, compass and GPS."""

    limit_2_deg: float = _limit(7.0, 2)
    limit_5_deg: float = _limit(6.0, 5)
    limit_10_deg: float = _limit(11.0, 10)
    limit_20_deg: float = _limit(17.0, 20)
    persist_s: float = param(
        0.6,
        "The estimator must be away for this long to be an ALARM; SUSPICIOUS before.",
        unit="s",
        low=0.0,
        high=60.0,
    )
    settle_s: float = param(
        10.0,
        "The compass is not compared before it has had a heading for this long: roll and pitch "
        "settle on the accelerometer first.",
        unit="s",
        low=1.0,
        high=120.0,
    )
    compass_deg: float = param(
        25.0,
        "Compass and gyro disagree when their turns over 2 to 20 s differ by more. The compass "
        "of a vehicle that accelerates hard is off by the dip times the error of its tilt: clean "
        "flights reach 17°.",
        unit="deg",
        low=1.0,
        high=180.0,
    )
    tolerated_deg: float = param(
        6.0,
        "A swing of the compass against the gyro within 45 s that exceeds this is added "
        "twice to every limit: an estimator that uses the compass is pulled along by as much.",
        unit="deg",
        low=0.0,
        high=180.0,
    )
    field_heading_deg: float = param(
        20.0,
        "A magnetometer reading this far from the heading of compass and gyro is an anomaly and "
        "is not used.",
        unit="deg",
        low=2.0,
        high=180.0,
    )
    field_dip_deg: float = param(
        10.0,
        "A reading whose dip (angle below the horizon) is this far from the usual one is an "
        "anomaly and is not used.",
        unit="deg",
        low=1.0,
        high=90.0,
    )
    field_strength: float = param(
        0.15,
        "A reading whose strength differs from the usual one by this part is an anomaly and is "
        "not used. Raise it for a compass near motor currents.",
        low=0.01,
        high=10.0,
    )
    recover_s: float = param(
        60.0,
        "At the start and after an anomaly of the compass the estimator is not judged until it "
        "agrees with the compass within limit_2_deg for 5 s, or for this long.",
        unit="s",
        low=1.0,
        high=600.0,
    )
    course_deg: float = param(
        30.0,
        "SUSPICIOUS when the course has turned by more than this from where it was to the nose "
        "while the nose followed it. Never an ALARM: a pilot who begins to fly sideways does the "
        "same. Clean turns in 8 m/s of wind change the crab angle by 19°.",
        unit="deg",
        low=1.0,
        high=180.0,
    )
    min_speed: float = param(
        3.0, "Below this speed over ground there is no course.", unit="m/s", low=0.5, high=50.0
    )
    gps_lag_s: float = param(
        0.15,
        "Time from when a GPS velocity was true to its header stamp.",
        unit="s",
        low=0.0,
        high=1.0,
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()
