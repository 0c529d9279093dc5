# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the altitude detector."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.detectors.input_watch import patience
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.silence import sensor_patience


@dataclass(frozen=True)
class AltitudeParameters(Parameters):
    """Parameters of the comparison of GPS height with barometer and accelerometer."""

    persist_s: float = param(
        0.6,
        "A limit must be exceeded for this long to be an ALARM; SUSPICIOUS before.",
        source="chosen, not swept",
        unit="s",
        low=0.0,
        high=60.0,
    )
    gps_lag_s: float = param(
        0.2,
        "Time from when a GPS height and velocity were true to their header stamp.",
        source="chosen, not swept; recorded receivers have 0.02 to 0.28 s (docs/detectors.md)",
        basic=True,
        unit="s",
        low=0.0,
        high=1.0,
    )
    learn_s: float = param(
        10.0,
        "The first difference between GPS and barometer is the mean over this time. NOT_READY "
        "before.",
        source="chosen, not swept",
        unit="s",
        low=1.0,
        high=120.0,
    )
    wander_m: float = param(
        3.8,
        "Gauss-Markov error of the GPS height of a poor receiver (part 1): standard deviation.",
        source="chosen by a table of recorded receivers (docs/detection-limits.md, How far a "
        "GPS height may wander)",
        unit="m",
        low=0.1,
        high=100.0,
    )
    wander_s: float = param(
        90.0,
        "Time constant of that error. Recorded receivers have 60 to more than 120 s.",
        source="chosen, as wander_m",
        unit="s",
        low=1.0,
        high=3600.0,
    )
    height_noise_m: float = param(
        1.05,
        "White noise beside it: receiver, propeller wash. Raise it for a barometer without a foam.",
        source="chosen, not swept",
        unit="m",
        low=0.01,
        high=100.0,
    )
    height_sigmas: float = param(
        3.5,
        "A change of the difference between GPS height and barometer within 1 to 60 s is normal "
        "up to this many standard deviations.",
        source="chosen, not swept",
        low=1.0,
        high=20.0,
    )
    baro_floor: float = param(
        0.5,
        "A good receiver and barometer earn limits of this part of those of a poor pair, after "
        "30 s in the air. They start with 2.5 times the whole.",
        source="chosen, not swept",
        low=0.05,
        high=1.0,
    )
    baro_gain: float = param(
        2.75,
        "The part is this many times the largest change of the flight's past.",
        source="chosen: the smallest of five from 2 to 3 with no clean margin above 0.67 "
        "(docs/detection-limits.md, How far a GPS height may wander)",
        low=1.0,
        high=20.0,
    )
    baro_ceiling: float = param(
        2.0,
        "The part is never more in flight for what a receiver claims: what an attacker can gain "
        "by jamming.",
        source="chosen: bounds what an attacker gains by jamming",
        low=1.0,
        high=10.0,
    )
    baro_highest: float = param(
        3.0,
        "The part is never more in flight, for a receiver that claims to be poor and was seen to "
        "wander.",
        source="chosen, not swept",
        low=1.0,
        high=10.0,
    )
    lag_share: float = param(
        0.5,
        "Share of what the vehicle climbed within 2 s that a receiver may lack since its filter "
        "lags.",
        source="chosen, not swept",
        low=0.0,
        high=1.0,
    )
    baro_total_m: float = param(
        12.0,
        "Least normal distance of the difference from its slowly adapting reference. It is more "
        "for a receiver that claims or shows to be poor.",
        source="chosen, not swept",
        unit="m",
        low=0.5,
        high=200.0,
    )
    reference_rate: float = param(
        0.03,
        "How fast the reference follows pressure and temperature. Weather needs 0.005, a "
        "barometer that warms up 0.02. A slower attack than this is invisible.",
        source="physics: weather needs 0.005, warming 0.02",
        unit="m/s",
        low=0.0,
        high=1.0,
    )
    height_scale: float = param(
        0.08,
        "Share of a climb by which the barometer may be wrong: 0.07 for air 20 K off the "
        "standard atmosphere.",
        source="physics: 288 K against 268 K",
        low=0.0,
        high=0.5,
    )
    speed_error: float = param(
        0.3,
        "Share of the dynamic pressure that reaches the barometer; 10 m/s is 5.1 m of it. The "
        "speed is that of the GPS, so that the allowance ends at 3 m.",
        source="chosen, not swept",
        low=0.0,
        high=2.0,
    )
    settle_s: float = param(
        20.0,
        "The inertial check waits for this long after the attitude is known, while it learns "
        "the accelerometer's vertical bias. A third of it after a gap or a tumble.",
        source="chosen, not swept",
        unit="s",
        low=2.0,
        high=300.0,
    )
    max_tilt_deg: float = param(
        55.0,
        "The inertial check starts over where the body was tilted by more than this: the "
        "accelerometer's scale and the attitude are not good enough in aerobatics.",
        source="chosen, not swept",
        unit="deg",
        low=10.0,
        high=180.0,
    )
    force_noise: float = param(
        0.25,
        "Random walk of velocity from a noisy accelerometer in calm flight.",
        source="chosen, not swept",
        unit="m/s/√s",
        low=0.01,
        high=10.0,
    )
    manoeuvre_noise: float = param(
        0.15,
        "Added to force_noise for each m/s² by which the specific force differs from gravity: "
        "scale error, lag, vibration.",
        source="chosen, not swept",
        unit="1/√s",
        low=0.0,
        high=5.0,
    )
    bias_walk: float = param(
        0.01,
        "How fast the accelerometer's vertical bias wanders.",
        source="chosen, not swept",
        unit="m/s²/√s",
        low=0.0,
        high=1.0,
    )
    max_bias: float = param(
        1.0,
        "The learnt vertical bias stays within this, whatever the GPS reports.",
        source="chosen, not swept",
        unit="m/s²",
        low=0.05,
        high=5.0,
    )
    calm_innovation: float = param(
        0.12,
        "Scatter of the innovation of the GPS vertical velocity below which a flight is as good "
        "as any. The velocity limits grow with the scatter before the last 20 s, at most "
        "threefold.",
        source="chosen, not swept",
        unit="m/s",
        low=0.01,
        high=5.0,
    )
    manoeuvre_gain: float = param(
        0.2,
        "The velocity limits grow by this share for each m/s² by which the specific force of the "
        "last 5 s differed from gravity by more than 0.5 m/s².",
        source="chosen, not swept",
        unit="s²/m",
        low=0.0,
        high=5.0,
    )
    limit_acceleration: float = param(
        1.65,
        "Largest normal evidence for an acceleration of the GPS that the accelerometer did not "
        "feel, standard deviations with the floor of systematic errors.",
        source="measured: recorded flights; the largest clean margin of altitude is 0.87 "
        "(docs/detection-limits.md, Limits of the detectors)",
        low=0.5,
        high=100.0,
    )
    limit_velocity: float = param(
        1.6,
        "The same for a constant vertical velocity.",
        source="measured, as limit_acceleration",
        low=0.5,
        high=100.0,
    )
    limit_rate: float = param(
        4.0,
        "The same for a height that moves without the vertical velocity.",
        source="measured, as limit_acceleration",
        low=0.5,
        high=100.0,
    )
    limit_step: float = param(
        1.5,
        "The same for a height that has jumped.",
        source="measured, as limit_acceleration",
        low=0.3,
        high=100.0,
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()
