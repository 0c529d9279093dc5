# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Thin ROS 2 nodes: parameters, topics, QoS, nothing else."""

from __future__ import annotations

from pathlib import Path

from hijack_detect.monitor.parts import PARTS

# setup.py reads these names and the functions behind them, so nothing slow is imported.
MONITOR = tuple(part.node for part in PARTS)
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
"""Names of the nodes, and of the executables that start them."""


def entry_point(node: str) -> str:
    """What runs a node, as `module:function`: of the module of its name, or any detector's."""
    own = Path(__file__).with_name(f"{node}.py").is_file()
    return f"{__name__}.{node if own else 'detector_node'}:main"
