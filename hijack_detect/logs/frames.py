# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From the frames of autopilots (FRD, NED) to ours (FLU, ENU)."""

from __future__ import annotations

import math

from hijack_detect.estimation.rotation import exponential, multiply
from hijack_detect.streams.samples import Quaternion, Vector3

GAUSS_T, MILLIGAUSS_T = 1e-4, 1e-7
MILLIGRAVITY = 9.80665e-3
MILLI = 1e-3
HECTOPASCAL_PA = 100.0
FIX_3D = 3
"""From this type on a fix has a place, in PX4 as in ArduPilot and MAVLink."""


_NED_TO_ENU: Quaternion = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
_FLU_TO_FRD: Quaternion = (1.0, 0.0, 0.0, 0.0)


def flu(x: float, y: float, z: float) -> Vector3:
    """A body vector from forward, right, down."""
    return (float(x), -float(y), -float(z))


def enu(north: float, east: float, down: float) -> Vector3:
    """A world vector from North, East, down."""
    return (float(east), float(north), -float(down))


def attitude(frd_to_ned: Quaternion) -> Quaternion:
    """The rotation from FLU to ENU, from that from FRD to NED (x, y, z, w)."""
    return multiply(multiply(_NED_TO_ENU, frd_to_ned), _FLU_TO_FRD)


def from_angles(roll: float, pitch: float, yaw: float) -> Quaternion:
    """The rotation from FLU to ENU, from roll, pitch and yaw of FRD in NED, radians."""
    turned = multiply(exponential((0.0, 0.0, yaw)), exponential((0.0, pitch, 0.0)))
    return attitude(multiply(turned, exponential((roll, 0.0, 0.0))))
