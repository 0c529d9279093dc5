# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From messages to rows of the journal, in the order of the schema's columns.

The functions read attributes only, so a message may come from rclpy or from rosbags.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

from hijack_detect.detectors.verdict import Verdict
from hijack_detect.monitor.verdict_messages import FusionStatus
from hijack_detect.recording.snapshots import SNAPSHOTS, Written
from hijack_detect.streams.messages import header_stamp_ns

MAX_TEXT = 2000
"""Longer texts are cut. Chosen: far above every reason, and a row stays small."""
Value = int | float | str | None


@dataclass(frozen=True, slots=True)
class Row:
    """A row for one table, without its session, which the journal knows."""

    table: str
    values: tuple[Value, ...]

    @property
    def size(self) -> int:
        """Upper estimate of its bytes in the file: 9 a number, 2 a character, 24 beside them."""
        return 24 + sum(len(one) * 2 if isinstance(one, str) else 9 for one in self.values)


def fix_row(received_ns: int, message: Any) -> Row:
    """Row of a `sensor_msgs/NavSatFix`."""
    variances = (message.position_covariance[index] for index in (0, 4, 8))
    position = (message.latitude, message.longitude, message.altitude)
    return Row(
        "fixes",
        (
            received_ns,
            header_stamp_ns(message),
            *map(_number, position),
            int(message.status.status),
            *map(_number, variances),
        ),
    )


def velocity_row(received_ns: int, message: Any) -> Row:
    """Row of a `geometry_msgs/TwistStamped`."""
    linear = message.twist.linear
    numbers = map(_number, (linear.x, linear.y, linear.z))
    return Row("velocities", (received_ns, header_stamp_ns(message), *numbers))


def satellites_row(received_ns: int, message: Any, stamp_ns: int | None) -> Row:
    """Row of a `std_msgs/UInt32`, which has no stamp of its own."""
    return Row("satellites", (received_ns, stamp_ns, int(message.data)))


def verdict_row(received_ns: int, verdict: Verdict) -> Row:
    """Row of a detector's verdict."""
    numbers = {name: _number(value) for name, value in verdict.values.items()}
    return Row(
        "verdicts",
        (
            received_ns,
            verdict.stamp_ns,
            _text(verdict.detector),
            verdict.state.value,
            verdict.score,
            verdict.threshold,
            _text(verdict.reason),
            json.dumps(numbers, separators=(",", ":")),
        ),
    )


def alert_row(received_ns: int, status: FusionStatus) -> Row:
    """Row of a change of the alert or of the fusion's state."""
    return Row(
        "alerts",
        (
            received_ns,
            status.stamp_ns,
            int(status.alert),
            status.state.value,
            status.alert_since_ns,
            _number(status.confidence),
            _text(" ".join(status.causes)),
            _text(" ".join(status.lost)),
            _text(status.reason),
        ),
    )


def snapshot_row(received_ns: int, written: Written) -> Row:
    """Row of a snapshot; its path is relative to the journal's folder."""
    snapshot = written.snapshot
    return Row(
        "snapshots",
        (
            received_ns,
            snapshot.alerts_ns[0],
            snapshot.name,
            f"{SNAPSHOTS}/{snapshot.directory}",
            snapshot.messages[0].log_ns,
            snapshot.messages[-1].log_ns,
            len(snapshot.messages),
            written.size,
            len(snapshot.alerts_ns),
            int(snapshot.complete),
        ),
    )


def event_row(received_ns: int, kind: str, text: str) -> Row:
    """Row of something that happened to the recorder itself."""
    return Row("events", (received_ns, kind, _text(text)))


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _text(text: str) -> str:
    return text if len(text) <= MAX_TEXT else text[: MAX_TEXT - 1] + "…"
