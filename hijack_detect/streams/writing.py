# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From samples back into the messages that they came from.

Like `messages`, the functions use attributes only, so the message may come from rclpy or from
rosbags. What a sample does not hold (frame, status, service, orientation) stays as it was.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hijack_detect.streams.samples import FixSample, GpsSample, SatelliteSample, VelocitySample

UNKNOWN, APPROXIMATED = 0, 1
"""Types of covariance of a NavSatFix."""


def write_change(message: Any, before: GpsSample, after: GpsSample) -> bool:
    """Write what an attack made of a sample into the sample's message.

    Args:
        message: `sensor_msgs/NavSatFix`, `geometry_msgs/TwistStamped` or `std_msgs/UInt32`; it is
            changed.
        before: The sample that was read from the message.
        after: A sample of the same kind.

    Returns:
        Whether they differ; otherwise the message is left alone.
    """
    if after == before:
        return False
    if isinstance(before, FixSample) and isinstance(after, FixSample):
        message.latitude, message.longitude = after.latitude_deg, after.longitude_deg
        message.altitude = after.altitude_m
        if after.accuracy_m is not None and after.accuracy_m != before.accuracy_m:
            message.position_covariance = position_covariance(
                after.accuracy_m, after.vertical_accuracy_m
            )
            message.position_covariance_type = APPROXIMATED
    elif isinstance(after, VelocitySample):
        linear = message.twist.linear
        linear.x, linear.y, linear.z = after.velocity
    elif isinstance(after, SatelliteSample):
        message.data = after.count
    return True


def position_covariance(
    horizontal_m: float | None, vertical_m: float | None
) -> npt.NDArray[np.float64]:
    """Row-major diagonal covariance (9,) in m², ENU, of claimed standard deviations.

    It is 0, which `messages` reads as no claim, where there is none.
    """
    across, up = (0.0 if one is None else one**2 for one in (horizontal_m, vertical_m))
    return np.diag([across, across, up]).ravel()
