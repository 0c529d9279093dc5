# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The label of a simulated flight: what was flown, and what the attack did to it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hijack_detect.simulation.flight import Flight
from hijack_detect.simulation.plan import GROUND_S
from hijack_detect.spoofing import schema
from hijack_detect.spoofing.forge_schema import Forge
from hijack_detect.spoofing.plane import TangentPlane
from hijack_detect.spoofing.scenario import Scenario

DEVIATED_M = 4.0
"""Metres from its target at which a vehicle has left its route; its own control and the noise of
an honest GPS take it up to 3.5 m away."""


def flight_label(name: str, flight: Flight, scenario: Scenario | None) -> dict[str, Any]:
    """Describe a flight; times are seconds from its first message.

    Args:
        name: Name of the bag.
        flight: The flight.
        scenario: The attacks that it was flown under.

    Returns:
        Plain data: id, kind (`straight`, `curved`, `hardneg` for what tempts a detector without
        an attack, `hijack`), route, yaw (`path` or `fixed`), speed, wind (m/s; direction it
        comes from, degrees clockwise from North; deviation of the gusts), GPS errors, times, and
        the attack or None.
    """
    conditions = flight.conditions
    blows_to = math.degrees(conditions.wind_direction)
    route = flight.plan.route
    kind = route if route in ("straight", "curved") else "hardneg"
    return {
        "id": name,
        "kind": kind if scenario is None else "hijack",
        "route": route,
        "yaw": "fixed" if route in ("hover", "fixed_yaw") else "path",
        "speed_m_s": 0.0 if route == "hover" else round(conditions.speed, 2),
        "wind": {
            "spd": round(conditions.wind_m_s, 2),
            "dir": round((270.0 - blows_to) % 360.0, 1),
            "turb": round(conditions.gust_m_s, 2),
        },
        "gps_noise": {
            "sig_h": round(conditions.fix_noise_m, 2),
            "tau": round(conditions.fix_noise_s, 1),
            "white": round(conditions.fix_white_m, 3),
            "verr": round(conditions.velocity_noise_m_s, 3),
            "lag_ms": round(1e3 * conditions.gps_lag_s),
        },
        "t_takeoff": GROUND_S,
        "t_forward_start": flight.forward_start_s,
        "t_forward_end": flight.forward_end_s,
        "duration": flight.plan.duration_s,
        "attack": None if scenario is None else _attack(flight, scenario),
    }


def attack_label(scenario: Scenario, end_s: float) -> dict[str, Any]:
    """What is known of an attack before it is flown: kind, parameters, and when, in seconds."""
    segments = scenario.segments
    return {
        "kind": "+".join(dict.fromkeys(segment.model.type for segment in segments)),
        "params": {"segments": [one.model_dump(mode="json", by_alias=True) for one in segments]},
        "t_start": segments[0].start_s,
        "t_end": end_s,
    }


def _attack(flight: Flight, scenario: Scenario) -> dict[str, Any]:
    """Describe the attacks, and how far they took reports and vehicle apart."""
    segments = scenario.segments
    horizontal, vertical = _separations(flight)
    start_s = segments[0].start_s
    end_s = flight.plan.duration_s if segments[-1].end_s is None else segments[-1].end_s
    motion = flight.motion
    time = motion.offsets_ns / 1e9
    attacked = (time >= start_s) & (time < end_s)
    away = np.linalg.norm(motion.position - motion.target, axis=1)[attacked]
    return {
        **attack_label(scenario, end_s),
        "t_ramp_end": min(_ramp_end_s(segments[-1]), end_s),
        "max_separation_h_m": round(horizontal, 1),
        "max_separation_v_m": round(vertical, 1),
        "max_deviation_m": round(float(away.max()), 1),
        "real_drone_deviated": bool(away.max() > DEVIATED_M),
    }


def _separations(flight: Flight) -> tuple[float, float]:
    """Largest horizontal and vertical distance of a measured and its reported fix, metres."""
    apart = [
        TangentPlane(measured).enu(reported)
        for measured, reported in zip(flight.measured_fixes, flight.fixes, strict=True)
    ]
    return max(math.hypot(x, y) for x, y, _ in apart), max(abs(z) for _, _, z in apart)


def _ramp_end_s(segment: schema.Segment) -> float:
    """When the offset between truth and report stops to grow; infinite if it never does."""
    model = segment.model
    still = isinstance(model, schema.Jump | schema.Jitter)
    if still or (isinstance(model, schema.Altitude) and model.rate_m_s == 0.0):
        return segment.start_s
    if isinstance(model, Forge) and model.drift_speed_m_s == 0.0:
        return segment.start_s
    return math.inf
