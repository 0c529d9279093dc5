# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the yaw/course correlation detector."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.detectors.input_watch import patience
from hijack_detect.parameters import Parameters, param


@dataclass(frozen=True)
class CorrelationParameters(Parameters):
    """Defaults are the hardened variant; the faithful values of Feng 2018 are in each text."""

    window_s: float = param(
        2.0,
        "Window of Algorithm 2. Faithful: 2.0 (N = 100 samples at 50 Hz).",
        unit="s",
        low=0.2,
        high=600.0,
    )
    smoothing_s: float = param(
        0.2,
        "Moving mean over yaw and course before they are compared (§4.3 calls it a median "
        "filter and gives no length). Faithful: 0.2.",
        unit="s",
        low=0.0,
        high=10.0,
    )
    course_lag_s: float = param(
        0.35,
        "How far a course lags behind the yaw: GPS lag, half the time between the two fixes it "
        "comes from, and half the time it is held; the yaw is held back by as much. In turns of "
        "30°/s 0.35 s is 10°. Faithful: 0 (ignored).",
        unit="s",
        low=0.0,
        high=5.0,
    )
    epsilon: float = param(
        0.85,
        "ε: trends agree above this correlation coefficient (Eq. 11). Faithful: 0.85.",
        low=-1.0,
        high=0.999,
    )
    mu_deg: float = param(
        20.0,
        "μ: directions agree below this difference of the means. Faithful: 10. Wind makes "
        "crab angles change by more than 10° in turns; raise it for gusty sites.",
        unit="deg",
        low=0.1,
        high=180.0,
    )
    min_sigma_deg: float = param(
        2.0,
        "Below this standard deviation of yaw or course in the window the two have not turned "
        "together and ρ means nothing. Faithful: 0 (only an exactly constant angle has no ρ).",
        unit="deg",
        low=0.0,
        high=90.0,
    )
    persist_s: float = param(
        1.0,
        "The condition must hold for this long to be an ALARM; SUSPICIOUS before. Faithful: 0.",
        unit="s",
        low=0.0,
        high=60.0,
    )
    follow_s: float = param(
        8.0,
        "The nose must have followed the course for this long before the window, else "
        "NOT_OBSERVABLE; differences count from the crab angle of that time. Faithful: 0 (off).",
        unit="s",
        low=0.0,
        high=600.0,
    )
    follow_sigma_deg: float = param(
        10.0,
        "Largest standard deviation of course minus yaw in that time that still is following.",
        unit="deg",
        low=0.1,
        high=180.0,
    )
    follow_offset_deg: float = param(
        45.0,
        "Largest mean of course minus yaw in that time: a larger one is flying sideways.",
        unit="deg",
        low=0.1,
        high=180.0,
    )
    max_heading_sigma_deg: float = param(
        10.0,
        "NOT_OBSERVABLE while the estimator's own heading uncertainty is larger: without a "
        "magnetometer the heading drifts on long straight lines. Faithful: 180 (off).",
        unit="deg",
        low=0.1,
        high=180.0,
    )
    in_flight: bool = param(
        True,
        "Judge only while the vehicle is in the air with a usable IMU. Faithful: false.",
    )
    patience_s: float = patience()
