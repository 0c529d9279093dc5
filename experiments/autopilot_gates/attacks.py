# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The attacks that are put into recorded flights."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hijack_detect.evaluation.trials.fake_tracks import fake_track
from hijack_detect.evaluation.trials.protocols import NOISE_M
from hijack_detect.spoofing.scenario import Scenario, parse_scenario

ATTACK_S = 60.0
"""Length of every attack but the fake track, whose array lasts 30 s."""


def drift(acceleration: float, speed: float, bearing_deg: float) -> dict[str, Any]:
    """A carry-off that builds up to a speed, m/s, with an acceleration, m/s²."""
    return {
        "type": "drift",
        "speed_m_s": speed,
        "onset_acceleration_m_s2": acceleration,
        "bearing_deg": bearing_deg,
        "relative": True,
    }


def models(bearing_deg: float) -> dict[str, dict[str, Any]]:
    """Attack models by name; the bearing counts from the course at onset, degrees."""
    jumps = {
        f"jump {distance:g} m": {
            "type": "jump",
            "distance_m": distance,
            "bearing_deg": bearing_deg,
            "relative": True,
        }
        for distance in (5.0, 10.0, 20.0, 40.0)
    }
    drifts = {
        f"drift {acceleration:g} m/s² to {speed:g} m/s": drift(acceleration, speed, bearing_deg)
        for acceleration, speed in ((0.2, 1.0), (0.2, 2.0), (0.2, 4.0), (0.5, 4.0), (1.0, 4.0))
    }
    return {
        **jumps,
        **drifts,
        "position-only drift 0.5 m/s² to 2 m/s": drift(0.5, 2.0, bearing_deg),
        "turn-away 60°": {"type": "turn_away", "angle_deg": -60.0, "rate_deg_s": 15.0},
        "freeze": {"type": "freeze"},
        "altitude 1 m/s": {"type": "altitude", "rate_m_s": 1.0, "onset_acceleration_m_s2": 0.5},
    }


def scenarios(onset_s: float, number: int) -> Mapping[str, Scenario]:
    """Every attack at one onset; drifts and jumps go forward, right, back and left in turn.

    Args:
        onset_s: Seconds after the flight's first message.
        number: The onset's number in its flight; also seeds the fake track.
    """
    found = {}
    for name, model in models(90.0 * (number % 4)).items():
        segment = {
            "start": onset_s,
            "end": onset_s + ATTACK_S,
            "velocity_consistent": not name.startswith("position-only"),
            "model": model,
        }
        found[name] = parse_scenario({"segments": [segment]}, name)
    rng = np.random.default_rng(number)
    found["fake track, a turn"] = fake_track("turn", onset_s, rng, NOISE_M)
    return found
