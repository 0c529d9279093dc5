# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Reading bags that are as they should be."""

from collections.abc import Callable
from pathlib import Path

import pytest
from rosbags.rosbag2 import Reader

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.bags.topics import PRESETS

ROOT = Path(__file__).parents[2]
START_NS = 1_700_000_000_000_000_000


FLIGHTS = ROOT.parent / "shared" / "flights"


def test_summary(small_bag: Path) -> None:
    with BagReader(small_bag) as bag:
        assert bag.message_counts == {
            "/imu/data_raw": 4000,
            "/gps/fix": 200,
            "/gps/vel": 200,
            "/mag": 200,
        }
        assert bag.topics["/gps/fix"] == "sensor_msgs/msg/NavSatFix"
        assert (bag.start_ns, bag.end_ns) == (START_NS, START_NS + 39_990_000_000)
        assert bag.duration_s == 39.99
        bag.require(PRESETS["default"])


def test_same_messages_as_rosbags(small_bag: Path) -> None:
    with Reader(small_bag) as reference, BagReader(small_bag) as bag:
        expected = [(c.topic, c.msgtype, t, bytes(d)) for c, t, d in reference.messages()]
        found = [(m.topic, m.msgtype, m.log_ns, m.data) for m in bag.messages()]
    assert found == expected


def test_directory_bare_file_and_directory_without_metadata_are_the_same(
    small_bag: Path, small_mcap: bytes, tmp_path: Path
) -> None:
    (tmp_path / "copy.mcap").write_bytes(small_mcap)
    bags = [small_bag, small_bag / "small.mcap", tmp_path]
    found = []
    for path in bags:
        with BagReader(path) as bag:
            found.append(list(bag.messages()))
    first, second, third = found
    assert first == second == third


def test_split_bag_is_one_bag(tmp_path: Path, write_small_bag: Callable[..., Path]) -> None:
    one = write_small_bag(tmp_path / "one", topics=("/imu/data_raw",))
    two = write_small_bag(tmp_path / "two", topics=("/gps/fix",))
    (one / "two.mcap").write_bytes((two / "two.mcap").read_bytes())
    metadata = (one / "metadata.yaml").read_text()
    listed = metadata.replace("  - one.mcap\n", "  - one.mcap\n  - two.mcap\n")
    assert listed != metadata
    (one / "metadata.yaml").write_text(listed)
    with BagReader(one) as bag:
        assert bag.message_counts == {"/imu/data_raw": 4000, "/gps/fix": 200}
        times = [message.log_ns for message in bag.messages()]
    assert times == sorted(times)


def test_topics_and_times_are_chosen(small_bag: Path) -> None:
    start, end = START_NS + 10_000_000_000, START_NS + 12_000_000_000
    with BagReader(small_bag) as bag:
        found = list(bag.messages(["/gps/fix", "/mag"], start, end))
        assert {message.topic for message in found} == {"/gps/fix", "/mag"}
        assert [m.log_ns for m in found if m.topic == "/mag"] == list(
            range(start, end, 200_000_000)
        )
        assert list(bag.messages([])) == []


@pytest.mark.parametrize("chunked", [True, False])
@pytest.mark.parametrize("statistics", [True, False])
@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_other_writers(
    small_bag: Path, tmp_path: Path, chunked: bool, statistics: bool, compression: str
) -> None:
    mcap = pytest.importorskip("mcap.writer", reason="mcap is not installed")
    with BagReader(small_bag) as bag:
        messages = list(bag.messages())
    file = tmp_path / "other.mcap"
    with file.open("wb") as stream:
        writer = mcap.Writer(
            stream,
            chunk_size=20_000,
            compression=mcap.CompressionType[compression],
            use_chunking=chunked,
            use_statistics=statistics,
        )
        writer.start("ros2", "test")
        channels = {}
        for message in messages:
            if message.topic not in channels:
                schema = writer.register_schema(message.msgtype, "ros2msg", b"")
                channels[message.topic] = writer.register_channel(message.topic, "cdr", schema)
            writer.add_message(
                channels[message.topic], message.log_ns, message.data, message.log_ns
            )
        writer.finish()
    with BagReader(file) as bag:
        assert list(bag.messages()) == messages
        assert sum(bag.message_counts.values()) == len(messages)


def test_malformed_cdr_names_file_topic_and_time(small_bag: Path) -> None:
    raw = RawMessage("/gps/fix", "sensor_msgs/msg/NavSatFix", 17, b"\0\1\0\0\1\2\3")
    with BagReader(small_bag) as bag, pytest.raises(BagError) as caught:
        bag.deserialize(raw)
    for part in (str(small_bag), "/gps/fix", "17 ns", "malformed"):
        assert part in str(caught.value)


def test_unknown_type_is_named(small_bag: Path) -> None:
    raw = RawMessage("/odd", "odd_msgs/msg/Odd", 17, b"\0\1\0\0")
    with BagReader(small_bag) as bag, pytest.raises(BagError, match="odd_msgs/msg/Odd"):
        bag.deserialize(raw)


@pytest.mark.parametrize(
    ("there", "missing"),
    [("/imu/data_raw", "sensor_msgs/msg/NavSatFix"), ("/gps/fix", "sensor_msgs/msg/Imu")],
)
def test_bag_without_imu_or_fix(
    tmp_path: Path, there: str, missing: str, write_small_bag: Callable[..., Path]
) -> None:
    path = write_small_bag(tmp_path / "part", 1.0, (there, "/mag"))
    with BagReader(path) as bag, pytest.raises(BagError) as caught:
        bag.require(PRESETS["default"])
    for part in (f"no {missing}", str(path), there, "/mag", "default", "mavros"):
        assert part in str(caught.value)


@pytest.mark.skipif(not FLIGHTS.is_dir(), reason="the recorded flights are not beside the project")
@pytest.mark.parametrize(
    "path", sorted(FLIGHTS.glob("*/*/metadata.yaml")), ids=lambda p: p.parts[-2]
)
def test_recorded_flights(path: Path) -> None:
    with Reader(path.parent) as reference, BagReader(path.parent) as bag:
        expected = {c.topic: c.msgcount for c in reference.connections if c.msgcount}
        assert bag.message_counts == expected
        bag.require(PRESETS["default"])
        assert sum(1 for _ in bag.messages()) == sum(expected.values())
