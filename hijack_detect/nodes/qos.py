"""Quality of service of the package's topics."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

SENSOR = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=500, reliability=ReliabilityPolicy.BEST_EFFORT
)
"""Inputs from autopilots: best effort, since a reliable subscription hears nothing from mavros
or PX4; deep, since Python may pause for longer than five samples of an IMU."""

INTERNAL = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=10_000, reliability=ReliabilityPolicy.RELIABLE
)
"""Between the nodes of this package: nothing may be lost, or replays would differ. The depth is
40 s of an IMU at 250 Hz; a node that hangs for longer must not stop the others."""

STATE = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""A state that a late subscriber must learn at once."""
