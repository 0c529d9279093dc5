# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the Kullback-Leibler detector."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hijack_detect.detectors.input_watch import patience
from hijack_detect.parameters import Parameters, param

NAMES = ("altitude", "satellites", "speed", "track", "latitude", "longitude")
"""The parameters of the GPS that are watched (Basan 2022, §2.2)."""


def _threshold(default: float, of: str, faithful: float) -> Any:
    return param(
        default,
        f"Largest sum of forward and backward divergence that is normal for {of}. Faithful: "
        f"{faithful:g}, from simulated flights of their own; the paper gives none.",
        unit="nat",
        low=1e-15,
        high=1e6,
    )


@dataclass(frozen=True)
class KldParameters(Parameters):
    """Defaults are the hardened variant; the faithful values of Basan 2022 are in each text."""

    mode: str = param(
        "hardened",
        "`faithful`: the values in the units and ranges of Table 2, the sums of Eqs. 7-13 over "
        "their probabilities, which are not normalised. `hardened`: how far each value is from "
        "going on as before, in steps of metres, and the divergence of whole distributions. "
        "Thresholds and quorum belong to the mode: change them together.",
        choices=("faithful", "hardened"),
    )
    window: int = param(
        10,
        "n: number of values that a mean is taken of (§2.2), and length of the windows that are "
        "compared. Faithful: 10. 10 values at 5 Hz are 2 s.",
        low=2,
        high=1000,
    )
    quorum: int = param(
        1,
        "An alarm needs this many parameters above their thresholds at once (§2.3). Faithful: 2. "
        "In the hardened mode one is enough: no manoeuvre comes near a threshold.",
        low=1,
        high=len(NAMES),
    )
    together: int = param(
        2,
        "Up to this many times the quorum of parameters may share a claim: two at half of their "
        "thresholds at once are as much as one at its own, since the divergences of independent "
        "parameters add up. Faithful: 1 (off).",
        low=1,
        high=len(NAMES),
    )
    altitude_threshold: float = _threshold(18.0, "the altitude", 2.5e-4)
    satellites_threshold: float = _threshold(6.0, "the number of satellites", 0.03)
    speed_threshold: float = _threshold(18.0, "the ground speed", 50.0)
    track_threshold: float = _threshold(10.0, "the track angle", 750.0)
    latitude_threshold: float = _threshold(18.0, "the latitude", 6e-12)
    longitude_threshold: float = _threshold(18.0, "the longitude", 3e-12)
    latched: bool = param(
        True,
        "Keep an alarm until the node's service ~/reset is called: successive windows see only "
        "change, so a spoof that has settled looks normal.",
    )
    scale_m: float = param(
        0.15,
        "Hardened: noise of a position that counts as one step. Steps also grow with the time "
        "between fixes, see `acceleration`.",
        unit="m",
        low=0.01,
        high=100.0,
    )
    acceleration: float = param(
        2.5,
        "Hardened: change of velocity that counts as one step, so that manoeuvres stay below a "
        "few steps at every rate of fixes. Raise it for racing drones.",
        unit="m/s²",
        low=0.1,
        high=100.0,
    )
    turn_rate_deg_s: float = param(
        50.0,
        "Hardened: rate of turn that counts as one step of the track angle.",
        unit="deg/s",
        low=1.0,
        high=1000.0,
    )
    min_speed: float = param(
        2.0,
        "Hardened: below this ground speed there is no track angle.",
        unit="m/s",
        low=0.0,
        high=50.0,
    )
    floor: float = param(
        0.1,
        "Hardened: added to every mean number of steps: a few steps after none mean little.",
        low=1e-6,
        high=100.0,
    )
    dispersion: float = param(
        2.0,
        "Hardened: k of the negative binomial distributions: counts scatter with λ + λ² / k. 2 is "
        "the scatter of the size of normal noise; a large k is Poisson's law.",
        low=0.1,
        high=1e6,
    )
    max_gap_s: float = param(
        2.0,
        "Values further apart than this are not compared.",
        unit="s",
        low=0.1,
        high=60.0,
    )
    patience_s: float = param(
        3.0,
        "How long to wait for a GPS topic that has gone silent, on the stamps of the others. "
        "3600 for acknowledged delivery and replays faster than real time, where every topic is "
        "there.",
        unit="s",
        low=3.0,
        high=3600.0,
    )
    phase_patience_s: float = patience()

    def threshold(self, name: str) -> float:
        """Threshold of one of `NAMES`, nats."""
        return float(getattr(self, f"{name}_threshold"))
