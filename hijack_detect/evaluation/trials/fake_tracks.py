# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Arrays of fake fixes, the attack of Feng 2018, §5: drawn from a seed, matched to any flight."""

from __future__ import annotations

import math

import numpy as np

from hijack_detect.spoofing.scenario import Scenario, parse_scenario

ATTACK_S = 30.0
"""Feng 2018, §5, as docs/reproduction.md has it."""
ROW_S = 0.5
"""Chosen, not swept."""
SPEED = 10.0
"""Speed of the array, m/s; it is scaled to that of the flight."""
TRACKS = ("straight", "turn", "s_shape")
"""Fake tracks, the same on every real route. On a straight route even the straight one leads the
vehicle away: nothing in it shows the autopilot the wind and its own errors."""


def fake_track(
    shape: str, onset_s: float, rng: np.random.Generator, noise_m: float = 0.0
) -> Scenario:
    """An array of fake fixes that starts on the position, course and speed at onset.

    Args:
        shape: `straight` on; a `turn` of 40° to 110° to either side after which it goes
            straight on; or `s_shape`, such a turn and then back to the first direction.
        onset_s: Onset, seconds after the flight's first message.
        rng: Chooses the sides and angles, then the noise.
        noise_m: Standard deviation of the noise, metres.
    """
    model = fake_track_model(shape, rng, noise_m)
    segment = {"name": shape, "start": onset_s, "end": onset_s + ATTACK_S, "model": model}
    return parse_scenario({"segments": [segment]}, f"fake track {shape}")


def fake_track_model(
    shape: str, rng: np.random.Generator, noise_m: float = 0.0
) -> dict[str, object]:
    """The attack model of such a track, as in a scenario file; see `fake_track`."""
    time = np.arange(round(ATTACK_S / ROW_S) + 1) * ROW_S
    steps = np.diff(time) * np.exp(1j * np.interp(time[:-1], *_course(shape, rng)))
    track = np.concatenate([[0.0], np.cumsum(steps)])
    track[1:] += noise_m / SPEED * (rng.normal(size=(2, len(time) - 1)).T @ [1, 1j])
    rows = zip(time.tolist(), track.real.tolist(), track.imag.tolist(), strict=True)
    return {
        "type": "fake_track",
        "frame": "course",
        "speed_scale": "flight",
        "positions": [[t, SPEED * forward, SPEED * left] for t, forward, left in rows],
    }


def _course(shape: str, rng: np.random.Generator) -> tuple[list[float], list[float]]:
    """Times in seconds and the direction of a fake track at these, radians to the left."""
    if shape == "straight":
        return [0.0], [0.0]
    angle = math.radians(rng.uniform(40.0, 110.0)) * rng.choice([-1.0, 1.0])
    turn_s = abs(angle) / math.radians(rng.uniform(15.0, 30.0))
    begin = rng.uniform(0.5, 2.0)
    times, angles = [begin, begin + turn_s], [0.0, float(angle)]
    if shape == "s_shape":
        back = times[-1] + rng.uniform(1.0, 5.0)
        times += [back, back + turn_s]
        angles += [float(angle), 0.0]
    return times, angles
