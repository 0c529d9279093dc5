# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attack families in several sizes, to find how large an attack must be to be seen.

Every attack lasts to the flight's end. What an attack draws (its side or bearing, a fake track's
turns) comes from the flight's name and the onset alone, so that the sizes of a family differ in
size only, and everyone gets the same attacks.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hijack_detect.evaluation.trials.fake_tracks import TRACKS, fake_track_model
from hijack_detect.evaluation.trials.onsets import SHORTEST_S, Span, seeded_onsets
from hijack_detect.spoofing.scenario import Scenario, parse_scenario

REPLAYED_S = 30.0
"""A replay reports the flight of this long before. Chosen, not swept."""
TURN_DEG, TURN_RATE = 60.0, 15.0
"""The turn away: degrees, degrees/s. Chosen, not swept."""
CLIMB_GAIN = 0.5
"""Acceleration of a ramp of altitude, m/s². Chosen, not swept."""
WATCHED_S = 20.0
"""The latest onset lies this long before the flight's end. Chosen, not swept."""
SETTLED_S = 20.0
"""The earliest onset at any phase of flight, seconds. Chosen, not swept."""

Draw = Callable[[np.random.Generator, float], dict[str, Any]]
"""The attack model, as in a scenario file, from random numbers and the onset in seconds."""


@dataclass(frozen=True)
class Size:
    """One size of a family.

    Attributes:
        label: In words, with units.
        draw: Makes the model.
        velocity_consistent: Whether the reported velocity agrees with the position.
        figures: The size as numbers by name: `distance_m`, `acceleration`, `speed`, ...
    """

    label: str
    draw: Draw
    velocity_consistent: bool = True
    figures: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Placed:
    """One attack on one flight.

    Attributes:
        family: Name of its family; CLEAN for none.
        size: Its size in words.
        onset_s: Onset, seconds after the flight's first message.
        scenario: The attack, None for none.
        figures: Its size as numbers by name.
    """

    family: str
    size: str
    onset_s: float
    scenario: Scenario | None
    figures: Mapping[str, float]


CLEAN = "no_attack"
"""The family without attacks: what the same time of the same flight gives by chance."""


def _bearing(rng: np.random.Generator) -> float:
    return round(float(rng.uniform(0.0, 360.0)), 1)


def _side(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def jump(distance_m: float) -> Size:
    """A displacement at once, to any side."""
    return Size(
        f"{distance_m:g} m",
        lambda rng, _: {"type": "jump", "distance_m": distance_m, "bearing_deg": _bearing(rng)},
        figures={"distance_m": distance_m},
    )


def drift(acceleration: float, speed: float, *, velocity_consistent: bool = True) -> Size:
    """A carry-off to any side: m/s² and final m/s of the offset."""
    return Size(
        f"{acceleration:g} m/s² to {speed:g} m/s",
        lambda rng, _: {
            "type": "drift",
            "speed_m_s": speed,
            "onset_acceleration_m_s2": acceleration,
            "bearing_deg": _bearing(rng),
        },
        velocity_consistent,
        {"acceleration": acceleration, "speed": speed},
    )


def turn_away() -> Size:
    """A reported track that turns to either side."""
    return Size(
        f"{TURN_DEG:g}° at {TURN_RATE:g}°/s",
        lambda rng, _: {
            "type": "turn_away",
            "angle_deg": TURN_DEG * _side(rng),
            "rate_deg_s": TURN_RATE,
        },
    )


def track(shape: str) -> Size:
    """A fake track of Feng 2018; its last velocity is held."""
    return Size(shape, lambda rng, _: fake_track_model(shape, rng))


def freeze(velocity: str) -> Size:
    """A position that stands still, with a `frozen`, `zero` or `true` velocity."""
    return Size(f"velocity {velocity}", lambda rng, _: {"type": "freeze", "velocity": velocity})


def climb(rate: float, side: float | None = None) -> Size:
    """An altitude that climbs or sinks at m/s; side 1 climbs, -1 sinks, None draws it.

    Where it sinks, an autopilot that believes it climbs.
    """
    return Size(
        f"{rate:g} m/s",
        lambda rng, _: {
            "type": "altitude",
            "rate_m_s": rate * (side or _side(rng)),
            "onset_acceleration_m_s2": CLIMB_GAIN,
        },
        figures={"rate": rate},
    )


def step(height_m: float) -> Size:
    """An altitude that steps up or down."""
    return Size(
        f"{height_m:g} m",
        lambda rng, _: {"type": "altitude", "step_m": height_m * _side(rng)},
        figures={"height_m": height_m},
    )


def replay() -> Size:
    """Track of half a minute before, or from the first message on."""
    return Size(
        f"{REPLAYED_S:g} s before",
        lambda rng, onset_s: {"type": "replay", "from_s": max(0.0, onset_s - REPLAYED_S)},
    )


DISTANCES_M = (2.0, 5.0, 8.0, 10.0, 15.0, 20.0, 40.0)
ACCELERATIONS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 2.0)
SPEEDS = (1.0, 2.0, 4.0)
"""m, m/s², m/s. Chosen, not swept."""

FAMILIES: Mapping[str, Sequence[Size]] = {
    "jump": tuple(map(jump, DISTANCES_M)),
    "drift": tuple(drift(gain, speed) for gain in ACCELERATIONS for speed in SPEEDS),
    "drift_position_only": tuple(drift(0.4, v, velocity_consistent=False) for v in SPEEDS),
    "turn_away": (turn_away(),),
    "fake_track": tuple(map(track, TRACKS)),
    "freeze": tuple(map(freeze, ("frozen", "zero", "true"))),
    "altitude_ramp": tuple(map(climb, (0.5, 1.0, 2.0))),
    "altitude_step": tuple(map(step, (5.0, 10.0, 20.0))),
    "replay": (replay(),),
}
"""Sizes by family, for vehicles in motion."""
ANY_PHASE: Mapping[str, Sequence[Size]] = {
    "jump_any_phase": FAMILIES["jump"],
    "drift_any_phase": tuple(drift(gain, 4.0) for gain in (0.5, 1.0)),
}
"""Sizes by family, at any phase of flight."""


def scenario_of(family: str, size: Size, flight: str, onset_s: float) -> Scenario:
    """The scenario of an attack, from an onset to the flight's end.

    Args:
        family: Its name, for messages.
        size: The size.
        flight: Name of the flight; with the onset it seeds what is drawn.
        onset_s: Onset, seconds after the flight's first message.
    """
    rng = np.random.default_rng([zlib.crc32(flight.encode()), round(10.0 * onset_s)])
    segment = {
        "name": family,
        "start": onset_s,
        "velocity_consistent": size.velocity_consistent,
        "model": size.draw(rng, onset_s),
    }
    return parse_scenario({"segments": [segment]}, f"{family} {size.label}")


def attacks_on(
    flight: str, spans: Sequence[Span], duration_s: float, *, moving: int = 10, any_phase: int = 5
) -> list[Placed]:
    """Every family on one flight, and at each onset no attack, in order of onset.

    Args:
        flight: Name of the flight.
        spans: Begin and end of each piece of forward flight, see `forward_flight`.
        duration_s: Length of the flight, seconds.
        moving: Onsets in forward flight, for FAMILIES.
        any_phase: Onsets at any phase of flight, for ANY_PHASE.
    """
    latest_s = duration_s - WATCHED_S
    whole = [(SETTLED_S, duration_s + SHORTEST_S)]
    chosen = (
        ("in motion", FAMILIES, seeded_onsets(spans, latest_s, moving, flight)),
        ("any phase", ANY_PHASE, seeded_onsets(whole, latest_s, any_phase, f"{flight} any phase")),
    )
    placed = []
    for phase, families, onsets in chosen:
        for onset_s in onsets:
            placed.append(Placed(CLEAN, phase, onset_s, None, {}))
            placed += [
                Placed(
                    family,
                    size.label,
                    onset_s,
                    scenario_of(family, size, flight, onset_s),
                    size.figures,
                )
                for family, sizes in families.items()
                for size in sizes
            ]
    return sorted(placed, key=lambda one: one.onset_s)
