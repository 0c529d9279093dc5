# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The doctor over DDS: what it says of a graph with two monitors, a slow IMU and no clock."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from typing import Any

import pytest
from ros import Graph
from sensor_msgs.msg import Imu, NavSatFix
from std_msgs.msg import Bool

from hijack_detect.nodes.qos import ALERT, SENSOR

SLOW_S = 0.1


def examined(graph: Graph, *arguments: str) -> dict[str, dict[str, str]]:
    """Findings by what they are of, the worst of each, while the test's node goes on."""
    command = [sys.executable, "-m", "hijack_detect.cli.main", "doctor", "--json", *arguments]
    with subprocess.Popen(
        command,
        env={**os.environ, "ROS_DOMAIN_ID": str(graph.domain)},
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        graph.spin_until(lambda: process.poll() is not None, "the end of doctor", 60.0)
        assert process.stdout is not None
        rows: list[dict[str, str]] = json.load(process.stdout)
    order = ["info", "ok", "warn", "fail"]
    found: dict[str, dict[str, str]] = {}
    for one in sorted(rows, key=lambda row: order.index(row["level"])):
        found[one["what"]] = one
    return found


def test_a_graph_with_all_that_can_be_wrong(graph: Graph) -> None:
    graph.start("fusion", parameters={"use_sim_time": True})
    node: Any = graph.node
    outlet = node.create_publisher(Imu, "/imu/data_raw", SENSOR)
    sent_s: list[float] = []

    def send() -> None:
        outlet.publish(Imu())
        sent_s.append(time.monotonic())

    node.create_timer(SLOW_S, send)
    node.create_publisher(NavSatFix, "/mavros/global_position/raw/fix", SENSOR)
    node.create_publisher(Bool, "/hijack_alert", ALERT)
    graph.spin_until(lambda: node.count_publishers("/hijack_alert") == 2, "the fusion")
    found = examined(graph)
    assert found["DDS"]["level"] == "ok"
    assert "ms a message" in found["DDS"]["text"]
    imu, fix = found["/imu/data_raw"], found["/gps/fix"]
    assert imu["level"] == "warn"
    sent_hz = (len(sent_s) - 1) / (sent_s[-1] - sent_s[0])  # 10 Hz, less on a busy machine
    assert 0.6 * sent_hz < float(imu["text"].split()[1]) < 1.2 * sent_hz
    assert fix["level"] == "fail"
    assert "launch with mavros:=true" in fix["mend"]
    assert (found["monitor"]["level"], found["use_sim_time"]["level"]) == ("warn", "fail")
    assert "/fusion, /test" in found["monitor"]["text"]
    assert "/fusion" in found["use_sim_time"]["text"]


def test_security_that_is_not_there_fails(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    environment = {
        **os.environ,
        "ROS_DOMAIN_ID": str(domain),
        "ROS_SECURITY_ENABLE": "true",
        "ROS_SECURITY_STRATEGY": "Enforce",
    }
    done = subprocess.run(
        [sys.executable, "-m", "hijack_detect.cli.main", "doctor"],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "Traceback" not in done.stdout + done.stderr
    assert "unset ROS_SECURITY_ENABLE" in done.stdout
