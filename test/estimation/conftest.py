"""Simulated flights with their samples in order of stamp, and errors against the truth."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.streams.samples import AttitudeSample, Sample

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


def _errors(flight: Flight, attitudes: list[AttitudeSample]) -> npt.NDArray[np.float64]:
    """Seconds from the start and errors of roll, pitch and yaw in degrees, shape (n, 4)."""
    known = [one for one in attitudes if one.orientation is not None]
    stamps = np.array([one.stamp_ns for one in known]) - flight.plan.start_ns
    rows = np.searchsorted(flight.motion.offsets_ns, stamps)
    assert np.array_equal(flight.motion.offsets_ns[rows], stamps)
    estimate = Rotation.from_quat([one.orientation for one in known]).as_euler("ZYX")
    truth = Rotation.from_quat(flight.motion.quaternion[rows]).as_euler("ZYX")
    wrapped = (np.degrees(estimate - truth) + 180.0) % 360.0 - 180.0
    return np.column_stack([stamps / 1e9, wrapped[:, ::-1]])


@pytest.fixture(scope="session")
def flight() -> Callable[..., Flight]:
    return _flight


@pytest.fixture(scope="session")
def samples() -> Callable[..., Sent]:
    return _samples


@pytest.fixture(scope="session")
def errors() -> Callable[[Flight, list[AttitudeSample]], npt.NDArray[np.float64]]:
    return _errors
