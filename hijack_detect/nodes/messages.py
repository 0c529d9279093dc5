# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From samples and verdicts to ROS messages."""

from __future__ import annotations

import importlib
import importlib.util
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import QuaternionStamped
from sensor_msgs.msg import Imu

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.verdict_messages import fusion_values, verdict_values
from hijack_detect.streams.samples import NANOSECONDS, AttitudeSample, CourseSample, PhaseSample


def message_class(msgtype: str) -> Any:
    """Return the class of a message type such as std_msgs/msg/Bool, None if not installed.

    A bag can name any package: only those that contain messages are imported.
    """
    match = re.fullmatch(r"([a-z][a-z0-9_]*)/msg/([A-Z][A-Za-z0-9]*)", msgtype)
    found = importlib.util.find_spec(match[1]) if match else None
    folders = (found and found.submodule_search_locations) or []
    if match is None or not any(Path(folder, "msg").is_dir() for folder in folders):
        return None
    kind = getattr(importlib.import_module(f"{match[1]}.msg"), match[2], None)
    return kind if hasattr(kind, "get_fields_and_field_types") else None


LEVELS = {
    State.NOT_READY: DiagnosticStatus.OK,
    State.NOT_OBSERVABLE: DiagnosticStatus.OK,
    State.NORMAL: DiagnosticStatus.OK,
    State.SUSPICIOUS: DiagnosticStatus.WARN,
    State.ALARM: DiagnosticStatus.ERROR,
    State.STALE: DiagnosticStatus.STALE,
}
"""Level of a diagnostic status for each state."""

TILT_VARIANCE = math.radians(1.5) ** 2
"""Variance given for roll and pitch, rad²: what the estimator reaches on clean flights."""

NO_ORIENTATION = -1.0
"""First orientation covariance of an Imu without orientation (REP-145)."""


def time_message(stamp_ns: int) -> Time:
    """A stamp in nanoseconds as `builtin_interfaces/Time`."""
    seconds, nanoseconds = divmod(stamp_ns, NANOSECONDS)
    return Time(sec=seconds, nanosec=nanoseconds)


def phase_message(sample: PhaseSample) -> DiagnosticArray:
    """The phase of the flight as one diagnostic status; `streams.messages` reads it back."""
    message = DiagnosticArray()
    message.header.stamp = time_message(sample.stamp_ns)
    status = DiagnosticStatus(
        level=DiagnosticStatus.WARN if sample.imu_fault else DiagnosticStatus.OK,
        name="flight_phase",
        message=sample.reason,
    )
    status.values = [
        KeyValue(key="phase", value=sample.phase.value),
        KeyValue(key="since_ns", value=str(sample.since_ns)),
        KeyValue(key="imu_rate_hz", value=repr(sample.imu_rate_hz)),
        KeyValue(key="imu_fault", value=sample.imu_fault),
    ]
    message.status = [status]
    return message


def imu_message(sample: AttitudeSample, frame_id: str) -> Imu:
    """`sensor_msgs/Imu` with orientation FLU → ENU and the raw readings (REP-145)."""
    message = Imu()
    message.header.stamp = time_message(sample.stamp_ns)
    message.header.frame_id = frame_id
    velocity, force = message.angular_velocity, message.linear_acceleration
    velocity.x, velocity.y, velocity.z = sample.angular_velocity
    force.x, force.y, force.z = sample.specific_force
    if sample.orientation is None:
        message.orientation_covariance[0] = NO_ORIENTATION
        return message
    q = message.orientation
    q.x, q.y, q.z, q.w = sample.orientation
    message.orientation_covariance[0] = TILT_VARIANCE
    message.orientation_covariance[4] = TILT_VARIANCE
    message.orientation_covariance[8] = sample.heading_variance
    return message


def course_message(sample: CourseSample, frame_id: str) -> QuaternionStamped:
    """`geometry_msgs/QuaternionStamped` about Up; all zeros where not observable."""
    message = QuaternionStamped()
    message.header.stamp = time_message(sample.stamp_ns)
    message.header.frame_id = frame_id
    message.quaternion.z = sample.qz
    message.quaternion.w = sample.qw
    return message


def verdict_message(verdict: Verdict) -> DiagnosticArray:
    """A verdict as `diagnostic_msgs/DiagnosticArray`; numbers as text that reads back exactly."""
    values = verdict_values(verdict)
    return _array(verdict.stamp_ns, verdict.detector, verdict.state, verdict.reason, values)


def fusion_message(result: FusionResult) -> DiagnosticArray:
    """The fusion's result as `diagnostic_msgs/DiagnosticArray`."""
    values = fusion_values(result)
    return _array(result.stamp_ns, "fusion", result.state, result.reason, values)


def _array(
    stamp_ns: int, name: str, state: State, reason: str, values: Mapping[str, str]
) -> DiagnosticArray:
    message = DiagnosticArray()
    message.header.stamp = time_message(stamp_ns)
    message.status = [status(name, LEVELS[state], reason, values)]
    return message


def status(name: str, level: bytes, text: str, values: Mapping[str, str]) -> DiagnosticStatus:
    """A `diagnostic_msgs/DiagnosticStatus` with its values in order."""
    pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
    return DiagnosticStatus(name=name, level=level, message=text, values=pairs)
