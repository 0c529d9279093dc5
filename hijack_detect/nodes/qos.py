# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Quality of service of the package's topics."""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.qos_overriding_options import QoSOverridingOptions

from hijack_detect.contract import SILENT_S

SENSOR = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=500, reliability=ReliabilityPolicy.BEST_EFFORT
)
"""Inputs from autopilots: best effort, since a reliable subscription receives nothing from mavros
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

ALERT_LEASE_S = 3.0
ALERT = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    deadline=Duration(seconds=SILENT_S),
    liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
    liveliness_lease_duration=Duration(seconds=ALERT_LEASE_S),
)
"""The alert, repeated every second. A subscription with this profile learns of a missing
repetition, and of a publisher that is dead or hangs."""

OVERRIDES = QoSOverridingOptions(
    policy_kinds=(
        QoSPolicyKind.HISTORY,
        QoSPolicyKind.DEPTH,
        QoSPolicyKind.RELIABILITY,
        QoSPolicyKind.DURABILITY,
    )
)
"""What the `qos_overrides` parameters can change of a subscription. Durability transient_local asks
a publisher that remembers for what was missed; one that does not is then not received at all."""


def remembered(depth: int) -> QoSProfile:
    """An output of which the last `depth` messages are kept for subscribers that ask for them.

    A best effort, volatile subscriber is served as by any other output. A reliable one is sent
    again what it did not acknowledge, and a transient local one gets what is kept when it comes.
    """
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )
