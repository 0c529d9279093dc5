# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From GPS samples to the counts whose Poisson distributions are compared.

Each class takes fixes, velocities and numbers of satellites in order of stamp and returns the
counts of the parameters that the sample updates; None where a parameter is not known now.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from hijack_detect.detectors.input_watch import patience
from hijack_detect.estimation.geodesy import LocalFrame
from hijack_detect.parameters import Parameters, param
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    GpsSample,
    SatelliteSample,
    VelocitySample,
)

NAMES = ("altitude", "satellites", "speed", "track", "latitude", "longitude")
"""The parameters of the GPS that are watched (Basan 2022, §2.2)."""


def _threshold(default: float, of: str, faithful: float) -> Any:
    return param(
        default,
        f"Largest sum of forward and backward divergence that is normal for {of}. Faithful: "
        f"{faithful:g}, from simulated flights of their own; the paper gives none.",
        source="measured: about twice the largest of eight recorded flights, or more "
        "(docs/reproduction.md, the hardened mode)",
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
        source="Basan 2022, Table 2 and Eqs. 7-13 for `faithful`",
        choices=("faithful", "hardened"),
    )
    window: int = param(
        10,
        "n: number of values that a mean is taken of (§2.2), and length of the windows that are "
        "compared. Faithful: 10. 10 values at 5 Hz are 2 s.",
        source="Basan 2022, §2.2: the mean of the last ten values",
        low=2,
        high=1000,
    )
    quorum: int = param(
        1,
        "An alarm needs this many parameters above their thresholds at once (§2.3). Faithful: 2. "
        "In the hardened mode one is enough: no manoeuvre comes near a threshold.",
        source="Basan 2022, §2.3, for `faithful`",
        low=1,
        high=len(NAMES),
    )
    together: int = param(
        2,
        "Up to this many times the quorum of parameters may share a claim: two at half of their "
        "thresholds at once are as much as one at its own, since the divergences of independent "
        "parameters add up. Faithful: 1 (off).",
        source="measured: 1 misses a soft attack, with 2 recorded flights reach 0.59 "
        "(docs/reproduction.md, the hardened mode)",
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
        source="physics: two windows of the same spoof are alike",
    )
    scale_m: float = param(
        0.15,
        "Hardened: noise of a position that counts as one step. Steps also grow with the time "
        "between fixes, see `acceleration`.",
        source="chosen, not swept",
        unit="m",
        low=0.01,
        high=100.0,
    )
    acceleration: float = param(
        2.5,
        "Hardened: change of velocity that counts as one step, so that manoeuvres stay below a "
        "few steps at every rate of fixes. Raise it for racing drones.",
        source="chosen, not swept",
        unit="m/s²",
        low=0.1,
        high=100.0,
    )
    turn_rate_deg_s: float = param(
        50.0,
        "Hardened: rate of turn that counts as one step of the track angle.",
        source="chosen, not swept",
        unit="deg/s",
        low=1.0,
        high=1000.0,
    )
    min_speed: float = param(
        2.0,
        "Hardened: below this ground speed there is no track angle.",
        source="as min_speed of course",
        unit="m/s",
        low=0.0,
        high=50.0,
    )
    floor: float = param(
        0.1,
        "Hardened: added to every mean number of steps: a few steps after none mean little.",
        source="chosen, not swept",
        low=1e-6,
        high=100.0,
    )
    dispersion: float = param(
        2.0,
        "Hardened: k of the negative binomial distributions: counts scatter with λ + λ² / k. 2 is "
        "about the scatter of the size of normal noise; a large k is Poisson's law.",
        source="physics: the size of normal noise has mean² / variance 2 / (π - 2) = 1.75; noise "
        "of 2 m gives 9.5 nat with 2, 68 by Poisson's law (docs/reproduction.md)",
        low=0.1,
        high=1e6,
    )
    max_gap_s: float = param(
        2.0,
        "Values further apart than this are not compared.",
        source="the time after which StreamMerge counts an outage (SILENCE_S)",
        unit="s",
        low=0.1,
        high=60.0,
    )
    patience_s: float = param(
        3.0,
        "How long to wait for a GPS topic that has gone silent, on the stamps of the others. "
        "3600 for acknowledged delivery and replays faster than real time, where every topic is "
        "there.",
        source="as sensor_patience_s of other detectors",
        unit="s",
        low=3.0,
        high=3600.0,
    )
    phase_patience_s: float = patience()

    def threshold(self, name: str) -> float:
        """Threshold of one of `NAMES`, nats."""
        return float(getattr(self, f"{name}_threshold"))


Counts = Mapping[str, float | None]

ALTITUDES_M, SPEEDS, SATELLITES = (0.0, 1000.0), (0.0, 40.0), (0.0, 34.0)
"""Ranges of Table 2: metres, m/s, number."""
ALTITUDE_M, SPEED, ANGLE_DEG = 0.1, 0.1, 1e-7
"""Units of Table 2: metres, m/s, degrees of latitude and longitude."""


class Values(Protocol):
    """A way to make counts."""

    def __call__(self, sample: GpsSample) -> Counts:
        """Counts by the name of the parameter."""
        ...


class Table2Values:
    """The values themselves, in the units of Table 2 of Basan 2022, within its ranges.

    Altitude, speed and satellites are cut off at the ends of their ranges. Angles are negative in
    half of the world, where no Poisson distribution is: the track angle is shifted by 180° to
    0-360, and latitude and longitude are the change since the first fix, shifted by the 90° and
    180° of their ranges. The track angle therefore leaps by 360 where it passes South.
    """

    def __init__(self, *, within_ranges: bool = True) -> None:
        """Start without a first fix; without ranges nothing is cut off."""
        self._first: FixSample | None = None
        self._within_ranges = within_ranges

    def __call__(self, sample: GpsSample) -> Counts:
        """See Values."""
        if isinstance(sample, SatelliteSample):
            return {"satellites": self._cut(sample.count, SATELLITES)}
        if isinstance(sample, VelocitySample):
            east, north, _ = sample.velocity
            return {
                "speed": float(round(self._cut(math.hypot(east, north), SPEEDS) / SPEED)),
                "track": float(round(math.degrees(math.atan2(east, north))) + 180),
            }
        self._first = first = self._first or sample
        longitude = math.remainder(sample.longitude_deg - first.longitude_deg, 360.0)
        return {
            "altitude": self._altitude(sample),
            "latitude": _shifted(sample.latitude_deg - first.latitude_deg, 90.0),
            "longitude": _shifted(longitude, 180.0),
        }

    def _altitude(self, fix: FixSample) -> float | None:
        if not fix.has_altitude:
            return None
        return float(round(self._cut(fix.altitude_m, ALTITUDES_M) / ALTITUDE_M))

    def _cut(self, value: float, limits: tuple[float, float]) -> float:
        return _within(value, limits) if self._within_ranges else value


class Changes:
    """How far each value is from going on as before, in whole steps.

    Position and height go on with the velocity of the last two fixes, speed, track angle and
    satellites stay. A step is what noise and an ordinary manoeuvre make of a value between two
    fixes, so that a flight has few of them at every rate, and a forged value of some metres many.
    """

    def __init__(self, parameters: KldParameters) -> None:
        """Start without samples."""
        self._parameters = parameters
        self._fixes: list[tuple[int, tuple[float, float, float]]] = []
        self._frame: LocalFrame | None = None
        self._velocity: VelocitySample | None = None
        self._count: int | None = None

    def __call__(self, sample: GpsSample) -> Counts:
        """See Values."""
        if isinstance(sample, SatelliteSample):
            before, self._count = self._count, sample.count
            return {"satellites": None if before is None else float(abs(sample.count - before))}
        if isinstance(sample, VelocitySample):
            last, self._velocity = self._velocity, sample
            return self._motion(last, sample)
        return self._position(sample)

    def _position(self, fix: FixSample) -> Counts:
        """Second differences of height, North and East, in steps."""
        p = self._parameters
        self._frame = frame = self._frame or LocalFrame(fix)
        east, north, _ = frame.enu(fix)
        place = (east, north, fix.altitude_m)
        earlier, self._fixes = self._fixes, [*self._fixes[-1:], (fix.stamp_ns, place)]
        names = ("longitude", "latitude", "altitude")
        if len(earlier) < 2:
            return dict.fromkeys(names)
        (t0, first), (t1, second) = earlier
        before_s, now_s = (t1 - t0) / NANOSECONDS, (fix.stamp_ns - t1) / NANOSECONDS
        ratio = now_s / before_s
        # White noise of three fixes in their second difference, against that of equal times.
        noise_m = p.scale_m * math.sqrt((1.0 + (1.0 + ratio) ** 2 + ratio**2) / 6.0)
        step_m = noise_m + p.acceleration * now_s * 0.5 * (before_s + now_s)
        return {
            name: _steps(abs(c - b - ratio * (b - a)) / step_m)
            for name, a, b, c in zip(names, first, second, place, strict=True)
        }

    def _motion(self, last: VelocitySample | None, now: VelocitySample) -> Counts:
        """Changes of ground speed and track angle, in steps."""
        p = self._parameters
        if last is None:
            return {"speed": None, "track": None}
        seconds = (now.stamp_ns - last.stamp_ns) / NANOSECONDS
        (east, north, _), (e0, n0, _) = now.velocity, last.velocity
        speed, before = math.hypot(east, north), math.hypot(e0, n0)
        counts: dict[str, float | None] = {
            "speed": float(round(abs(speed - before) / (p.acceleration * seconds))),
            "track": None,
        }
        if min(speed, before) > p.min_speed:
            turned = math.degrees(math.atan2(e0 * north - n0 * east, e0 * east + n0 * north))
            counts["track"] = float(round(abs(turned) / (p.turn_rate_deg_s * seconds)))
        return counts


def _steps(value: float) -> float | None:
    """A number in whole steps; None where it was not measured."""
    return None if math.isnan(value) else float(round(value))


def _within(value: float, limits: tuple[float, float]) -> float:
    return min(max(value, limits[0]), limits[1])


def _shifted(change_deg: float, shift_deg: float) -> float:
    """A change of angle in 1e-7 degrees, made positive."""
    return float(round((_within(change_deg, (-shift_deg, shift_deg)) + shift_deg) / ANGLE_DEG))
