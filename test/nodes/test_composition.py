# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""All nodes in one process: what they subscribe to, publish and survive."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from feed import RAW_IMU
from live import SCENARIO, SECOND, offline, replay, stamp_ns, start_monitor, values_of
from ros import KEEP_ALL, ROOT, Graph
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64

from hijack_detect.nodes import MONITOR

BAG = ROOT / "bags/curved_8"
PERIOD_NS = SECOND // 2
ONCE = ("/imu/data_raw", "/gps/fix", "/gps/vel", "/gps/satellites", "/mag", "/pressure")
WITHIN = ("/imu/data", "/gps/course", "/coast/verdict", "/gnss/verdict")
BROKEN = """
import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from hijack_detect.nodes.engine import Engine
from hijack_detect.nodes.running import run_composed

def fail():
    raise OSError("the middleware is gone")

def make(executor):
    timed = Node("timed")
    timed.create_timer(0.05, fail)
    Engine([]).connect(executor, timed)
    return [Node("other")]

run_composed(make, "")
"""

EARLY = """
import os, signal
import rclpy
from rclpy.node import Node
from hijack_detect.nodes.running import run

start = rclpy.init

def press_and_start(**given):
    os.kill(os.getpid(), signal.SIGINT)
    start(**given)

rclpy.init = press_and_start
run(lambda: Node("early"), "")
"""


def states(verdicts: list[Any]) -> list[str]:
    """The states that follow on each other."""
    return [state for state, _ in itertools.groupby(values_of(one)["state"] for one in verdicts)]


def test_an_input_is_subscribed_once_and_none_between_the_nodes(graph: Graph) -> None:
    process = graph.start("all")
    graph.spin_until(lambda: all(map(graph.node.count_subscribers, ONCE)), "its subscriptions")
    graph.spin_until(lambda: {*MONITOR, "monitor"} <= set(graph.node.get_node_names()), "all nodes")
    assert [graph.node.count_subscribers(topic) for topic in ONCE] == [1] * len(ONCE)
    assert [graph.node.count_subscribers(topic) for topic in WITHIN] == [0] * len(WITHIN)
    assert process.interrupt() == 0


def test_a_rate_thins_what_is_published_but_no_change_of_state(graph: Graph) -> None:
    heard = {name: graph.listen(DiagnosticArray, f"{name}/verdict") for name in ("coast", "fusion")}
    attitudes, scores = graph.listen(Imu, "imu/data"), graph.listen(Float64, "coast/score")
    process = graph.start(
        "all",
        "--params-file",
        str(ROOT / "config/replay.yaml"),
        "-p",
        f"monitor:publish_rate:={SECOND / PERIOD_NS}",
    )
    replay(graph, BAG, 120.0, ("fusion", "monitor"), rate=5.0, scenario=SCENARIO)
    run = offline(BAG, "default", SCENARIO)

    periods = [stamp_ns(one) // PERIOD_NS for one in attitudes.messages]
    assert len(periods) == len(set(periods))
    assert set(periods) == set(range(periods[0], periods[-1] + 1))
    told, wanted = heard["coast"].messages, run.verdicts["coast"]
    changes = [state.value for state, _ in itertools.groupby(one.state for one in wanted)]
    graph.spin_until(lambda: len(states(told)) >= len(changes), "every state")
    graph.spin_until(lambda: len(scores.messages) >= len(told), "every score")
    # The last fix is judged live when its patience is over; a file just ends before.
    ended_ns = wanted[-1].stamp_ns
    assert states([one for one in told if stamp_ns(one) <= ended_ns]) == changes
    assert len(scores.messages) == len(told) < len(wanted)
    first_alert = next(one.stamp_ns for one in run.results if one.alert)
    alerts = [one for one in heard["fusion"].messages if values_of(one)["alert"] == "true"]
    assert stamp_ns(alerts[0]) == first_alert
    assert len(heard["fusion"].messages) < len(run.results)
    assert process.interrupt() == 0


def test_a_bad_message_is_told_once_and_all_nodes_go_on(graph: Graph) -> None:
    live = start_monitor(graph, "default", ["all"])
    process = live.nodes["all"]
    output = graph.node.create_publisher(Imu, "imu/data_raw", KEEP_ALL)
    graph.spin_until(output.get_subscription_count, "its subscription")
    for make in RAW_IMU.bad.values():
        output.publish(make(SECOND))
    output.publish(b"\x00\x01\x00\x00 cut off")
    graph.spin_until(lambda: "left out" in process.output, "a line about it")
    replay(graph, BAG, 60.0, ("fusion", "monitor"), rate=5.0, duration_s=10.0)
    assert all(listener.messages for listener in live.verdicts.values())
    told = [line for line in process.output.splitlines() if ": message" in line]
    assert len(told) == 1
    assert "/imu/data_raw: message stamped 1.000000000 left out: angular_velocity.x" in told[0]
    assert process.interrupt() == 0
    assert "internal error" not in process.output


@pytest.mark.parametrize(
    ("node", "name", "value"),
    [("coast_detector", "span_s", "-1.0"), ("monitor", "publish_rate", "-1.0")],
)
def test_a_parameter_out_of_bounds_names_the_node(
    graph: Graph, node: str, name: str, value: str
) -> None:
    process = graph.start("all", "-p", f"{node}:{name}:={value}")
    assert process.wait() == 2
    assert f"error: {node}: parameter '{name}'" in process.output
    assert "Traceback" not in process.output


def test_an_input_from_two_topics_is_refused(graph: Graph) -> None:
    process = graph.start("all", "-r", "coast_detector:gps/fix:=other/fix")
    assert process.wait() == 2
    assert "error: input 'fix' comes from /gps/fix (attitude_estimator)" in process.output
    assert "/other/fix (coast_detector)" in process.output
    assert "Traceback" not in process.output


def run_script(script: str, domain: int) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "ROS_DOMAIN_ID": str(domain)},
        capture_output=True,
        text=True,
        timeout=30.0,
        check=False,
    )


def test_a_failure_to_receive_ends_the_process(graph: Graph) -> None:
    done = run_script(BROKEN, graph.domain)
    assert done.returncode == 1
    assert "OSError: the middleware is gone" in done.stderr


def test_an_interrupt_while_ros_starts_is_not_lost(domain: int) -> None:
    done = run_script(EARLY, domain)
    assert (done.returncode, done.stderr) == (0, "")
