# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The topics of PX4: their types, their versions, and the loss without them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from hijack_detect.logs.px4 import PACKAGE
from hijack_detect.parameters import Parameters, param


@dataclass(frozen=True)
class Px4BridgeParameters(Parameters):
    """Which topics of PX4 are taken. Each is found with a version (`_v1`) behind it too."""

    prefix: str = param(
        "fmu/out",
        "Where PX4's topics are. Relative to the namespace of the node: in uav1 it is "
        "/uav1/fmu/out, which is where PX4 has them when its client is started with -n uav1. "
        "Give a name with a leading slash for another place.",
        source="PX4: the topics of its uXRCE-DDS client",
        basic=True,
    )
    imu: str = param(
        "sensor_combined",
        "Topic of the IMU under `prefix`: sensor_combined (the selected one) or vehicle_imu.",
        source=(
            "PX4: in the default dds_topics.yaml; sensor_combined is the sensor that its EKF2 "
            "selected"
        ),
    )
    gps: str = param(
        "vehicle_gps_position",
        "Topic of the GPS under `prefix`: vehicle_gps_position (what PX4 uses) or sensor_gps.",
        source="PX4: in the default dds_topics.yaml",
    )
    mag: str = param(
        "vehicle_magnetometer",
        "Topic of the magnetometer under `prefix`; empty: not used.",
        source="PX4: the magnetometer that its EKF2 uses",
    )
    pressure: str = param(
        "vehicle_air_data",
        "Topic of the barometer under `prefix`; empty: not used.",
        source="PX4: the barometer that its EKF2 uses",
    )


VERSION = r"_v\d+"
GET_PX4_MSGS = (
    "in the src folder of a workspace `git clone -b release/1.16 "
    "https://github.com/PX4/px4_msgs` (the branch of your firmware), then `colcon build "
    "--packages-select px4_msgs` and `source install/setup.bash`"
)
MISSING = {
    "imu": "is the agent running, and in this ROS_DOMAIN_ID? Nothing works without it",
    "fix": "is the agent running, and in this ROS_DOMAIN_ID? Nothing works without it",
    "mag": "add it to dds_topics.yaml; not needed. Without it heading_detector sees nothing, and "
    "the heading comes from turns and speed alone",
    "pressure": "add it to dds_topics.yaml; not needed. Without it altitude_detector has only the "
    "vertical specific force to compare with",
}
"""By input: what to do, and what the monitor loses, where a topic is missing."""


@dataclass(frozen=True)
class Px4Topic:
    """One topic of PX4.

    Attributes:
        name: The input that it brings; `fix` stands for all of the GPS.
        topic: Its name as a node would subscribe it, without a version unless one was given.
        msgtype: Its type.
    """

    name: str
    topic: str
    msgtype: str

    def versions(self, full: str, topics: Iterable[str]) -> list[str]:
        """Those of the graph's topics that are this one in a version, such as `_v1`.

        Args:
            full: This topic's full name.
            topics: Full names of topics.
        """
        return sorted(one for one in topics if re.fullmatch(re.escape(full) + VERSION, one))


def px4_topics(parameters: Px4BridgeParameters) -> list[Px4Topic]:
    """The topics that parameters ask for.

    Raises:
        ValueError: There is no IMU or no GPS among them.
    """
    imu = "VehicleImu" if parameters.imu.startswith("vehicle_imu") else "SensorCombined"
    asked = {
        "imu": (parameters.imu, imu),
        "fix": (parameters.gps, "SensorGps"),
        "mag": (parameters.mag, "VehicleMagnetometer"),
        "pressure": (parameters.pressure, "VehicleAirData"),
    }
    for parameter, name in (("imu", "imu"), ("gps", "fix")):
        if not asked[name][0]:
            raise ValueError(f"px4_bridge: parameter '{parameter}' is empty: name the topic")
    prefix = parameters.prefix.rstrip("/")
    return [
        Px4Topic(name, f"{prefix}/{topic}" if prefix else topic, f"{PACKAGE}/msg/{kind}")
        for name, (topic, kind) in asked.items()
        if topic
    ]
