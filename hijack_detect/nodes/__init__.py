"""Thin ROS 2 nodes, one file each: parameters, topics, QoS, nothing else."""

# Every name is a module of this package with a main(), and the executable that starts it.
# setup.py runs this file by itself, so it imports nothing.
MONITOR = (
    "attitude_estimator",
    "gps_angle",
    "correlation_detector",
    "date_detector",
    "kld_detector",
    "fusion",
)
NODES = (*MONITOR, "bag_replay", "gps_spoofer", "recorder")
