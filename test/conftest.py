# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Simulated flights with their samples in order of stamp; no deadlines, and Ctrl-C for everyone."""

import signal
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import pytest
from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parent))

from kept import keep_in

from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.streams.samples import Sample

settings.register_profile("machines differ", deadline=None)
settings.load_profile("machines differ")

# A shell starts what it puts into the background with SIGINT ignored, and every program that the
# tests start would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)

Sent = list[tuple[str, Sample]]
INPUTS = ("imu", "fix", "velocity", "mag")


@lru_cache(maxsize=8)
def _flight(route: str, seed: int, duration_s: float = 90.0) -> Flight:
    return generate_flight(FlightPlan(route=route, duration_s=duration_s), seed)


def _samples(flight: Flight, *names: str) -> Sent:
    """Samples of the named inputs in order of stamp, equal stamps in the order of the inputs."""
    given = dict(
        zip(INPUTS, (flight.imu, flight.fixes, flight.velocities, flight.magnetics), strict=True)
    )
    sent = [(name, sample) for name in INPUTS if name in names for sample in given[name]]
    return sorted(sent, key=lambda one: one[1].stamp_ns)


@pytest.fixture(scope="session", autouse=True)
def _kept(tmp_path_factory: pytest.TempPathFactory) -> None:
    keep_in(tmp_path_factory)


@pytest.fixture(scope="session")
def flight() -> Callable[..., Flight]:
    return _flight


@pytest.fixture(scope="session")
def samples() -> Callable[..., Sent]:
    return _samples
