# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node bag_replay as a process, heard over DDS."""

from __future__ import annotations

import itertools
import signal
import time
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TwistStamped
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from ros import READY, Graph, Listener, RosProcess
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, NavSatFix
from small_bags import (
    START_NS,
    STEP_NS,
    damage_last_chunk,
    flag,
    flight,
    raw,
    write,
)
from std_msgs.msg import Bool, Float64, UInt32
from std_srvs.srv import Trigger

from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.bags.topics import PRESETS
from hijack_detect.nodes.qos import STATE
from hijack_detect.spoofing.scenario import load_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.messages import fix_sample, velocity_sample
from hijack_detect.streams.samples import MagneticSample

TYPES = {
    "imu/data_raw": Imu,
    "gps/fix": NavSatFix,
    "gps/vel": TwistStamped,
    "gps/satellites": UInt32,
    "truth/fix": NavSatFix,
}
SECOND = 1_000_000_000


def replay(graph: Graph, bag: Path, *ros_arguments: str, **parameters: Any) -> RosProcess:
    """Start a replay that begins when it knows all that listens now; or when `wait_for` says."""
    given = {"bag": bag, "rate": 20.0, "wait_for": READY, "settle_s": 0.0, **parameters}
    node = graph.start("bag_replay", *ros_arguments, parameters=given)
    space = next((one.partition(":=")[2] for one in ros_arguments if "__ns" in one), "")
    graph.until_known(f"{space}/bag_replay")
    graph.be_ready()
    return node


def listen_to_all(graph: Graph, prefix: str = "") -> dict[str, Listener]:
    return {name: graph.listen(kind, prefix + name, raw=True) for name, kind in TYPES.items()}


def content(heard: dict[str, Listener]) -> dict[str, list[bytes]]:
    """What was heard, without the zeros that fill the last word of a DDS message."""
    return {
        name: [one.rstrip(b"\0") for one in listener.messages] for name, listener in heard.items()
    }


def recorded(bag: Path) -> dict[str, list[bytes]]:
    messages: dict[str, list[bytes]] = {name: [] for name in TYPES}
    with BagReader(bag) as reader:
        for one in reader.messages():
            messages[one.topic[1:]].append(one.data.rstrip(b"\0"))
    return messages


def messages_of(bag: Path, *topics: str) -> list[list[Any]]:
    with BagReader(bag) as reader:
        return [[reader.deserialize(one) for one in reader.messages({topic})] for topic in topics]


def stamp_of(message: Any) -> int:
    return message.header.stamp.sec * SECOND + message.header.stamp.nanosec


def test_every_message_arrives_in_order_and_byte_for_byte(graph: Graph, bag: Path) -> None:
    heard = listen_to_all(graph, "/uav1/")
    node = replay(graph, bag, "-r", "__ns:=/uav1")
    began = time.monotonic()
    assert graph.spin_to_end(node) == 0
    assert time.monotonic() - began < 10.0
    assert content(heard) == recorded(bag)
    assert "ended at 4.000 s of 4.000 s, 285 messages published" in node.output


def test_attack_and_ground_truth_are_those_of_the_offline_spoofer(
    graph: Graph, bag: Path, scenario: Path
) -> None:
    heard = listen_to_all(graph)
    truth = graph.listen(Bool, "spoof_active")
    node = replay(graph, bag, scenario=scenario)
    assert graph.spin_to_end(node) == 0
    true = recorded(bag)
    for name in ("imu/data_raw", "truth/fix", "gps/satellites"):
        assert content(heard)[name] == true[name]
    spoofer = Spoofer(load_scenario(scenario), START_NS)
    expected: dict[str, list[Any]] = {"fix": [], "velocity": [], "active": []}
    for fix, velocity in zip(*messages_of(bag, "/gps/fix", "/gps/vel"), strict=True):
        sample = fix_sample(fix)
        expected["fix"].append(spoofer.fix(sample))
        expected["active"].append(spoofer.active(sample.stamp_ns))
        sample = velocity_sample(velocity)
        expected["velocity"].append(spoofer.velocity(sample))
    fixes = [fix_sample(deserialize_message(one, NavSatFix)) for one in heard["gps/fix"].messages]
    assert fixes == expected["fix"]
    assert expected["velocity"] == [
        velocity_sample(deserialize_message(one, TwistStamped)) for one in heard["gps/vel"].messages
    ]
    changes = [key for key, _ in itertools.groupby(one.data for one in truth.messages)]
    assert changes == [False, True, False]
    assert sum(expected["active"]) == 10


def test_names_of_mavros(graph: Graph, tmp_path: Path) -> None:
    extra = flag("/hijack_alert", START_NS, True)
    path = write(tmp_path / "mavros", [*flight(1.0, PRESETS["mavros"]), extra])
    heard = listen_to_all(graph)
    alert = graph.listen(Bool, "hijack_alert")
    node = replay(graph, path)
    assert graph.spin_to_end(node) == 0
    assert {name: len(one.messages) for name, one in heard.items()} == {
        "imu/data_raw": 51, "gps/fix": 6, "gps/vel": 6, "gps/satellites": 6, "truth/fix": 6
    }  # fmt: skip
    assert alert.messages == []
    assert "/mavros/global_position/raw/fix as gps/fix" in node.output
    assert node.output.count("topic /hijack_alert is left out: it is an answer") == 1


def test_a_window_restamped_with_the_clock(graph: Graph, bag: Path) -> None:
    imu = graph.listen(Imu, "imu/data_raw")
    clock = graph.listen(Clock, "/clock")
    before = time.time_ns()
    node = replay(graph, bag, start_s=1.0, duration_s=2.0, restamp=True, rate=1.0)
    assert graph.spin_to_end(node) == 0
    stamps = [stamp_of(one) for one in imu.messages]
    assert before < stamps[0] < time.time_ns()
    assert [b - a for a, b in itertools.pairwise(stamps)] == [STEP_NS] * 99
    times = [one.clock.sec * SECOND + one.clock.nanosec for one in clock.messages]
    assert times == sorted(times)
    assert times[-1] >= stamps[-1] and times[0] <= stamps[0] + SECOND // 10
    assert 190 <= len(times) <= 200


def test_the_clock_follows_the_bag(graph: Graph, bag: Path) -> None:
    clock = graph.listen(Clock, "/clock")
    imu = graph.listen(Imu, "imu/data_raw")
    node = replay(graph, bag, "-p", "use_sim_time:=true", clock_hz=50.0)
    assert graph.spin_to_end(node) == 0
    times = [one.clock.sec * SECOND + one.clock.nanosec for one in clock.messages]
    assert times == sorted(times)
    assert times[0] >= START_NS
    assert times[-1] == stamp_of(imu.messages[-1]) == START_NS + 4 * SECOND


def test_pause_step_resume_and_rate(graph: Graph, bag: Path) -> None:
    heard = listen_to_all(graph)
    position = graph.listen(Float64, "/bag_replay/position")
    node = replay(graph, bag, start_paused=True, rate=1.0)
    for service in ("resume", "pause"):  # so that calls while it plays take no time
        graph.meet(Trigger, f"/bag_replay/{service}")
    answers = [graph.call(Trigger, "/bag_replay/step") for _ in range(3)]
    assert [one.success for one in answers] == [True] * 3
    assert answers[0].message == (
        f"imu/data_raw stamped {START_NS} ns; paused at 0.000 s of 4.000 s"
    )
    assert f"gps/vel stamped {START_NS} ns" in answers[2].message
    graph.spin_until(lambda: heard["gps/vel"].messages, "the third message")
    assert [len(one.messages) for one in heard.values()] == [1, 1, 1, 0, 0]
    answer = graph.call(Trigger, "/bag_replay/resume")
    assert answer.success and answer.message.startswith("playing at 0.")
    assert not graph.call(Trigger, "/bag_replay/step").success
    graph.spin_until(lambda: len(heard["imu/data_raw"].messages) > 10, "more messages")
    answer = graph.call(Trigger, "/bag_replay/pause")
    assert answer.success and answer.message.startswith("paused at 0.")
    count = len(position.messages)
    graph.spin_until(lambda: len(position.messages) > count + 3, "the position while paused")
    assert position.messages[-1] == position.messages[-3]
    assert set_parameter(graph, "rate", 0.0).successful is False
    reason = set_parameter(graph, "loop", True).reason
    assert reason == "parameter 'loop' cannot change while the bag plays, only 'rate' can"
    assert set_parameter(graph, "rate", 50.0).successful
    assert graph.call(Trigger, "/bag_replay/resume").success
    assert graph.spin_to_end(node) == 0
    assert content(heard) == recorded(bag)


def set_parameter(graph: Graph, name: str, value: Any) -> Any:
    request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
    return graph.call(SetParameters, "/bag_replay/set_parameters", request).results[0]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_loop_ends_with_a_signal(graph: Graph, bag: Path, number: int) -> None:
    fixes = graph.listen(NavSatFix, "gps/fix")
    node = replay(graph, bag, loop=True, rate=200.0)
    graph.spin_until(lambda: len(fixes.messages) > 3 * 21, "three passes")
    stamps = [stamp_of(one) for one in fixes.messages[: 3 * 21]]
    assert stamps == [START_NS + index * 10 * STEP_NS for index in range(21)] * 3
    began = time.monotonic()
    node.signal(number)
    assert node.wait() == 0
    assert time.monotonic() - began < 1.5
    assert "Traceback" not in node.output


def test_it_stays_and_a_late_listener_learns_that_it_is_over(graph: Graph, tmp_path: Path) -> None:
    truth = [flag("/spoof_active", START_NS + index, index == 2) for index in range(3)]
    node = replay(graph, write(tmp_path / "truth", [*flight(1.0), *truth]), exit_at_end=False)
    node.wait_for("messages published")
    finished = graph.listen(Bool, "/bag_replay/finished", STATE)
    spoofed = graph.listen(Bool, "spoof_active", STATE)
    graph.spin_until(lambda: finished.messages and spoofed.messages, "the last states")
    assert finished.messages[-1].data and spoofed.messages[-1].data
    answer = graph.call(Trigger, "/bag_replay/resume")
    assert not answer.success and answer.message == "ended at 1.000 s of 1.000 s"
    assert node.interrupt() == 0


def test_it_waits_for_a_node(graph: Graph, bag: Path) -> None:
    imu = graph.listen(Imu, "imu/data_raw")
    node = replay(graph, bag, wait_for="test other", rate=1000.0)
    report = graph.listen(DiagnosticArray, "/diagnostics")
    graph.spin_until(lambda: len(report.messages) > 1, "two reports")
    assert imu.messages == []
    assert report.messages[-1].status[0].message.startswith("waiting for subscribers at 0.000 s")
    graph.start("bag_replay", "-r", "__node:=other", parameters={"bag": bag, "start_paused": True})
    graph.spin_until(lambda: imu.messages, "the first message")
    assert graph.spin_to_end(node) == 0
    assert len(imu.messages) == 201


def test_a_bad_message_is_told_and_left_out(graph: Graph, tmp_path: Path) -> None:
    bad = RawMessage("/gps/fix", "sensor_msgs/msg/NavSatFix", START_NS + 7, b"")
    repeated = [
        raw("/mag", MagneticSample(START_NS, (0.0, 0.0, 0.0)), START_NS + n) for n in (0, 1)
    ]
    path = write(tmp_path / "bad", [*flight(1.0), bad, *repeated])
    fixes = graph.listen(NavSatFix, "gps/fix")
    report = graph.listen(DiagnosticArray, "/diagnostics")
    node = replay(graph, path, "-r", "__ns:=/uav1", "-r", "gps/fix:=/gps/fix", exit_at_end=False)
    node.wait_for("messages published")
    graph.spin_until(
        lambda: report.messages and report.messages[-1].status[0].message.startswith("ended"),
        "the last report",
    )
    graph.spin_until_quiet()
    assert len(fixes.messages) == 6
    status = report.messages[-1].status[0]
    values = {pair.key: pair.value for pair in status.values}
    assert status.level == DiagnosticStatus.WARN and status.name == "/uav1/bag_replay: replay"
    assert values["refused /gps/fix malformed"] == values["refused /mag stamp"] == "1"
    assert values["published gps/fix"] == "6"
    for topic, stamp, what in (("/gps/fix", 7, "malformed"), ("/mag", 0, "stamp repeats")):
        text = f"{path}: topic {topic}, stamp {START_NS + stamp} ns: {what}"
        assert node.output.count(text) == 1


def test_a_slow_subscriber_slows_it_down_and_loses_nothing(graph: Graph, tmp_path: Path) -> None:
    count = 12_000  # more than reader and writer can hold
    many = (flag("/many", START_NS + index * 1000, index % 7 == 0) for index in range(count))
    path = write(tmp_path / "many", [*flight(0.1), *many])
    heard = graph.listen(Bool, "many")
    node = replay(graph, path, rate=1.0)
    node.wait_for("is more than this machine or a subscriber can follow")
    assert node.returncode is None
    assert graph.spin_to_end(node) == 0
    assert [one.data for one in heard.messages] == [index % 7 == 0 for index in range(count)]


def test_a_bag_that_turns_out_damaged_ends_with_two(graph: Graph, tmp_path: Path) -> None:
    path = write(tmp_path / "damaged", flight(60.0))
    damage_last_chunk(path)
    imu = graph.listen(Imu, "imu/data_raw")
    report = graph.listen(DiagnosticArray, "/diagnostics")
    node = replay(graph, path, rate=500.0)
    assert graph.spin_to_end(node) == 2
    assert len(imu.messages) > 1000
    assert f"{path / 'damaged.mcap'}: " in node.output and "the replay ends here" in node.output
    assert report.messages[-1].status[0].level == DiagnosticStatus.ERROR
    assert "Traceback" not in node.output


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({}, "error: parameter 'bag' is empty"),
        ({"bag": "/nowhere"}, "error: /nowhere: does not exist"),
        ({"bag": "{bag}", "scenario": "/nowhere.yaml"}, "error: /nowhere.yaml: cannot be read"),
        ({"bag": "{bag}", "start_s": 9.0}, "parameter 'start_s' is 9, the bag lasts 4 s"),
        ({"bag": "{bag}", "rate": 0.0}, "error: parameter 'rate' must be within [0.001, 1000.0]"),
        ({"bag": "{bag}", "speed": 2.0}, "error: unknown parameter 'speed'"),
    ],
)
def test_bad_input_ends_with_two_and_a_line(
    graph: Graph, bag: Path, parameters: dict[str, Any], said: str
) -> None:
    given = {name: str(value).format(bag=bag) for name, value in parameters.items()}
    node = graph.start("bag_replay", parameters=given)
    assert node.wait() == 2
    assert said in node.output and len(node.output.splitlines()) == 1


def test_help(graph: Graph) -> None:
    node = graph.run("hijack_detect.nodes", "bag_replay", "--help")
    assert node.wait() == 0
    assert "~/step publishes one message" in node.output
    node.close()
