# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the coast detector."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.detectors.input_watch import patience
from hijack_detect.estimation.drag_filter import (
    DragNoise,
    first_drag,
    first_drag_sigma,
    first_quadratic_sigma,
)
from hijack_detect.estimation.lag_ekf import ModelErrors
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.silence import sensor_patience

LAG_WALK = 0.05
"""s/√s, random walk of the GPS lag. Of a receiver in order it is 0.001; with 0.05 the filter
follows one whose latency grows by 1.2 s within 10 s. With 0.03 a turn in such a time alarms
(54 flights with growing latency), with 0.1 wrong lags take up accelerations (recorded flights)."""
LAG_DIFFERENCE_WALK = 0.001
"""s/√s, the same for that of position beside that of velocity: the walk of a receiver in order,
since both come from one solution."""
LAG_JITTER_S = 0.05
"""Velocity noise grows with acceleration times this, s: what is left of it beside a coloured error
(5 to 10 ms rms of jitter between fixes and IMU on recorded flights, late fixes of 20 ms)."""
POSITION_JITTER_S = 0.05
"""Position noise grows with speed times this, s. Chosen: the jitter of the same stamps."""
FORCE_SCALE = 0.03
"""Accelerometer noise density grows with acceleration times this, 1/√Hz. Chosen: the
tolerance of scale of a MEMS accelerometer, ± 3 % (MPU-6000, product specification, section 6.2), as
if it changed every second."""
RATE_SCALE = 0.01
"""Gyroscope noise density grows with angular velocity times this, 1/√Hz: between none, of most
recorded IMUs, and 0.02, of those that are sampled at 25 Hz."""
MAX_LAG_S = 0.4
"""Bound of both lags about the nominal one. Chosen: two standard deviations where the walk ends."""
GUST_S = 1.0
"""How long a gust keeps the force away from the model of drag, s: `gust_s` of drag."""
TILT = 0.2
"""m/s², force along x and y from tilted rotors, standard deviation: 1° is 0.17."""
WIND_WALK = 0.15
"""m/s/√s, random walk of the wind, 1.2 m/s in a minute: `wind_walk` of drag. Gusts have parameters
of their own."""


@dataclass(frozen=True)
class CoastParameters(Parameters):
    """Inertial consistency over many onsets: a constant offset acceleration of the GPS."""

    gps_lag_s: float = param(
        0.18,
        "Nominal time from when a fix was true to its header stamp. The filter learns how far "
        "position and velocity are off it, up to 0.2 s.",
        source="measured: recorded receivers 0.02 to 0.28 s (docs/detectors.md, what coast and "
        "date assume)",
        basic=True,
        unit="s",
        low=0.0,
        high=1.0,
    )
    lag_sigma_s: float = param(
        0.07,
        "Standard deviation of the lags of position and velocity about the nominal one, which the "
        "filter learns. Of 13 recorded receivers none is further off than 0.13 s.",
        source="measured: 13 recorded receivers",
        unit="s",
        low=0.0,
        high=0.2,
    )
    use_mag: bool = param(
        True,
        "Use the magnetometer where there is one: the heading is known before the first move.",
        source="physics: before the first acceleration nothing else shows the heading",
        basic=True,
    )
    mag_sigma_deg: float = param(
        30.0,
        "Standard deviation of a magnetic heading; larger than that of the attitude estimator, "
        "since currents disturb it for seconds, and a heading that follows turns every force.",
        source="chosen, not swept: three times that of the attitude estimator",
        unit="deg",
        low=0.1,
        high=90.0,
    )
    position_sigma: float = param(
        0.7,
        "Standard deviation of a fix on the next.",
        source="chosen, not swept",
        unit="m",
        low=0.01,
        high=100.0,
    )
    velocity_sigma: float = param(
        0.05,
        "White noise of a GPS velocity, standard deviation; a receiver that jumps more is taken "
        "to be up to five times as noisy, from what it shows in flight.",
        source="u-blox M8 data sheet: velocity accuracy 0.05 m/s",
        unit="m/s",
        low=0.01,
        high=100.0,
    )
    velocity_error: float = param(
        0.3,
        "Error of a GPS velocity that lasts for about a second (Gauss-Markov), standard deviation. "
        "Recorded receivers: 0.1 to 0.5. Noise that is taken for white tilts the filter.",
        source="measured: the middle of the recorded receivers",
        unit="m/s",
        low=0.0,
        high=10.0,
    )
    gyro_noise: float = param(
        0.002,
        "Gyroscope noise density. Between 0.001, of most recorded IMUs, and 0.01, of those that "
        "are sampled at 25 Hz: what is worse shows in the noise scale.",
        source="measured: recorded IMUs",
        unit="rad/s/√Hz",
        low=1e-6,
        high=1.0,
    )
    accel_bias_walk: float = param(
        0.01,
        "Random walk of the accelerometer bias. 0.003 to 0.01 fit 11 of 13 recorded flights best.",
        source="measured: likelihood of 13 recorded flights",
        unit="m/s²/√s",
        low=0.0,
        high=1.0,
    )
    gyro_bias_walk: float = param(
        0.0004,
        "Random walk of the gyroscope bias.",
        source="chosen, not swept",
        unit="rad/s/√s",
        low=0.0,
        high=0.1,
    )
    longest_s: float = param(
        8.0,
        "Oldest onset. Of an offset older than this only what it did at first is visible: tilt "
        "and bias have taken up the rest.",
        source="chosen, not swept",
        unit="s",
        low=3.0,
        high=36.0,
    )
    drag: float = first_drag()
    drag_sigma: float = first_drag_sigma()
    quadratic_sigma: float = first_quadratic_sigma(0.01)
    gust: float = param(
        3.0,
        "With an onset the wind may change by a step: standard deviation, East and North.",
        source="chosen, not swept: a gust of 6 m/s is two standard deviations",
        unit="m/s",
        low=0.1,
        high=30.0,
    )
    gust_rate: float = param(
        2.0,
        "The same for a steady rise of the wind.",
        source="chosen, not swept",
        unit="m/s²",
        low=0.1,
        high=30.0,
    )
    gusty_gain: float = param(
        1.1,
        "An offset must exceed the limit if the wind did not change, and the limit over this if "
        "it did: drag alone is no proof.",
        source="chosen, not swept",
        low=0.5,
        high=10.0,
    )
    span_s: float = param(
        1.5,
        "Onsets over this time must all show it: an error that is over fits one onset only. "
        "Largest clean margin on recorded flights 0.92, with 1 s 1.05, at the same drifts found.",
        source="measured, with the three limits: scores of all onsets of recorded and "
        "simulated flights at the same largest clean margin",
        unit="s",
        low=0.0,
        high=10.0,
    )
    floor_acceleration: float = param(
        0.05,
        "Error that lasts and that no model has: added to the standard deviation.",
        source="chosen, not swept: what a tilt wrong by 0.3° leaves",
        unit="m/s²",
        low=0.0,
        high=10.0,
    )
    floor_velocity: float = param(
        0.3,
        "The same for a velocity that was there at once.",
        source="measured, as span_s",
        unit="m/s",
        low=0.0,
        high=10.0,
    )
    threshold_low: float = param(
        2.55,
        "Lowest limit of the offset acceleration in its standard deviations. A quiet vehicle "
        "(simulators: scores up to 1.2) would else have one below what a first manoeuvre brings.",
        source="measured, as span_s",
        low=1.0,
        high=100.0,
    )
    threshold_high: float = param(
        5.2,
        "Highest limit, also of an attacker who pulls slowly. Recorded vehicles with vibration, "
        "aliasing or a poor receiver reach 4.8 without an attack.",
        source="measured, as span_s; factor needed with a vehicle left out 1.08 "
        "(docs/detection-limits.md)",
        low=1.0,
        high=100.0,
    )
    threshold_gain: float = param(
        4.5,
        "The limit is this times the usual score of this vehicle (cube root of the mean cube of "
        "the past two minutes), between the two above. On recorded flights the largest score "
        "without an attack is 3.9 times the usual one.",
        source="measured, as span_s",
        low=0.1,
        high=1000.0,
    )
    suspicious_margin: float = param(
        0.85, "SUSPICIOUS from this margin on.", source="chosen, not swept", low=0.1, high=1.0
    )
    settle_s: float = param(
        20.0,
        "NOT_READY for this long after the heading became known: the noise scale is learnt.",
        source="chosen, not swept: twice longest_s and the time until the scale has values of "
        "its own",
        unit="s",
        low=0.0,
        high=600.0,
    )
    persist_s: float = param(
        0.1,
        "The limit must be exceeded this long to be an ALARM; SUSPICIOUS before.",
        source="measured, as span_s: the run of onsets already holds off single fixes",
        unit="s",
        low=0.0,
        high=60.0,
    )
    recover_s: float = param(
        30.0,
        "NOT_OBSERVABLE for at most this long after aerobatics or a crash, whose errors of scale "
        "are larger than any attack.",
        source="measured: one recorded fixed wing, see recover_gain",
        unit="s",
        low=1.0,
        high=600.0,
    )
    recover_gain: float = param(
        60.0,
        "The wait is 2 s and this times the time that the IMU spent beyond max_force or max_rate "
        "within recover_s. One sample in a steep turn costs 3.2 s, half a second of aerobatics the "
        "whole: a recorded fixed wing had an error of 1.4 times the limit 11 s after 0.24 s.",
        source="measured: one recorded fixed wing",
        low=0.0,
        high=1000.0,
    )
    max_force: float = param(
        25.0,
        "A specific force above this is an excursion: aerobatics or a crash, in which the vehicle "
        "counts as unseen.",
        source="chosen, not swept: 2.5 g",
        unit="m/s²",
        low=11.0,
        high=1000.0,
    )
    max_rate: float = param(
        6.0,
        "The same for an angular velocity.",
        source="chosen, not swept: 344°/s",
        unit="rad/s",
        low=0.1,
        high=100.0,
    )
    outage_s: float = param(
        2.0,
        "After a gap of this length in the GPS all onsets restart: what the inertial solution "
        "was off by meanwhile looks like an attack from before the gap.",
        source="the time after which StreamMerge counts an outage (SILENCE_S)",
        unit="s",
        low=0.1,
        high=60.0,
    )
    max_noise_scale: float = param(
        2.5,
        "NOT_OBSERVABLE while the noise scale is above this: IMU and GPS of this vehicle do not "
        "agree well enough to see an attack.",
        source="chosen, not swept",
        low=0.5,
        high=100.0,
    )
    max_visible: float = param(
        3.6,
        "NOT_OBSERVABLE while the smallest acceleration that it could see is larger: after a gap, "
        "until tilt and heading are known again. No drone is carried off so fast.",
        source="chosen, not swept: an attacked vehicle tilted by 20°",
        unit="m/s²",
        low=0.1,
        high=100.0,
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()

    @property
    def errors(self) -> ModelErrors:
        """What the filter allows for lags, and for errors of scale of the IMU."""
        return ModelErrors(
            lag_sigma_s=self.lag_sigma_s,
            lag_walk=LAG_WALK,
            lag_difference_walk=LAG_DIFFERENCE_WALK,
            lag_jitter_s=LAG_JITTER_S,
            position_jitter_s=POSITION_JITTER_S,
            force_scale=FORCE_SCALE,
            rate_scale=RATE_SCALE,
            max_lag_s=MAX_LAG_S,
            max_force=self.max_force,
            max_rate=self.max_rate,
        )

    @property
    def air(self) -> DragNoise:
        """What the filter assumes of wind and drag."""
        return DragNoise(
            correlation_s=GUST_S,
            drag=(self.drag, self.drag_sigma),
            quadratic_sigma=self.quadratic_sigma,
            bias=TILT,
            wind_walk=WIND_WALK,
        )
