# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The time that forging takes: Basan et al. 2022, §3.2, "the time spent on simulating the data"."""

from __future__ import annotations

import statistics
import time
from collections.abc import Mapping
from typing import Any

from hijack_detect.evaluation.scores.model import Model
from hijack_detect.evaluation.trials.basan2022 import MODES, SOFT
from hijack_detect.spoofing.scenario import parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    SatelliteSample,
    VelocitySample,
)

FIXES = 500
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
