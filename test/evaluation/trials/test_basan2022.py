# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The flights of Basan's experiment: how many of what, always the same, forged as the modes say."""

from __future__ import annotations

import pickle
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from hijack_detect.evaluation.trials.basan2022 import (
    ATTACK_S,
    MODES,
    ROUTES,
    basan2022,
    basan2022_on,
    forged,
)
from hijack_detect.simulation.plan import forward_end_s, forward_start_s
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import FixSample, SatelliteSample, VelocitySample

CASES = basan2022()
ROOT = Path(__file__).parents[3]
SECOND = 10**9


def test_every_class_has_as_many_flights_on_every_route() -> None:
    assert Counter(case.kind for case in CASES) == dict.fromkeys(("clean", *MODES), 25)
    assert {(case.kind, case.plan.route) for case in CASES} == {
        (kind, route) for kind in ("clean", *MODES) for route in ROUTES
    }


def test_a_larger_scale_adds_flights_and_changes_none() -> None:
    more = basan2022(3)
    assert (
        len(more) == len({case.name for case in more}) == len({case.seed for case in more}) == 375
    )
    assert all(case in more for case in CASES)
    assert basan2022() == pickle.loads(pickle.dumps(CASES)) == CASES
    for scale in (0, 201):
        with pytest.raises(ValueError, match=f"scale is {scale}"):
            basan2022(scale)


def test_attacks_lie_within_the_flight() -> None:
    for case in CASES:
        if case.scenario is not None:
            (segment,) = case.scenario.segments
            assert segment.end_s == pytest.approx(segment.start_s + ATTACK_S)
            assert forward_start_s(case.plan) + 10.0 < segment.start_s
            assert segment.end_s < forward_end_s(case.plan) + 0.1


def reported(mode: str) -> dict[str, np.ndarray]:
    """What a vehicle at rest is reported to do for 30 s."""
    spoofer = Spoofer(forged(mode, 0.0, 7), 0)
    rows = []
    for index in range(150):
        stamp = index * SECOND // 5
        fix = spoofer.fix(FixSample(stamp, 48.0, 11.0, 500.0, accuracy_m=0.7))
        velocity = spoofer.velocity(VelocitySample(stamp, (0.0, 0.0, 0.0)))
        count = spoofer.satellites(SatelliteSample(stamp, 12))
        rows.append((fix.altitude_m, count.count, fix.accuracy_m, fix.latitude_deg, velocity))
    altitude, count, accuracy, latitude, velocity = zip(*rows, strict=True)
    speeds = [np.hypot(*one.velocity[:2]) for one in velocity]
    return {
        name: np.array(values)
        for name, values in {
            "altitude": altitude,
            "satellites": count,
            "accuracy": accuracy,
            "latitude": latitude,
            "speed": speeds,
        }.items()
    }


@pytest.mark.parametrize(("mode", "sigma_m"), [("soft", 4.21), ("hard_1", 5.52), ("hard_2", 8.34)])
def test_modes_forge_what_the_paper_says(mode: str, sigma_m: float) -> None:
    found = reported(mode)
    # 150 draws: three standard errors of a deviation are a sixth of it.
    assert np.std(found["altitude"]) == pytest.approx(sigma_m, rel=0.17)
    assert found["satellites"].min() >= 9
    assert found["satellites"].max() <= 19
    assert len(set(found["satellites"])) > 8
    assert 1.0 <= found["accuracy"].min() < found["accuracy"].max() <= 5.0
    hard = mode != "soft"
    assert bool(np.ptp(found["latitude"])) is hard
    assert bool(np.ptp(found["speed"])) is hard


def test_smooth_values_wander_slowly() -> None:
    soft, smooth = (np.abs(np.diff(reported(mode)["altitude"])) for mode in ("soft", "smooth"))
    assert np.median(smooth) < 0.1 * np.median(soft)


def test_flights_of_a_folder_are_attacked_in_every_mode() -> None:
    cases = basan2022_on(ROOT / "bags", 2)
    kinds = Counter(case.kind for case in cases)
    assert kinds == {"clean": 3, **dict.fromkeys(MODES, 6)}
    assert len({case.name for case in cases}) == len(cases)
    assert all(case.injected == (case.kind != "clean") for case in cases)
