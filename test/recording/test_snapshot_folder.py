# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Snapshots on disk: whole bags under names of their own, so many and no more."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from recorded import SECOND, START_NS, imu
from rosbags.highlevel import AnyReader

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.recording.parameters import MEGABYTE, RecorderParameters
from hijack_detect.recording.snapshots import Snapshot, SnapshotFolder

NAME = "alert_20261125T133510.123Z"


def folder(path: Path, **parameters: Any) -> SnapshotFolder:
    return SnapshotFolder(path, RecorderParameters(**parameters))


def snapshot(name: str = NAME, part: int = 0, kind: str = "sensor_msgs/msg/Imu") -> Snapshot:
    stamps = range(START_NS, START_NS + SECOND, SECOND // 50)
    messages = [RawMessage("/drone1/imu/data_raw", kind, stamp, imu(stamp)) for stamp in stamps]
    return Snapshot(name, part, (START_NS,), messages)


def names(path: Path) -> list[str]:
    return sorted(os.listdir(path))


def test_a_snapshot_is_a_bag_for_us_and_for_rosbags(tmp_path: Path) -> None:
    written = folder(tmp_path / "deep/snapshots").write(snapshot())
    bag = tmp_path / "deep/snapshots" / NAME
    assert names(bag) == [f"{NAME}.mcap", "metadata.yaml"]
    assert written.size == sum(path.stat().st_size for path in bag.iterdir())
    with BagReader(bag) as reader:
        assert [one.data for one in reader.messages()] == [
            one.data for one in written.snapshot.messages
        ]
    with AnyReader([bag]) as reader:
        for connection, log_ns, data in reader.messages():
            message: Any = reader.deserialize(data, connection.msgtype)
            assert message.header.stamp.sec * SECOND + message.header.stamp.nanosec == log_ns


def test_a_name_in_use_gets_a_number(tmp_path: Path) -> None:
    made = folder(tmp_path)
    assert made.unused(NAME) == NAME
    made.write(snapshot(part=1))
    assert made.unused(NAME) == f"{NAME}_2"
    made.write(snapshot(f"{NAME}_2"))
    assert made.unused(NAME) == f"{NAME}_3"
    with pytest.raises(OSError, match="not empty"):
        made.write(snapshot(part=1))


def test_what_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    made = folder(tmp_path)
    with pytest.raises(BagError, match="not known"):
        made.write(snapshot(kind="some_msgs/msg/Thing"))
    assert names(tmp_path) == []


def test_what_a_killed_run_left_is_removed(tmp_path: Path) -> None:
    made = folder(tmp_path)
    for part in (1, 2, 0):
        made.write(snapshot(part=part))
    made.write(snapshot("alert_b", part=1))
    made.write(snapshot("alert_b", part=10))
    for left in (".writing", f".writing-{NAME}.part1"):
        (tmp_path / left / "bag").mkdir(parents=True)
    made.clean()
    assert sorted(made.superseded()) == [f"{NAME}.part1", f"{NAME}.part2", "alert_b.part1"]
    made.remove(made.superseded())
    assert names(tmp_path) == [NAME, "alert_b.part10"]
    made.remove(["alert_never_there"])


def test_the_oldest_written_goes_first_and_the_newest_stays(tmp_path: Path) -> None:
    made = folder(tmp_path, max_snapshots=3)
    for number, name in enumerate(("alert_z", "alert_y", "alert_x", "alert_a")):
        written = made.write(snapshot(name))
        os.utime(tmp_path / name, (number, number))
        assert written.excess == (("alert_z",) if name == "alert_a" else ())
    made.remove(written.excess)
    assert names(tmp_path) == ["alert_a", "alert_x", "alert_y"]


def test_bytes_are_bounded_too(tmp_path: Path) -> None:
    made = folder(tmp_path, snapshots_max_mb=1)
    for number in range(2):
        made.write(snapshot(f"alert_{number}"))
        (tmp_path / f"alert_{number}/more").write_bytes(bytes(MEGABYTE))
        os.utime(tmp_path / f"alert_{number}", (number, number))
    assert made.write(snapshot("alert_2")).excess == ("alert_0", "alert_1")
