# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Closed-form flights whose reported velocity is the exact derivative of their position."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import pymap3d
import pytest
from pymap3d.ecef import enu2uvw, uvw2enu

from hijack_detect.spoofing.scenario import parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import NANOSECONDS, FixSample, VelocitySample

FIRST_NS = 1_700_000_000 * NANOSECONDS


@dataclass(frozen=True)
class Flight:
    """Fixes and velocities with the same stamps."""

    fixes: tuple[FixSample, ...]
    velocities: tuple[VelocitySample, ...]
    first_ns: int = FIRST_NS

    def at(self, t_s: float) -> int:
        """Index of the sample at a time."""
        stamp = self.first_ns + round(t_s * NANOSECONDS)
        return next(i for i, fix in enumerate(self.fixes) if fix.stamp_ns >= stamp)


def straight(t: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """4 m/s East and 3 m/s North, level."""
    return (4.0 * t, 3.0 * t, 0.0), (4.0, 3.0, 0.0)


def waving(t: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """A curved flight that climbs and sinks."""
    position = (5.0 * t, 40.0 * math.sin(0.1 * t), 3.0 * math.sin(0.2 * t))
    return position, (5.0, 4.0 * math.cos(0.1 * t), 0.6 * math.cos(0.2 * t))


def hover(t: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Standing still."""
    return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


PATHS = {"straight": straight, "waving": waving, "hover": hover}


def make_flight(
    path: str = "straight",
    latitude: float = 47.0,
    longitude: float = 8.0,
    seconds: float = 30.0,
    rate_hz: int = 5,
) -> Flight:
    """Fly a path from a place, 500 m up."""
    fixes, velocities = [], []
    for index in range(round(seconds * rate_hz) + 1):
        stamp = FIRST_NS + index * NANOSECONDS // rate_hz
        (east, north, up), (v_east, v_north, v_up) = PATHS[path](index / rate_hz)
        here = pymap3d.enu2geodetic(east, north, 0.0, latitude, longitude, 500.0)
        place = (float(here[0]), float(here[1]))
        uvw = enu2uvw(v_east, v_north, 0.0, latitude, longitude)
        v_east, v_north, _ = (float(part) for part in uvw2enu(*uvw, *place))
        fixes.append(FixSample(stamp, *place, 500.0 + up))
        velocities.append(VelocitySample(stamp, (v_east, v_north, v_up)))
    return Flight(tuple(fixes), tuple(velocities))


def run(flight: Flight, scenario: dict[str, object] | str, order: str = "fv") -> Flight:
    """Spoof a flight, at each stamp the fix first (`fv`) or the velocity first (`vf`).

    Order `mixed` alternates, `f` leaves velocities out.
    """
    spoofer = Spoofer(parse_scenario(scenario), flight.first_ns)
    fixes, velocities = [], []
    for index, (fix, velocity) in enumerate(zip(flight.fixes, flight.velocities, strict=True)):
        turn = ("fv", "vf")[index % 2] if order == "mixed" else order
        for kind in turn:
            if kind == "f":
                fixes.append(spoofer.fix(fix))
            else:
                velocities.append(spoofer.velocity(velocity))
    return Flight(tuple(fixes), tuple(velocities))


def one_segment(model: dict[str, object], **keys: object) -> dict[str, object]:
    """Scenario of one segment from 10 to 20 s unless told otherwise."""
    return {"segments": [{"start": 10.0, "end": 20.0, "model": model, **keys}]}


def enu(fix: FixSample, origin: FixSample) -> tuple[float, float, float]:
    """Position of one fix about another, metres."""
    return tuple(  # type: ignore[return-value]
        float(value)
        for value in pymap3d.geodetic2enu(
            fix.latitude_deg,
            fix.longitude_deg,
            fix.altitude_m,
            origin.latitude_deg,
            origin.longitude_deg,
            origin.altitude_m,
        )
    )


def derivative(before: FixSample, here: FixSample, after: FixSample) -> tuple[float, float, float]:
    """Central difference of position at `here`, m/s in its East and North; up from altitude."""
    seconds = (after.stamp_ns - before.stamp_ns) / NANOSECONDS
    a, b = enu(after, here), enu(before, here)
    climb = (after.altitude_m - before.altitude_m) / seconds
    return ((a[0] - b[0]) / seconds, (a[1] - b[1]) / seconds, climb)


class Tools:
    """The helpers of this file, for tests that cannot import it."""

    Flight = Flight
    flight = staticmethod(make_flight)
    run = staticmethod(run)
    one_segment = staticmethod(one_segment)
    enu = staticmethod(enu)
    derivative = staticmethod(derivative)


@pytest.fixture(scope="session")
def tools() -> type[Tools]:
    """Flights, runs and geometry."""
    return Tools


@pytest.fixture(scope="session")
def reported() -> Callable[..., Flight]:
    """Return what a model makes of a path: `reported(model, path, order, **segment keys)`."""

    def spoof(
        model: dict[str, object], path: str = "straight", order: str = "fv", **keys: object
    ) -> Flight:
        return run(make_flight(path), one_segment(model, **keys), order)

    return spoof
