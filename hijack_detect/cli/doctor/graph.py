# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The process in which `doctor` looks at the graph: `NAMESPACE MAVROS`, findings as JSON."""

from __future__ import annotations

import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import rclpy
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node

from hijack_detect.bags.topics import TYPES
from hijack_detect.cli.doctor.child import printed
from hijack_detect.cli.doctor.expectations import Received, inputs, monitors, topics_of
from hijack_detect.nodes.messages import message_class
from hijack_detect.nodes.qos import SENSOR

NAME = "hijack_detect_doctor"
DISCOVERY_S, MEASURED_S, ANSWER_S = 2.0, 2.0, 1.5
"""Chosen, not swept."""
ALERT = "hijack_alert"


def main(namespace: str, mavros: bool) -> None:
    """Look, and print."""
    rclpy.init()
    node = Node(NAME, enable_rosout=False, start_parameter_services=False)
    topics = topics_of(namespace, mavros=mavros)
    _spin(node, DISCOVERY_S)
    counts: Counter[str] = Counter()
    for name, topic in topics.items():
        if _kinds(node, topic) == [TYPES[name]]:
            count = _counter(counts, name)
            node.create_subscription(message_class(TYPES[name]), topic, count, SENSOR, raw=True)
    _spin(node, 0.5)
    counts.clear()
    begin_s = time.monotonic()
    _spin(node, MEASURED_S)
    passed_s = time.monotonic() - begin_s
    received = {
        name: Received(_publishers(node, topic), _kinds(node, topic), counts[name] / passed_s)
        for name, topic in topics.items()
    }
    known = node.get_topic_names_and_types()
    published = {topic: kinds for topic, kinds in known if node.count_publishers(topic)}
    space = topics["imu"].removesuffix(topics_of("", mavros=mavros)["imu"])
    alerting = _publishers(node, f"{space}/{ALERT}")
    found = [
        *inputs(topics, received, published),
        *monitors(alerting, _on_simulated_time(node, alerting), clock="/clock" in published),
    ]
    print(printed(found), flush=True)
    os._exit(0)  # Fast DDS can lock itself up at shutdown


def _spin(node: Node, seconds: float) -> None:
    end_s = time.monotonic() + seconds
    while (left_s := end_s - time.monotonic()) > 0.0:
        rclpy.spin_once(node, timeout_sec=left_s)


def _counter(counts: Counter[str], name: str) -> Callable[[Any], None]:
    def count(_: Any) -> None:
        counts[name] += 1

    return count


def _publishers(node: Node, topic: str) -> list[str]:
    found = node.get_publishers_info_by_topic(topic)
    return sorted(f"{one.node_namespace.rstrip('/')}/{one.node_name}" for one in found)


def _kinds(node: Node, topic: str) -> list[str]:
    return sorted({one.topic_type for one in node.get_publishers_info_by_topic(topic)})


def _on_simulated_time(node: Node, names: Sequence[str]) -> list[str]:
    """Nodes whose use_sim_time is true."""
    answers: dict[str, bool] = {}
    clients = {name: node.create_client(GetParameters, f"{name}/get_parameters") for name in names}
    for name, client in clients.items():
        if client.wait_for_service(timeout_sec=ANSWER_S):
            future: Any = client.call_async(GetParameters.Request(names=["use_sim_time"]))
            future.add_done_callback(partial(_keep, answers, name))
    end_s = time.monotonic() + ANSWER_S
    while len(answers) < len(clients) and time.monotonic() < end_s:
        rclpy.spin_once(node, timeout_sec=0.1)
    return sorted(name for name, simulated in answers.items() if simulated)


def _keep(answers: dict[str, bool], name: str, future: Any) -> None:
    values = future.result().values
    answers[name] = bool(values and values[0].bool_value)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2] == "true")
