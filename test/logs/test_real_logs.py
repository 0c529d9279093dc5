# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Logs of real autopilots: what they bring, and that the monitor believes them."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ros import ROOT
from scipy.spatial.transform import Rotation

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import read_samples
from hijack_detect.logs.formats import Converted, convert
from hijack_detect.logs.logged import ATTITUDE
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.offline import outputs_of
from hijack_detect.streams.samples import FixSample

pytest.importorskip("pymavlink", reason="the extra logs is not installed")
pytest.importorskip("pyulog", reason="the extra logs is not installed")

FLIGHTS = ROOT.parent / "shared/flights"
LOGS = FLIGHTS / "logs"
pytestmark = pytest.mark.skipif(not LOGS.is_dir(), reason=f"{LOGS} is not there")
SAME = {
    "arducopter_3.3_218.BIN": "erlerobot__5-12-2014_218",
    "arducopter_3.3_log171.bin": "dronekit_la__log171",
}
"""Logs and the bags that somebody else has made of them: without compass and barometer."""
CALM = 0.3
"""m/s² by which the mean specific force of a calm second differs from gravity, at most."""
COMMON = ("imu", "fix", "velocity", "satellites")


@pytest.fixture(scope="module")
def converted(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Converted]]:
    folder = tmp_path_factory.mktemp("logs")
    return {
        log.name: (folder / log.name, convert(log, folder / log.name)) for log in LOGS.iterdir()
    }


def samples(bag: Path, *names: str) -> list[tuple[str, Any]]:
    with BagReader(bag) as reader:
        found = read_samples(reader, reader.inputs(), on_rejected=lambda _: None)
        return [one for one in found if not names or one[0] in names]


def first_ns(found: list[tuple[str, Any]]) -> int:
    """Stamp of the first reading of the IMU."""
    return next(int(sample.stamp_ns) for name, sample in found if name == "imu")


def alerts(bag: Path, *inputs: str) -> list[float]:
    """Seconds of the first results with an alert."""
    monitor, found = Monitor(policy_parameters("default")), samples(bag, *inputs)
    said = [one for part, one in outputs_of(found, monitor) if part == "fusion"]
    assert len(said) > 1000
    return [(one.stamp_ns - first_ns(found)) / 1e9 for one in said if one.alert][:1]


def test_all_are_imported_and_say_what_they_are(
    converted: dict[str, tuple[Path, Converted]],
) -> None:
    formats = {name: done.format for name, (_, done) in converted.items()}
    assert formats == {
        "px4_v6xrt.ulg": "PX4 ULog",
        "husky_ros1.bag": "ROS 1 bag",
        **dict.fromkeys(SAME, "ArduPilot DataFlash"),
    }
    said = " ".join(converted["px4_v6xrt.ulg"][1].notes.lines())
    assert "no subscription found for message id 32812" in said
    assert all(
        done.messages["/imu/data_raw"] > 10_000 and done.messages["/gps/fix"] > 50
        for _, done in converted.values()
    )


def test_a_clock_at_twelve_thirteenths_is_corrected(
    converted: dict[str, tuple[Path, Converted]],
) -> None:
    name = "arducopter_3.3_218.BIN"
    ours, theirs = (
        [one.stamp_ns for of, one in found if of == "fix"]
        for found in (
            samples(converted[name][0], *COMMON),
            samples(FLIGHTS / "bags" / SAME[name]),
        )
    )
    assert "clock runs 7.7 % slow" in " ".join(converted[name][1].notes.lines())
    assert (ours[-1] - ours[0]) / (theirs[-1] - theirs[0]) == pytest.approx(13 / 12, rel=2e-3)


def test_readings_are_those_of_the_bag_of_the_same_flight(
    converted: dict[str, tuple[Path, Converted]],
) -> None:
    name = "arducopter_3.3_log171.bin"
    ours, theirs = samples(converted[name][0], *COMMON), samples(FLIGHTS / "bags" / SAME[name])
    shift_ns = first_ns(ours) - first_ns(theirs)
    for kind, least in (("imu", 10_000), ("fix", 800), ("velocity", 800)):
        mine = {one.stamp_ns - shift_ns: one for of, one in ours if of == kind}
        shared = 0
        for of, their in theirs:
            one = None if of != kind else mine.get(their.stamp_ns) or mine.get(their.stamp_ns + 1)
            if one is not None:
                shared += 1
                if isinstance(one, FixSample):  # the bag has no accuracy
                    one = replace(one, accuracy_m=None, vertical_accuracy_m=None)
                assert repr(one).split(", ", 1)[1] == repr(their).split(", ", 1)[1]
        assert shared > least


@pytest.mark.slow
def test_the_log_and_the_bag_give_the_same_alerts_and_both_none(
    converted: dict[str, tuple[Path, Converted]],
) -> None:
    name = "arducopter_3.3_log171.bin"
    assert alerts(FLIGHTS / "bags" / SAME[name]) == alerts(converted[name][0], *COMMON) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", SAME)
def test_compass_and_barometer_of_a_clean_flight_raise_no_alert(
    converted: dict[str, tuple[Path, Converted]], name: str
) -> None:
    assert alerts(converted[name][0]) == []


@pytest.mark.parametrize("name", [*SAME, "px4_v6xrt.ulg"])
def test_gravity_points_down_in_the_autopilots_own_attitude(
    converted: dict[str, tuple[Path, Converted]], name: str
) -> None:
    """The specific force of a second, turned by the attitude, is gravity upwards."""
    forces = np.array(
        [(one.stamp_ns, *one.specific_force) for _, one in samples(converted[name][0], "imu")],
        dtype=float,
    )
    with BagReader(converted[name][0]) as reader:
        turns = []
        for raw in reader.messages([ATTITUDE]):
            q = reader.deserialize(raw).quaternion
            turns.append((raw.log_ns, q.x, q.y, q.z, q.w))
    angles = []
    for stamp, *quaternion in turns[::20]:
        near = forces[np.abs(forces[:, 0] - stamp) < 0.5e9, 1:].mean(axis=0)
        if abs(np.linalg.norm(near) - 9.8) > CALM:
            continue
        up = Rotation.from_quat(quaternion).apply(near)
        angles.append(math.degrees(math.acos(up[2] / np.linalg.norm(up))))
    assert len(angles) > 50
    assert np.median(angles) < 4.0
    assert np.percentile(angles, 90) < 15.0
