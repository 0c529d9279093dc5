# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Thin ROS 2 nodes, one file each: parameters, topics, QoS, nothing else."""

# Every name is a module of this package with a main(), and the executable that starts it.
# setup.py runs this file by itself, so it imports nothing.
MONITOR = (
    "attitude_estimator",
    "gps_angle",
    "flight_phase",
    "correlation_detector",
    "date_detector",
    "kld_detector",
    "coast_detector",
    "gnss_sanity",
    "altitude_detector",
    "heading_detector",
    "drag_detector",
    "fusion",
)
COMPOSED = "all"
NODES = (
    *MONITOR,
    COMPOSED,
    "bag_replay",
    "gps_spoofer",
    "mavlink_bridge",
    "recorder",
    "px4_bridge",
)
