# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Names that options choose among, where what they name is slow to load."""

from __future__ import annotations

POLICY_NAMES = ("default", "paper")
BESIDE_NAMES = ("recorder", "gps_spoofer", "mavlink_bridge", "px4_bridge")
ROUTES = ("straight", "curved", "hover", "fixed_yaw", "survey")
TABLE_NAMES = (
    "alerts",
    "snapshots",
    "verdicts",
    "fixes",
    "velocities",
    "satellites",
    "events",
    "sessions",
)
OPTIONAL_INPUTS = ("velocity", "mag", "pressure", "satellites")
