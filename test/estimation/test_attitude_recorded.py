# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The attitude estimator on recorded flights, against truth or the autopilot's own attitude."""

import json
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import read_samples
from hijack_detect.bags.topics import topic_map
from hijack_detect.estimation.attitude import AttitudeEstimator
from hijack_detect.estimation.attitude_parameters import AttitudeParameters

FLIGHTS = Path(__file__).parents[2] / ".." / "shared" / "flights"
GPS = ("imu", "fix", "velocity")

pytestmark = pytest.mark.skipif(
    not FLIGHTS.is_dir(), reason="the recorded flights (../shared/flights) are not here"
)


def rms_errors(
    path: Path, inputs: tuple[str, ...], reference: str, from_s: float
) -> npt.NDArray[np.float64]:
    """RMS of roll, pitch and yaw errors in degrees, from some seconds after the first message."""
    stamps, expected = [], []
    with BagReader(path) as bag:
        samples = read_samples(bag, topic_map("auto", bag.topics))
        sent = [(name, one) for name, one in samples if name in inputs]
        for raw in bag.messages([reference]):
            message = bag.deserialize(raw)
            stamp, q = message.header.stamp, message.quaternion
            stamps.append(stamp.sec * 10**9 + stamp.nanosec)
            expected.append((q.x, q.y, q.z, q.w))
        start_ns = bag.start_ns + round(from_s * 1e9)
    sent.sort(key=lambda one: one[1].stamp_ns)
    estimator = AttitudeEstimator(AttitudeParameters())
    outputs = [estimator.update(name, one) for name, one in sent]
    attitudes = [one for one in outputs if one is not None]
    times = np.array([one.stamp_ns for one in attitudes])
    rows = np.searchsorted(times, stamps)
    wanted = np.flatnonzero((np.array(stamps) >= start_ns) & (rows < len(times)))
    found = [attitudes[rows[k]].orientation for k in wanted]
    assert len(found) > 300
    # The first seconds of a straight flight may pass before the heading settles.
    known = [k for k, q in enumerate(found) if q is not None]
    assert len(known) > 0.9 * len(found)
    estimate = Rotation.from_quat([found[k] for k in known]).as_euler("ZYX", degrees=True)
    truth = Rotation.from_quat([expected[wanted[k]] for k in known]).as_euler("ZYX", degrees=True)
    wrapped = (estimate - truth + 180.0) % 360.0 - 180.0
    result: npt.NDArray[np.float64] = np.sqrt(np.mean(np.square(wrapped), axis=0))[::-1]
    return result


def take_off_s(path: Path) -> float:
    label = json.loads((path / "label.json").read_text())
    return float(label["t_takeoff"])


@pytest.mark.parametrize("name", ["dev_008_curved", "dev_011_curved", "dev_015_curved"])
def test_curved_flight_without_magnetometer(name: str) -> None:
    path = FLIGHTS / "sitl" / name
    roll, pitch, yaw = rms_errors(path, GPS, "/truth/attitude", take_off_s(path) + 20.0)
    assert roll <= 1.5
    assert pitch <= 1.5
    assert yaw <= 5.0


@pytest.mark.parametrize("name", ["dev_002_straight", "dev_003_straight"])
def test_straight_flight_with_magnetometer(name: str) -> None:
    path = FLIGHTS / "sitl" / name
    inputs = (*GPS, "mag")
    roll, pitch, yaw = rms_errors(path, inputs, "/truth/attitude", take_off_s(path) + 20.0)
    assert roll <= 1.5
    assert pitch <= 1.5
    assert yaw <= 5.0


def test_recorded_quadrotor() -> None:
    path = FLIGHTS / "bags" / "inertialnav__quad106"
    roll, pitch, _ = rms_errors(path, GPS, "/autopilot/attitude", 60.0)
    assert roll <= 3.0
    assert pitch <= 3.0
