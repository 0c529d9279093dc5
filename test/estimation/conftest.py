# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Errors of an attitude against the truth of a simulated flight."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from hijack_detect.simulation.flight import Flight
from hijack_detect.streams.samples import AttitudeSample


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
def errors() -> Callable[[Flight, list[AttitudeSample]], npt.NDArray[np.float64]]:
    return _errors
