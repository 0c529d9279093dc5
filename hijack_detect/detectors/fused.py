# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the fusion says, read back from its message."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hijack_detect.detectors.verdict import State
from hijack_detect.streams.messages import BadMessage, header_stamp_ns, only_status


@dataclass(frozen=True, slots=True)
class Fused:
    """One fusion/verdict: state, alert with its stamp and causes, who is missing, the reason."""

    stamp_ns: int
    state: State
    alert: bool
    alert_since_ns: int | None
    degraded: tuple[str, ...]
    reason: str
    causes: tuple[str, ...] = ()
    """Detectors that led to the alert."""


def fused_from(message: Any) -> Fused:
    """Convert the `diagnostic_msgs/DiagnosticArray` of fusion/verdict.

    Raises:
        BadMessage: It is no verdict of the fusion; the text says what is missing or wrong.
    """
    status = only_status(message)
    values = {pair.key: pair.value for pair in status.values}
    try:
        since = values["alert_since_ns"]
        since_ns = int(since) if since else None
        if since_ns is not None and not 0 <= since_ns < 2**63:
            raise BadMessage(f"the verdict of the fusion has alert_since_ns {since}")
        return Fused(
            header_stamp_ns(message),
            State(values["state"]),
            values["alert"] == "true",
            since_ns,
            tuple(values["degraded"].split()),
            status.message,
            tuple(values["causes"].split()),
        )
    except KeyError as error:
        raise BadMessage(f"the verdict of the fusion has no {error}") from error
    except BadMessage:
        raise
    except ValueError as error:
        raise BadMessage(f"the verdict of the fusion: {error}") from error
