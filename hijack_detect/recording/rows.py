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
from hijack_detect.recording.snapshot import Written
from hijack_detect.recording.snapshot_folder import SNAPSHOTS
from hijack_detect.streams.messages import BadMessage, header_stamp_ns, only_status

MAX_TEXT = 2000
"""Longer texts are cut: a row stays small whatever a message holds."""
Value = int | float | str | None


@dataclass(frozen=True, slots=True)
class Row:
    """A row for one table, without its session, which the journal knows."""

    table: str
    values: tuple[Value, ...]

    @property
    def size(self) -> int:
        """About what the row needs in the file, bytes."""
        return 24 + sum(len(one) * 2 if isinstance(one, str) else 9 for one in self.values)


@dataclass(frozen=True, slots=True)
class FusionTold:
    """What a verdict of the fusion says of the alert."""

    stamp_ns: int
    alert: bool
    state: str
    alert_since_ns: int | None
    confidence: float
    causes: str
    lost: str
    reason: str


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


def fusion_told(message: Any) -> FusionTold:
    """Read a verdict of the fusion, `diagnostic_msgs/DiagnosticArray`.

    Raises:
        BadMessage: It is none.
    """
    status = only_status(message)
    values = {pair.key: pair.value for pair in status.values}
    try:
        since, alert = values["alert_since_ns"], values["alert"]
        return FusionTold(
            header_stamp_ns(message),
            {"true": True, "false": False}[alert],
            _text(values["state"]),
            int(since) if since else None,
            float(values["confidence"]),
            _text(values["causes"]),
            _text(values["lost"]),
            _text(status.message),
        )
    except (KeyError, ValueError) as error:
        raise BadMessage(f"the verdict of the fusion has no usable {error}") from error


def alert_row(received_ns: int, told: FusionTold) -> Row:
    """Row of a change of the alert or of the fusion's state."""
    return Row(
        "alerts",
        (
            received_ns,
            told.stamp_ns,
            int(told.alert),
            told.state,
            told.alert_since_ns,
            _number(told.confidence),
            told.causes,
            told.lost,
            told.reason,
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
