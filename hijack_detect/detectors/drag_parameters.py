# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the drag detector."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.detectors.input_watch import patience
from hijack_detect.estimation.drag_noise import (
    DragNoise,
    first_drag,
    first_drag_sigma,
    first_quadratic_sigma,
)
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.patience import sensor_patience


@dataclass(frozen=True)
class DragParameters(Parameters):
    """The detector answers slowly: `recent_s` sets the pace, `frozen_s` what it remembers."""

    gps_lag_s: float = param(
        0.2,
        "Time from when a GPS velocity was true to its header stamp. Wrong by 0.1 s costs little: "
        "drag is a matter of seconds.",
        unit="s",
        low=0.0,
        high=1.0,
    )
    block_s: float = param(
        0.4,
        "Force and velocity are averaged over this time, or the interval of slower receivers.",
        unit="s",
        low=0.1,
        high=5.0,
    )
    recent_s: float = param(
        20.0,
        "The wind of this last time is compared with the wind before. Longer is surer and slower.",
        unit="s",
        low=5.0,
        high=120.0,
    )
    frozen_s: float = param(
        40.0,
        "Age of the parameters that are compared with; a change that takes longer than this less "
        "half of recent_s is taken for weather. After take-off younger ones are used.",
        unit="s",
        low=10.0,
        high=300.0,
    )
    ready_s: float = param(
        25.0,
        "Time in flight, after settle_s, before there is anything to compare; at least recent_s.",
        unit="s",
        low=5.0,
        high=300.0,
    )
    hold_s: float = param(
        120.0,
        "While the change is over its limit the parameters from before it are kept, at most until "
        "they are this old: then the new wind is believed, and an alarm ends.",
        unit="s",
        low=10.0,
        high=3600.0,
    )
    least_limit: float = param(
        3.7,
        "Change of wind that is normal in any weather. Take it from clean flights of the vehicle, "
        "windy ones among them. A gust front of this size cannot be told from an attack.",
        unit="m/s",
        low=0.5,
        high=50.0,
    )
    limit_offset: float = param(
        1.0,
        "In strong wind limit_offset + limit_share * wind is normal, if it is more.",
        unit="m/s",
        low=0.0,
        high=50.0,
    )
    limit_share: float = param(
        0.55,
        "See limit_offset. 0 makes the limit the same in all winds.",
        low=0.0,
        high=5.0,
    )
    max_sigma: float = param(
        1.5,
        "NOT_OBSERVABLE where the change of wind is known less well than this (one standard "
        "deviation): a straight route at constant speed, where wind and accelerometer bias look "
        "the same.",
        unit="m/s",
        low=0.1,
        high=10.0,
    )
    prior_change: float = param(
        5.0,
        "A change of wind is expected to be about this large; what the flight does not tell stays "
        "within it.",
        unit="m/s",
        low=0.5,
        high=50.0,
    )
    persist_s: float = param(
        2.0,
        "The limit must be exceeded for this long to be an ALARM; SUSPICIOUS before.",
        unit="s",
        low=0.0,
        high=60.0,
    )
    drag: float = first_drag()
    drag_sigma: float = first_drag_sigma()
    quadratic_sigma: float = first_quadratic_sigma(0.005)
    least_drag: float = param(
        0.1,
        "A vehicle with less drag than this is not seen by its drag: NOT_OBSERVABLE. A fixed wing "
        "ends here.",
        unit="1/s",
        low=0.0,
        high=2.0,
    )
    learnt_share: float = param(
        0.95,
        "Drag is learnt once its standard deviation is below this share of drag_sigma.",
        low=0.05,
        high=1.0,
    )
    max_residual: float = param(
        0.45,
        "NOT_OBSERVABLE where drag leaves more than this of the specific force unexplained (root "
        "mean square of blocks): a fixed wing, aerobatics, a loose sensor.",
        unit="m/s²",
        low=0.05,
        high=10.0,
    )
    bias_sigma: float = param(
        0.2,
        "Standard deviation of the accelerometer's bias along body x and y, a tilted mounting "
        "included (1° is 0.17).",
        unit="m/s²",
        low=0.01,
        high=5.0,
    )
    gust_s: float = param(
        1.0,
        "How long gusts keep the force away from the model. Longer trusts the flight less.",
        unit="s",
        low=0.0,
        high=30.0,
    )
    wind_walk: float = param(
        0.15,
        "How fast the wind is expected to change: standard deviation after one second.",
        unit="m/s",
        low=0.0,
        high=5.0,
    )
    max_heading_sigma_deg: float = param(
        20.0,
        "Blocks with a heading known less well are left out.",
        unit="deg",
        low=1.0,
        high=180.0,
    )
    heading_gain: float = param(
        6.0,
        "A wrong heading turns the velocity into a wind: this times speed times standard deviation "
        "of the heading (rad), the largest of recent_s, and without what the limit holds already "
        "(0.35 m/s), adds to the limit as squares. A multirotor that braked from 6 m/s with a "
        "heading known to 10° needed 4.",
        low=0.0,
        high=20.0,
    )
    moving_speed: float = param(
        2.0,
        "A vehicle that is faster for 2 s, or climbs at half of this, is in the air.",
        unit="m/s",
        low=0.2,
        high=50.0,
    )
    settle_s: float = param(
        5.0,
        "Nothing is learnt for this long after that: take-off.",
        unit="s",
        low=0.0,
        high=60.0,
    )
    still_share: float = param(
        0.25,
        "The vehicle stands on the ground again when it does not move and the accelerometer "
        "shakes less than this share of what it did in the air. 0: never.",
        low=0.0,
        high=1.0,
    )
    patience_s: float = patience()
    sensor_patience_s: float = sensor_patience()
    max_gap_s: float = param(
        2.0,
        "GPS velocities further apart than this are not joined, and the wind is forgotten.",
        unit="s",
        low=0.1,
        high=60.0,
    )

    @property
    def noise(self) -> DragNoise:
        """What the filter assumes."""
        return DragNoise(
            correlation_s=self.gust_s,
            drag=(self.drag, self.drag_sigma),
            quadratic_sigma=self.quadratic_sigma,
            bias=self.bias_sigma,
            wind_walk=self.wind_walk,
        )

    def limit(self, wind: float) -> float:
        """Largest change of wind that is normal at a speed of the wind, m/s."""
        return max(self.least_limit, self.limit_offset + self.limit_share * wind)
