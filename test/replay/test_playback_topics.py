# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which topics of a bag are replayed, and as what."""

from __future__ import annotations

import pytest
from small_bags import (
    stand_in,
)

from hijack_detect.bags.topics import PRESETS
from hijack_detect.replay.playback import routes

IMU, FIX = "sensor_msgs/msg/Imu", "sensor_msgs/msg/NavSatFix"


def test_names_of_mavros_become_ours_and_others_stay() -> None:
    topics = {
        "/mavros/imu/data_raw": IMU,
        "/mavros/global_position/raw/fix": FIX,
        "/mavros/global_position/global": FIX,
        "/mavros/imu/data": IMU,
        "/mavros/gpsstatus/gps1/raw": "mavros_msgs/msg/GPSRAW",
    }
    chosen = routes(topics, PRESETS["mavros"], stand_in, spoofing=False)
    assert {topic: route.topic for topic, route in chosen.published.items()} == {
        "/mavros/imu/data_raw": "imu/data_raw",
        "/mavros/global_position/raw/fix": "gps/fix",
        "/mavros/global_position/global": "mavros/global_position/global",
        "/mavros/imu/data": "mavros/imu/data",
        "/mavros/gpsstatus/gps1/raw": "mavros/gpsstatus/gps1/raw",
    }
    assert chosen.topic_of("fix") == "/mavros/global_position/raw/fix"
    assert not chosen.skipped


@pytest.mark.parametrize(
    ("topic", "msgtype", "reason"),
    [
        ("/hijack_alert", "std_msgs/msg/Bool", "answer of the monitor"),
        ("/drone1/hijack_alert", "std_msgs/msg/Bool", "answer of the monitor"),
        ("/kld/verdict", "diagnostic_msgs/msg/DiagnosticArray", "answer of the monitor"),
        ("/coast/score", "std_msgs/msg/Float64", "answer of the monitor"),
        ("/gnss/jump", "std_msgs/msg/Float64", "answer of the monitor"),
        ("/altitude/difference", "std_msgs/msg/Float64", "answer of the monitor"),
        ("/heading/difference", "std_msgs/msg/Float64", "answer of the monitor"),
        ("/drag/wind_change", "std_msgs/msg/Float64", "answer of the monitor"),
        ("/date/delta_ax", "std_msgs/msg/Bool", "answer of the monitor"),
        ("/imu/data", IMU, "answer of the monitor"),
        ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", "running system"),
        ("/clock", "rosgraph_msgs/msg/Clock", "running system"),
        ("/drone1/rosout", "rcl_interfaces/msg/Log", "running system"),
        ("/camera", "nowhere_msgs/msg/Image", "'nowhere_msgs/msg/Image' is not installed"),
        ("/gps/vel", "geometry_msgs/msg/Vector3Stamped", "the input needs geometry_msgs/msg/Twist"),
        ("/a b", "std_msgs/msg/Bool", "no name that can be published"),
        ("/a__b", "std_msgs/msg/Bool", "no name that can be published"),
        ("", "std_msgs/msg/Bool", "no name that can be published"),
        ("//gps/fix", FIX, "'gps/fix' is taken by /gps/fix"),
    ],
)
def test_left_out_with_a_reason(topic: str, msgtype: str, reason: str) -> None:
    topics = {"/imu/data_raw": IMU, "/gps/fix": FIX, topic: msgtype}
    chosen = routes(topics, PRESETS["default"], stand_in, spoofing=False)
    assert set(chosen.published) == {"/imu/data_raw", "/gps/fix"}
    assert reason in chosen.skipped[topic]


@pytest.mark.parametrize("spoofing", [True, False])
def test_a_recorded_ground_truth_is_kept_unless_attacks_are_injected(spoofing: bool) -> None:
    topics = {"/imu/data_raw": IMU, "/gps/fix": FIX, "/spoof_active": "std_msgs/msg/Bool"}
    chosen = routes(topics, PRESETS["default"], stand_in, spoofing=spoofing)
    assert chosen.has_truth is not spoofing
