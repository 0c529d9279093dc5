# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Plausibility of forged GPS data: Table 4 of Basan et al. 2022, for every parameter."""

from __future__ import annotations

import math
import statistics
import time
from collections import defaultdict
from collections.abc import Mapping
from typing import Any

from hijack_detect.detectors.kld_values import ALTITUDE_M, ANGLE_DEG, NAMES, SPEED, Table2Values
from hijack_detect.evaluation.scores.model import Model
from hijack_detect.evaluation.trials.basan2022 import MODES, SOFT
from hijack_detect.replay.truth import Attack
from hijack_detect.spoofing.scenario import parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    Sample,
    SatelliteSample,
    VelocitySample,
)

SPAN_NS = 30 * NANOSECONDS
"""Normal data are taken from this long before the attack; a clean flight is judged on as much.
Chosen: the length of the attack, ATTACK_S."""
UNITS = {
    "altitude": (ALTITUDE_M, "m"),
    "satellites": (1.0, ""),
    "speed": (SPEED, "m/s"),
    "track": (1.0, "deg"),
    "latitude": (ANGLE_DEG * 1e5, "1e-5 deg"),
    "longitude": (ANGLE_DEG * 1e5, "1e-5 deg"),
}
"""Factor from the counts of Table 2, and the unit in which a standard deviation is given."""


class ForgedValues(Model):
    """One parameter in the attack on one flight, or in a piece of a clean flight.

    Attributes:
        likelihood: The likelihood function of Table 4, see `likelihood`; 0 for a clean flight.
        sigma: Standard deviation of the values, in the unit of UNITS.
        normal_sigma: The same of the values before the attack, None for a clean flight.
    """

    likelihood: float
    sigma: float
    normal_sigma: float | None


class ForgedData:
    """Collects the reported values of a flight, in the units of Table 2, wherever they lie."""

    def __init__(self) -> None:
        """Start without values."""
        self._counts = Table2Values(within_ranges=False)
        self._values: dict[str, list[tuple[int, float]]] = defaultdict(list)

    def add(self, sample: Sample) -> None:
        """Take any sample of the flight as it was reported."""
        if isinstance(sample, VelocitySample | SatelliteSample) or (
            isinstance(sample, FixSample) and sample.has_fix
        ):
            for name, count in self._counts(sample).items():
                if count is not None:
                    self._values[name].append((sample.stamp_ns, count))

    def quality(self, attack: Attack | None) -> dict[str, ForgedValues]:
        """Every parameter of which there are values, within the attack against before it.

        Without an attack it is the middle of the flight, and the data are normal themselves.
        """
        found = {}
        for name in NAMES:
            values = self._values.get(name, [])
            if not values:
                continue
            factor, _ = UNITS[name]
            if attack is None:
                middle = (values[0][0] + values[-1][0]) // 2
                within = _between(values, middle - SPAN_NS // 2, middle + SPAN_NS // 2)
                normal = within
            else:
                end_ns = values[-1][0] + 1 if attack.end_ns is None else attack.end_ns
                within = _between(values, attack.onset_ns, end_ns)
                normal = _between(values, attack.onset_ns - SPAN_NS, attack.onset_ns)
            if within and normal:
                found[name] = ForgedValues(
                    likelihood=likelihood(within, statistics.fmean(normal)),
                    sigma=factor * statistics.pstdev(within),
                    normal_sigma=None if attack is None else factor * statistics.pstdev(normal),
                )
        return found


def likelihood(values: list[float], mean: float) -> float:
    """`d ln L / dλ` of Poisson's likelihood L (§3.2) at the mean λ of normal data: `Σ x / λ - n`.

    The paper's Table 4 calls its figures the likelihood function, and states that they are zero
    without an attack because the normal data gave λ, that they depend on the number of values, and
    shows negative ones where the altitude fell. L itself is none of that; its derivative is zero at
    the mean of the data, grows with their number and has the sign of the change.

    Args:
        values: Counts x.
        mean: λ; without any the values are counts of nothing, and the result is 0.
    """
    return math.fsum(values) / mean - len(values) if mean > 0.0 else 0.0


def _between(values: list[tuple[int, float]], first_ns: int, end_ns: int) -> list[float]:
    return [value for stamp_ns, value in values if first_ns <= stamp_ns < end_ns]


FIXES = 500
"""Timed updates of one kind. Chosen, not swept."""
STEPS: Mapping[str, Mapping[str, Any]] = {
    "satellites": {"altitude_sigma_m": 0.0, "satellites": SOFT["satellites"]},
    "satellites, altitude": {name: SOFT[name] for name in ("altitude_sigma_m", "satellites")},
    "satellites, altitude, noise level": SOFT,
    "all": MODES["hard_1"],
}
"""One parameter, then more of them one at a time, then all (§3.2)."""


class ForgingTime(Model):
    """Median time to forge the values of one update of the receiver.

    Attributes:
        parameters: What is forged.
        microseconds: For one fix, velocity and number of satellites.
    """

    parameters: str
    microseconds: float


def forging_times() -> list[ForgingTime]:
    """Measure each of STEPS on this machine; the passing of true values is counted too."""
    return [
        ForgingTime(parameters=name, microseconds=round(1e6 * _median_s(model), 1))
        for name, model in STEPS.items()
    ]


def _median_s(model: Mapping[str, Any]) -> float:
    segment = {"start": 0.0, "model": {"type": "forge", "seed": 1, **model}}
    spoofer = Spoofer(parse_scenario({"segments": [segment]}), 0)
    times = []
    for index in range(FIXES):
        stamp_ns = index * NANOSECONDS // 5
        fix = FixSample(stamp_ns, 48.0, 11.0, 500.0, accuracy_m=1.0)
        velocity, count = VelocitySample(stamp_ns, (8.0, 0.0, 0.0)), SatelliteSample(stamp_ns, 12)
        began = time.perf_counter()
        spoofer.fix(fix)
        spoofer.velocity(velocity)
        spoofer.satellites(count)
        times.append(time.perf_counter() - began)
    return statistics.median(times)
