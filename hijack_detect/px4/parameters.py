# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of px4_bridge."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.parameters import Parameters, param


@dataclass(frozen=True)
class Px4BridgeParameters(Parameters):
    """Which topics of PX4 are taken. Each is found with a version (`_v1`) behind it too."""

    prefix: str = param(
        "fmu/out",
        "Where PX4's topics are. Relative to the namespace of the node: in uav1 it is "
        "/uav1/fmu/out, which is where PX4 has them when its client is started with -n uav1. "
        "Give a name with a leading slash for another place.",
    )
    imu: str = param(
        "sensor_combined",
        "Topic of the IMU under `prefix`: sensor_combined (the selected one) or vehicle_imu.",
    )
    gps: str = param(
        "vehicle_gps_position",
        "Topic of the GPS under `prefix`: vehicle_gps_position (what PX4 uses) or sensor_gps.",
    )
    mag: str = param(
        "vehicle_magnetometer",
        "Topic of the magnetometer under `prefix`; empty if it is not to be used.",
    )
    pressure: str = param(
        "vehicle_air_data",
        "Topic of the barometer under `prefix`; empty if it is not to be used.",
    )
