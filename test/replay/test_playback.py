# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a replay publishes; without ROS."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_bags import (
    SPOOF_TEXT,
    START_NS,
    STEP_NS,
    flight,
    raw,
    write,
)

from hijack_detect.bags.encoding import encode_sample
from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage, typestore
from hijack_detect.replay.playback import Outgoing, Playback, ReplayParameters, moved_stamp
from hijack_detect.spoofing.scenario import ScenarioError, load_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.cdr import stamp_from_bytes
from hijack_detect.streams.messages import CONVERTERS
from hijack_detect.streams.samples import FixSample, ImuSample, MagneticSample

IMU = "sensor_msgs/msg/Imu"
FIX = "sensor_msgs/msg/NavSatFix"
SECOND = 1_000_000_000
Open = Callable[..., Playback]


def of_topic(messages: list[Outgoing], topic: str) -> list[Outgoing]:
    return [message for message in messages if message.topic == topic]


def test_every_message_is_published_byte_for_byte(playback: Open, bag: Path) -> None:
    published = list(playback(bag).messages())
    with BagReader(bag) as reader:
        recorded = list(reader.messages())
    assert [(one.log_ns, "/" + one.topic, one.data) for one in published] == [
        (one.log_ns, one.topic, one.data) for one in recorded
    ]
    assert {one.topic for one in published if one.headed} == {
        "imu/data_raw", "gps/fix", "gps/vel", "truth/fix"
    }  # fmt: skip
    assert {one.spoofed for one in of_topic(published, "gps/fix")} == {False}
    assert {one.spoofed for one in published if one.topic != "gps/fix"} == {None}


def test_attacks_change_fix_and_velocity_and_nothing_else(
    playback: Open, bag: Path, scenario: Path
) -> None:
    published = list(playback(bag, scenario=str(scenario)).messages())
    spoofer = Spoofer(load_scenario(scenario), START_NS)
    with BagReader(bag) as reader:
        for sent, recorded in zip(published, reader.messages(), strict=True):
            name = {"/gps/fix": "fix", "/gps/vel": "velocity"}.get(recorded.topic)
            if name is None:
                assert sent.data == recorded.data
                continue
            sample = CONVERTERS[name](reader.deserialize(recorded))
            reported = getattr(spoofer, name)(sample)
            message = typestore().deserialize_cdr(sent.data, recorded.msgtype)
            assert CONVERTERS[name](message) == reported
            if name == "fix":
                assert sent.spoofed == spoofer.active(sample.stamp_ns)
                assert sent.spoofed == (sent.data != recorded.data)
    active = [one.spoofed for one in of_topic(published, "gps/fix")]
    assert active == [False] * 5 + [True] * 10 + [False] * 6


@pytest.mark.parametrize("start_s", [0.5, 1.0, 2.02, 3.0])
def test_the_same_fix_is_spoofed_alike_wherever_the_replay_starts(
    playback: Open, bag: Path, scenario: Path, start_s: float
) -> None:
    whole = list(playback(bag, scenario=str(scenario)).messages())
    part = list(playback(bag, scenario=str(scenario), start_s=start_s).messages())
    assert part == [one for one in whole if one.log_ns >= START_NS + round(start_s * SECOND)]


def test_start_and_duration_select_a_window(playback: Open, bag: Path) -> None:
    times = [one.log_ns - START_NS for one in playback(bag, start_s=1.0, duration_s=0.5).messages()]
    assert (min(times), max(times)) == (SECOND, 3 * SECOND // 2 - STEP_NS)


def test_every_pass_is_spoofed_alike(playback: Open, bag: Path, scenario: Path) -> None:
    made = playback(bag, scenario=str(scenario))
    assert list(made.messages()) == list(made.messages())


def test_a_message_that_cannot_be_decoded_is_counted_and_named(
    playback: Open, tmp_path: Path
) -> None:
    messages = list(flight(1.0))
    bad = RawMessage("/gps/fix", FIX, START_NS + 7, b"\0\1\0\0broken")
    empty = RawMessage("/imu/data_raw", IMU, START_NS + 8, b"")
    path = write(tmp_path / "bad", [*messages[:5], bad, empty, *messages[5:]])
    made = playback(path)
    assert len(list(made.messages())) == len(messages)
    assert made.rejected.total == 2
    line = made.rejected.lines()[0]
    assert str(path) in line and "/gps/fix" in line and str(START_NS + 7) in line
    assert "malformed sensor_msgs/msg/NavSatFix of 10 bytes" in line


def test_a_type_that_rosbags_does_not_know_passes_with_a_look_at_its_head(
    playback: Open, bag: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = playback(bag)
    route = made.routes.published["/gps/fix"]._replace(msgtype="mavros_msgs/msg/GPSRAW")
    made.routes.published["/gps/fix"] = route  # type: ignore[index]
    good = bytes([0, 1, 0, 0]) + struct.pack("<iI", 5, 6)
    for data in (b"", good[:11], b"\x09\x09" + good[2:], good):
        message = RawMessage("/gps/fix", route.msgtype, START_NS, data)
        monkeypatch.setattr(made.reader, "messages", lambda *_, one=message, **__: iter([one]))
        assert [one.data for one in made.messages()] == ([good] if data == good else [])
    assert made.rejected.total == 3


def test_stamps_that_do_not_increase_are_named_and_published(
    playback: Open, tmp_path: Path
) -> None:
    extra = [
        raw("/mag", MagneticSample(START_NS + stamp, (0.0, 0.0, 0.0)), START_NS + log)
        for log, stamp in ((0, 50), (1, 50), (2, 40), (3, 60))
    ]
    path = write(tmp_path / "stamps", [*flight(1.0), *extra])
    made = playback(path)
    assert len(of_topic(list(made.messages()), "mag")) == 4
    assert made.rejected.counts == {("/mag", "stamp"): 2}
    text = str(made.rejected.first["/mag", "stamp"])
    assert str(path) in text and f"{START_NS + 50} ns: stamp repeats" in text


@pytest.mark.parametrize("with_scenario", [True, False])
def test_an_impossible_fix_passes_as_it_is(
    playback: Open, tmp_path: Path, scenario: Path, with_scenario: bool
) -> None:
    odd = raw("/gps/fix", FixSample(START_NS + 1_100_000_000, 91.0, 11.0, 500.0))
    made = playback(
        write(tmp_path / "odd", [*flight(), odd]), scenario=str(scenario) if with_scenario else ""
    )
    fixes = of_topic(list(made.messages()), "gps/fix")
    assert [one.spoofed for one in fixes if one.data == odd.data] == [with_scenario]
    assert made.rejected.total == with_scenario


def test_errors_at_the_start(playback: Open, bag: Path, scenario: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="'bag' is empty"):
        ReplayParameters()
    with pytest.raises(ValueError, match=r"'start_s' is 5, the bag lasts 4 s"):
        playback(bag, start_s=5.0)
    late = tmp_path / "late.yaml"
    late.write_text(SPOOF_TEXT.replace("3.0", "5.0"))
    with pytest.raises(ScenarioError, match=r"late\.yaml.*end: 5\.0 is outside the flight"):
        playback(bag, scenario=str(late))
    with pytest.raises(BagError, match=r"no sensor_msgs/msg/Imu on topic /mavros/imu/data_raw"):
        playback(bag, preset="mavros")
    blind = [one for one in flight(1.0) if one.msgtype != FIX]
    with pytest.raises(BagError, match=r"blind: the bag has no sensor_msgs/msg/NavSatFix topic"):
        playback(write(tmp_path / "blind", blind))


@given(st.integers(1, 2**31 * SECOND - 1), st.integers(-(2**60), 2**60))
def test_a_moved_stamp_changes_nothing_else(stamp: int, offset: int) -> None:
    _, data = encode_sample(ImuSample(stamp, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)))
    moved = moved_stamp(data, offset)
    fits = 0 <= stamp + offset < 2**31 * SECOND
    assert stamp_from_bytes(moved) == (stamp + offset if fits else stamp)
    assert moved[:4] + moved[12:] == data[:4] + data[12:]


def test_big_endian_and_unset_stamps() -> None:
    data = bytes([0, 0, 0, 0]) + struct.pack(">iI", 7, 9) + b"rest"
    assert moved_stamp(data, SECOND + 1) == data[:4] + struct.pack(">iI", 8, 10) + b"rest"
    assert moved_stamp(bytes([0, 1, *bytes(10)]), SECOND) == bytes([0, 1, *bytes(10)])
