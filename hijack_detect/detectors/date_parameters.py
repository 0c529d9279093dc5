# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the DATE detector."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.detectors.input_watch import patience
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.patience import sensor_patience


@dataclass(frozen=True)
class DateParameters(Parameters):
    """Defaults are the hardened variant; the faithful values of Feng 2018 are in each text."""

    window_s: float = param(
        2.0,
        "Differences of acceleration are averaged over this time. Faithful: 2.0, as for the "
        "correlation; the paper gives none.",
        unit="s",
        low=0.2,
        high=60.0,
    )
    threshold: float = param(
        1.5,
        "Largest horizontal difference of acceleration that is normal, with `noise_gain` 0. The "
        "paper gives none: take it from clean flights of the vehicle.",
        unit="m/s²",
        low=0.05,
        high=50.0,
    )
    noise_gain: float = param(
        6.2,
        "The limit is this times the RMS difference of this flight so far: 5.4 times is the most "
        "on clean flights of a receiver that loses its fix, 4.0 on others. Faithful: 0, the limit "
        "is `threshold`.",
        low=0.0,
        high=100.0,
    )
    least_limit: float = param(
        0.4,
        "Smallest limit that `noise_gain` gives.",
        unit="m/s²",
        low=0.05,
        high=50.0,
    )
    settle_s: float = param(
        20.0,
        "NOT_READY until that RMS is learnt from so much flight.",
        unit="s",
        low=1.0,
        high=600.0,
    )
    max_force: float = param(
        25.0,
        "NOT_OBSERVABLE for `recover_s` after a specific force above this: aerobatics or a crash. "
        "Faithful: 1000 (off).",
        unit="m/s²",
        low=11.0,
        high=1000.0,
    )
    recover_s: float = param(30.0, "See `max_force`.", unit="s", low=1.0, high=600.0)
    gps_lag_s: float = param(
        0.15,
        "Time from when a GPS velocity was true to its header stamp. Faithful: 0 (ignored).",
        unit="s",
        low=0.0,
        high=1.0,
    )
    max_lag_s: float = param(
        1.55,
        "A lag that grows in flight is followed up to this. Faithful: 0 (the lag is constant, and "
        "every interval counts the same, however long).",
        unit="s",
        low=0.0,
        high=3.0,
    )
    persist_s: float = param(
        0.4,
        "The difference must last this long to be an ALARM; SUSPICIOUS before. Faithful: 0.",
        unit="s",
        low=0.0,
        high=60.0,
    )
    max_tilt_deg: float = param(
        75.0,
        "NOT_OBSERVABLE for one window after the body was tilted by more than this: a vehicle "
        "that tumbles or has crashed. Faithful: 180 (off).",
        unit="deg",
        low=10.0,
        high=180.0,
    )
    in_flight: bool = param(
        True,
        "Judge and learn only while the vehicle is in the air with a usable IMU. Faithful: false.",
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()
    max_gap_s: float = param(
        2.0,
        "GPS velocities further apart than this are not compared.",
        unit="s",
        low=0.1,
        high=60.0,
    )
