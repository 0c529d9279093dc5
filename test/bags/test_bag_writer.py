# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Writing bags: round trips, the same bytes, and what is refused."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.bags.encoding import encode_sample
from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, typestore
from hijack_detect.bags.writer import BagWriter
from hijack_detect.streams.messages import CONVERTERS
from hijack_detect.streams.samples import (
    AttitudeSample,
    CourseSample,
    FixSample,
    ImuSample,
    MagneticSample,
    PressureSample,
    Sample,
    VelocitySample,
)

START_NS = 1_700_000_000_000_000_000


STAMPS = st.integers(0, 2**31 * 1_000_000_000 - 1)


def within(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False)


def vectors(limit: float) -> st.SearchStrategy[tuple[float, ...]]:
    return st.tuples(*[within(-limit, limit)] * 3)


def turned(angle: float) -> tuple[float, float, float, float]:
    return (0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2))


ORIENTATIONS = within(-4.0, 4.0).map(turned)
SAMPLES: dict[str, st.SearchStrategy[Any]] = {
    "imu": st.builds(ImuSample, STAMPS, vectors(100.0), vectors(1000.0)),
    "fix": st.builds(
        FixSample, STAMPS, within(-90.0, 90.0), within(-180.0, 180.0), within(-1000.0, 50_000.0)
    )
    | st.builds(lambda stamp: FixSample(stamp, 0.0, 0.0, 0.0, has_fix=False), STAMPS),
    "velocity": st.builds(VelocitySample, STAMPS, vectors(1000.0)),
    "mag": st.builds(MagneticSample, STAMPS, vectors(1.0)),
    "attitude": st.builds(
        AttitudeSample, STAMPS, ORIENTATIONS, within(0.0, 10.0), vectors(100.0), vectors(1000.0)
    )
    | st.builds(
        lambda stamp, rate: AttitudeSample(stamp, None, math.inf, rate, rate),
        STAMPS,
        vectors(100.0),
    ),
    "pressure": st.builds(PressureSample, STAMPS, within(1_000.0, 120_000.0)),
    "course": st.builds(CourseSample, STAMPS, within(-1.0, 1.0), within(-1.0, 1.0)),
}


@pytest.mark.parametrize("name", SAMPLES)
@given(data=st.data())
def test_every_sample_comes_back(name: str, data: st.DataObject) -> None:
    sample = data.draw(SAMPLES[name])
    msgtype, cdr = encode_sample(sample)
    assert CONVERTERS[name](typestore().deserialize_cdr(cdr, msgtype)) == sample


def test_helpers(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.write_bool("/alert", START_NS, True)
        bag.write_count("/satellites", START_NS + 1, 14)
        bag.write_pressure("/pressure", START_NS + 2, 95_000.5)
        bag.write_orientation("/truth", START_NS + 3, (0.0, 0.6, 0.0, 0.8))
        bag.write("/late", ImuSample(START_NS, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)), START_NS + 4)
    with BagReader(tmp_path / "bag") as reader:
        raws = list(reader.messages())
        alert, count, pressure, truth, late = (reader.deserialize(raw) for raw in raws)
    assert [raw.log_ns for raw in raws] == [START_NS + offset for offset in range(5)]
    assert alert.data is True
    assert count.data == 14
    assert pressure.fluid_pressure == 95_000.5
    assert (truth.quaternion.y, truth.quaternion.w) == (0.6, 0.8)
    assert late.header.stamp.nanosec == START_NS % 1_000_000_000


def test_same_input_same_bytes(
    small_bag: Path, small_mcap: bytes, tmp_path: Path, write_small_bag: Callable[..., Path]
) -> None:
    again = write_small_bag(tmp_path / "small")
    assert (again / "small.mcap").read_bytes() == small_mcap
    for file in ("metadata.yaml", "small.mcap"):
        assert (again / file).read_bytes() == (small_bag / file).read_bytes()


def test_metadata_is_what_rosbag2_writes(small_bag: Path) -> None:
    text = (small_bag / "metadata.yaml").read_text()
    information = yaml.safe_load(text)["rosbag2_bagfile_information"]
    assert information["version"] == 9
    assert information["storage_identifier"] == "mcap"
    assert information["relative_file_paths"] == ["small.mcap"]
    assert information["message_count"] == 4600
    assert information["starting_time"]["nanoseconds_since_epoch"] == START_NS
    topics = [entry["topic_metadata"]["name"] for entry in information["topics_with_message_count"]]
    assert topics == ["/imu/data_raw", "/gps/fix", "/gps/vel", "/mag"]


def test_chunks_are_compressed(small_mcap: bytes) -> None:
    assert b"zstd" in small_mcap
    assert len(small_mcap) < 4000 * 200


def test_an_existing_path_is_refused(small_bag: Path) -> None:
    before = (small_bag / "small.mcap").stat()
    with pytest.raises(BagError, match="exists; remove it or choose another name"):
        BagWriter(small_bag)
    assert (small_bag / "small.mcap").stat() == before


def test_a_bag_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(BagError, match="cannot be made"), BagWriter(tmp_path / "file" / "bag"):
        pass


def test_nothing_is_left_after_a_failure(tmp_path: Path) -> None:
    sample = ImuSample(START_NS, (0.0, 0.0, 0.0), (0.0, 0.0, 9.8))
    with pytest.raises(KeyError), BagWriter(tmp_path / "bag") as bag:
        bag.write("/imu/data_raw", sample)
        raise KeyError
    with pytest.raises(BagError, match="no message"), BagWriter(tmp_path / "bag"):
        pass
    assert list(tmp_path.iterdir()) == []


def test_one_type_a_topic(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.write_bool("/a", START_NS, True)
        with pytest.raises(BagError, match=r"/a .* std_msgs/msg/UInt32, before it had"):
            bag.write_count("/a", START_NS, 1)
        with pytest.raises(BagError, match="not known"):
            bag.write_raw("/b", "odd_msgs/msg/Odd", START_NS, b"")


def test_ros_and_the_mcap_library_read_it(small_bag: Path) -> None:
    mcap = pytest.importorskip("mcap.reader", reason="mcap is not installed")
    serialization = pytest.importorskip("rclpy.serialization", reason="ROS 2 is not installed")
    messages = pytest.importorskip("sensor_msgs.msg")
    with BagReader(small_bag) as bag, (small_bag / "small.mcap").open("rb") as stream:
        reader = mcap.make_reader(stream, validate_crcs=True)
        found = [message for _, _, message in reader.iter_messages(topics=["/imu/data_raw"])]
        expected = list(bag.messages(["/imu/data_raw"]))
        assert [message.data for message in found] == [raw.data for raw in expected]
        real = serialization.deserialize_message(found[5].data, messages.Imu)
        ours = bag.deserialize(expected[5])
    assert real.angular_velocity.x == ours.angular_velocity.x
    assert real.linear_acceleration.z == ours.linear_acceleration.z
    assert list(real.orientation_covariance) == [-1.0, *[0.0] * 8]
    assert real.header.stamp.nanosec == ours.header.stamp.nanosec


def test_what_is_no_sample_is_refused() -> None:
    nothing: Sample = None  # type: ignore[assignment]
    with pytest.raises(TypeError, match="no sample"):
        encode_sample(nothing)
