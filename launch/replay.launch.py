# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Replays a bag into the monitor, with an attack if a scenario is given.

    ros2 launch hijack_detect replay.launch.py bag:=FOLDER scenario:=FILE rate:=4

Arguments: `bag` (required), `scenario`, `rate`, `start_s`, `duration_s`, `loop`, `preset`, and
those of the monitor except mavros: the replay publishes under the monitor's own names.
"""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from hijack_detect.bags.topics import OWN_TOPICS
from hijack_detect.nodes import MONITOR

PACKAGE = "hijack_detect"
ARGUMENTS = (
    ("bag", None, "Bag to replay: a rosbag2 folder or an mcap file."),
    ("scenario", "", "Scenario file of attacks; empty for none."),
    ("rate", "1.0", "Bag seconds for each second of wall time."),
    ("start_s", "0.0", "Where to begin, s."),
    ("duration_s", "0.0", "How much to replay, s; 0 is all."),
    ("loop", "false", "Begin again at the end."),
    ("preset", "auto", "Topic names of the bag: auto, default or mavros."),
    ("uav", "", "Namespace of the vehicle; empty for none."),
    ("policy", "default", "default or paper: which parameter file of the package."),
    ("params_file", "", "A parameter file to use instead of the policy's."),
    ("use_sim_time", "false", "Use the replay's /clock."),
)


def reliable(namespace: str) -> dict[str, str]:
    """Parameters that make every input in a namespace reliable, as config/replay.yaml does."""
    prefix = f"/{namespace.strip('/')}" if namespace else ""
    return {
        f"qos_overrides.{prefix}/{topic}.subscription.{policy}": value
        for topic in OWN_TOPICS.values()
        for policy, value in (("reliability", "reliable"), ("history", "keep_all"))
    }


def nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """The monitor's nodes and the replay with the arguments as they were given."""

    def given(name: str) -> str:
        return str(LaunchConfiguration(name).perform(context))

    namespace = given("uav")
    own = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", f"{given('policy')}.yaml"])
    replayed = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", "replay.yaml"])
    clock = {"use_sim_time": given("use_sim_time") == "true"}
    monitor = [
        Node(
            package=PACKAGE,
            executable=name,
            name=name,
            namespace=namespace,
            parameters=[given("params_file") or own, replayed, clock, reliable(namespace)],
            output="screen",
        )
        for name in MONITOR
    ]
    replay = Node(
        package=PACKAGE,
        executable="bag_replay",
        name="bag_replay",
        namespace=namespace,
        parameters=[
            {name: given(name) for name in ("bag", "scenario", "preset")},
            {name: float(given(name)) for name in ("rate", "start_s", "duration_s")},
            {"loop": given("loop") == "true", "wait_for": " ".join(MONITOR)},
        ],
        output="screen",
        on_exit=Shutdown(reason="the replay is over"),
    )
    return [*monitor, replay]


def generate_launch_description() -> LaunchDescription:
    """What `ros2 launch` runs."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, default, text in ARGUMENTS
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
