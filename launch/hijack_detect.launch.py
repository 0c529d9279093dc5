# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Starts the monitor: all nodes in one process, or each in a process of its own.

    ros2 launch hijack_detect hijack_detect.launch.py
    ros2 launch hijack_detect hijack_detect.launch.py composed:=false
    ros2 launch hijack_detect hijack_detect.launch.py mavros:=true uav:=uav1 policy:=paper
    ros2 launch hijack_detect hijack_detect.launch.py mavlink:=serial:/dev/ttyAMA0:921600

Arguments: `uav` namespace of the vehicle, `policy` default or paper, `params_file` a parameter
file instead of the policy's, `composed` all nodes in one process, `mavros` takes the inputs from
mavros' topics, `record` starts the recorder (journal and black box) too, in `record_folder`,
`use_sim_time`, `px4` starts px4_bridge too, which takes the inputs from PX4 over uXRCE-DDS,
`mavlink` starts mavlink_bridge too, with that connection.
"""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from hijack_detect.bags.topics import OWN_TOPICS, PRESETS
from hijack_detect.nodes import COMPOSED, MONITOR

PACKAGE = "hijack_detect"
RESPAWN_S = 1.0
"""A node that has died is started again after this; an alert survives that."""
ARGUMENTS = (
    ("uav", "", "Namespace of the vehicle; empty for none."),
    ("policy", "default", "default or paper: which parameter file of the package."),
    ("params_file", "", "A parameter file to use instead of the policy's."),
    ("composed", "true", "All nodes in one process: less of a processor, and earlier alerts."),
    ("mavros", "false", "Take the inputs from the topics of mavros."),
    ("record", "false", "Keep a journal, and a bag around each alert, with the node recorder."),
    ("record_folder", "", "Where it keeps them; empty for ~/.ros/hijack_detect/UAV."),
    ("use_sim_time", "false", "Use /clock, as a replay publishes it."),
    (
        "mavlink",
        "",
        "Take the inputs from an autopilot: the connection of mavlink_bridge (udpin:ADDRESS:PORT).",
    ),
    ("px4", "false", "Take the inputs from PX4 over uXRCE-DDS, with the node px4_bridge."),
)


def remappings(*, mavros: bool) -> list[tuple[str, str]]:
    """Input topics of the nodes to those of mavros, relative to the namespace."""
    if not mavros:
        return []
    return [(OWN_TOPICS[name], topic.lstrip("/")) for name, topic in PRESETS["mavros"].items()]


def nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """The monitor's nodes with the arguments as they were given."""

    def given(name: str) -> str:
        return str(LaunchConfiguration(name).perform(context))

    names = (COMPOSED,) if given("composed") == "true" else MONITOR
    # What a parameter file may set differently.
    beside: dict[str, dict[str, str]] = {}
    if given("record") == "true":
        folder = given("record_folder") or f"~/.ros/hijack_detect/{given('uav')}".rstrip("/")
        beside["recorder"] = {"folder": folder}
    if given("px4") == "true":
        beside["px4_bridge"] = {}
    if given("mavlink"):
        beside["mavlink_bridge"] = {"connection": given("mavlink")}
    own = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", f"{given('policy')}.yaml"])
    return [
        Node(
            package=PACKAGE,
            executable=name,
            name=None if name == COMPOSED else name,  # it would rename every node in it
            namespace=given("uav"),
            parameters=[
                *filter(None, [beside.get(name)]),
                given("params_file") or own,
                {"use_sim_time": given("use_sim_time") == "true"},
            ],
            remappings=remappings(mavros=given("mavros") == "true"),
            output="screen",
            respawn=True,
            respawn_delay=RESPAWN_S,
        )
        for name in (*names, *beside)
    ]


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` runs."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, default, text in ARGUMENTS
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
