# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A spoofed copy of a bag: the same messages, and the truth beside them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from live import SCENARIO, offline
from ros import ROOT
from rosbags.rosbag2 import Reader
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.rosbag2.writer import StoragePlugin
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from small_bags import SPOOF_TEXT, START_NS, flag, flight, raw, write

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.injection import Injection, inject
from hijack_detect.replay.offline import run_offline
from hijack_detect.replay.truth import (
    MEASURED_FIX,
    SPOOF_ACTIVE,
    known_attack,
    truth_track,
)
from hijack_detect.spoofing.scenario import ScenarioError, load_scenario, parse_scenario
from hijack_detect.streams.samples import NANOSECONDS, FixSample

JUMP = parse_scenario(SPOOF_TEXT)
TURN = load_scenario(SCENARIO)
GPS = ("/gps/fix", "/gps/vel")
Injected = Callable[..., tuple[BagReader, BagReader, Injection]]


@pytest.fixture
def injected(tmp_path: Path) -> Iterator[Injected]:
    """Injects into a bag; gives both open, and what was done."""
    opened: list[BagReader] = []

    def run(path: Path, scenario=JUMP) -> tuple[BagReader, BagReader, Injection]:  # type: ignore[no-untyped-def]
        opened.append(BagReader(path))
        done = inject(opened[0], tmp_path / "spoofed", scenario)
        opened.append(BagReader(tmp_path / "spoofed"))
        return opened[0], opened[1], done

    yield run
    for reader in opened:
        reader.close()


def rows(reader: BagReader, *topics: str) -> list[RawMessage]:
    return list(reader.messages(topics or None))


def test_only_fixes_and_velocities_change(injected: Injected, bag: Path) -> None:
    before, after, done = injected(bag)
    assert done.messages == len(rows(before))
    for topic in before.topics:
        changed = [
            a for a, b in zip(rows(before, topic), rows(after, topic), strict=True) if a != b
        ]
        # A jump leaves the velocity; it covers 1.0 to below 3.0 s at 5 Hz.
        assert len(changed) == (10 if topic == "/gps/fix" else 0), topic
    assert done.spoofed == 10


def test_the_truth_lies_beside_the_lie(injected: Injected, bag: Path) -> None:
    before, after, _ = injected(bag)
    assert [one.data for one in rows(after, MEASURED_FIX)] == [
        one.data for one in rows(before, "/gps/fix")
    ]
    flags = [(one.log_ns, after.deserialize(one).data) for one in rows(after, SPOOF_ACTIVE)]
    assert flags == [
        (one.log_ns, NANOSECONDS <= one.log_ns - START_NS < 3 * NANOSECONDS)
        for one in rows(before, "/gps/fix")
    ]
    attack, source = known_attack(after)
    assert source == "ground_truth"
    assert attack is not None
    assert attack.end_ns is not None
    assert (attack.onset_ns - START_NS, attack.end_ns - START_NS) == (
        NANOSECONDS,
        3 * NANOSECONDS,
    )
    track = truth_track(after)
    assert track is not None
    run = run_offline(after, policy_parameters("default"), truth=track)
    assert [round(metres, 3) for _, metres in run.separations] == [0.0] * 5 + [50.0] * 10 + [
        0.0
    ] * 6


def test_other_readers_of_rosbag2_read_it(injected: Injected, bag: Path) -> None:
    _, after, done = injected(bag)
    with Reader(after.path) as reader:
        topics = {connection.topic for connection in reader.connections}
        assert topics == {*after.topics}
        assert {MEASURED_FIX, SPOOF_ACTIVE} <= topics
        assert reader.message_count == done.messages + 2 * 21


@pytest.mark.parametrize("policy", ["default", "paper"])
def test_the_copy_says_what_the_original_says_with_the_scenario(
    injected: Injected, policy: str
) -> None:
    before, after, _ = injected(ROOT / "bags/curved_8", TURN)
    live = offline(before.path, policy, SCENARIO)
    copy = run_offline(after, policy_parameters(policy), truth=truth_track(after))
    assert copy.verdicts == live.verdicts
    assert copy.results == live.results
    assert [stamp for stamp, _ in copy.separations] == [stamp for stamp, _ in live.separations]
    for (_, one), (_, other) in zip(copy.separations, live.separations, strict=True):
        assert one == pytest.approx(other, abs=0.01)


def test_a_label_for_the_evaluation(injected: Injected, bag: Path) -> None:
    _, after, _ = injected(bag)
    label = json.loads((after.path / "label.json").read_text())
    assert (label["kind"], label["attack"]["kind"]) == ("hijack", "jump")
    assert (label["attack"]["t_start"], label["attack"]["t_end"]) == (1.0, 3.0)


def test_types_that_the_bag_defines_are_copied(injected: Injected, tmp_path: Path) -> None:
    types = get_typestore(Stores.ROS2_JAZZY)
    types.register(get_types_from_msg("std_msgs/Header header\nfloat32 level", "own/msg/Level"))
    level = types.types["own/msg/Level"]
    header = types.types["std_msgs/msg/Header"](
        types.types["builtin_interfaces/msg/Time"](1, 2), "x"
    )
    data = bytes(types.serialize_cdr(level(header, 0.5), "own/msg/Level"))
    writer = RosbagsWriter(tmp_path / "own", version=9, storage_plugin=StoragePlugin.MCAP)
    with writer:
        connection = writer.add_connection("/level", "own/msg/Level", typestore=types)
        writer.write(connection, START_NS, data)
        for one in flight():
            found = [c for c in writer.connections if c.topic == one.topic] or [
                writer.add_connection(one.topic, one.msgtype, typestore=types)
            ]
            writer.write(found[0], one.log_ns, one.data)
    _, after, done = injected(tmp_path / "own")
    assert done.left_out == {}
    assert [(one.msgtype, one.data) for one in rows(after, "/level")] == [("own/msg/Level", data)]
    assert "float32 level" in after.definition("/level")


def test_answers_to_the_original_are_left_out(injected: Injected, tmp_path: Path) -> None:
    messages = [
        *flight(),
        flag("/hijack_alert", START_NS, True),
        flag("/spoof_active", START_NS, False),
    ]
    _, after, done = injected(write(tmp_path / "answered", messages))
    assert set(done.left_out) == {"/hijack_alert"}
    assert "/hijack_alert" not in after.topics
    assert len(rows(after, SPOOF_ACTIVE)) == len(rows(after, "/gps/fix"))


def test_an_attacked_flight_is_not_attacked_again(injected: Injected, bag: Path) -> None:
    _, after, _ = injected(bag)
    with pytest.raises(BagError, match="spoofed: holds an attack already"):
        inject(after, after.path.parent / "twice", JUMP)
    assert not (after.path.parent / "twice").exists()


def test_a_segment_outside_the_flight_is_refused(bag: Path, tmp_path: Path) -> None:
    with BagReader(bag) as reader, pytest.raises(ScenarioError, match="outside the flight"):
        inject(reader, tmp_path / "never", JUMP.moved_to(100.0))
    assert not (tmp_path / "never").exists()


def test_a_fix_that_no_receiver_can_mean_stays_and_is_counted(
    injected: Injected, tmp_path: Path
) -> None:
    bad = raw("/gps/fix", FixSample(START_NS + 1_500_000_000, 91.0, 11.0, 500.0))
    path = write(tmp_path / "bad", sorted([*flight(), bad], key=lambda one: one.log_ns))
    _, after, done = injected(path)
    assert bad in rows(after, "/gps/fix")
    assert done.refused.total == 1
    assert "latitude is 91.0" in done.refused.lines()[0]
