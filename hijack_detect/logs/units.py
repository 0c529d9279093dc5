# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Units and codes that the formats share, in SI."""

from __future__ import annotations

GAUSS_T, MILLIGAUSS_T = 1e-4, 1e-7
MILLIGRAVITY = 9.80665e-3
MILLI = 1e-3
HECTOPASCAL_PA = 100.0
FIX_3D = 3
"""From this type on a fix has a place, in PX4 as in ArduPilot and MAVLink."""
