# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Verdicts as the values of a `diagnostic_msgs/DiagnosticArray`, and back.

A message holds one status: its name is the detector's or `fusion`, its message the reason, its
values what the functions here write. Numbers are written so that they read back to the bit. The
readers use attributes only, so a message may come from rclpy or from rosbags.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.streams.messages import BadMessage, header_stamp_ns, only_status


@dataclass(frozen=True, slots=True)
class FusionStatus:
    """The content of one fusion/verdict; see FusionResult."""

    stamp_ns: int
    state: State
    alert: bool
    alert_since_ns: int | None
    confidence: float
    lost: tuple[str, ...]
    degraded: tuple[str, ...]
    causes: tuple[str, ...]
    reason: str


def verdict_values(verdict: Verdict) -> dict[str, str]:
    """Values of a detector's verdict, its figures last."""
    return {
        "state": verdict.state.value,
        "score": repr(verdict.score),
        "threshold": repr(verdict.threshold),
        "margin": repr(verdict.margin),
        **{name: repr(value) for name, value in verdict.values.items()},
    }


def fusion_values(result: FusionResult) -> dict[str, str]:
    """Values of a result of the fusion, the detectors last."""
    since = "" if result.alert_since_ns is None else str(result.alert_since_ns)
    return {
        "state": result.state.value,
        "alert": str(result.alert).lower(),
        "alert_since_ns": since,
        "confidence": repr(result.confidence),
        "lost": " ".join(result.lost),
        "degraded": " ".join(result.degraded),
        "causes": " ".join(result.causes),
        **({} if result.silent_s is None else {"silent_s": f"{result.silent_s:.1f}"}),
        **{f"{name}.state": v.state.value for name, v in result.detectors.items()},
        **{f"{name}.margin": repr(v.margin) for name, v in result.detectors.items()},
    }


def verdict_from(message: Any) -> Verdict:
    """Read the message of a detector's verdict.

    Raises:
        BadMessage: It is no verdict; the text names what is missing or wrong.
    """
    status = only_status(message)
    values = {pair.key: pair.value for pair in status.values}
    try:
        state = State(values.pop("state"))
        score, threshold = float(values.pop("score")), float(values.pop("threshold"))
        values.pop("margin", None)
        numbers = {name: float(value) for name, value in values.items()}
    except KeyError as error:
        raise BadMessage(f"the verdict of {status.name!r} has no {error}") from error
    except ValueError as error:
        raise BadMessage(f"the verdict of {status.name!r}: {error}") from error
    if not (math.isfinite(score) and math.isfinite(threshold) and threshold > 0.0):
        raise BadMessage(f"the verdict of {status.name!r} has score {score} over {threshold}")
    stamp_ns = header_stamp_ns(message)
    return Verdict(status.name, stamp_ns, state, score, threshold, status.message, numbers)


def fusion_from(message: Any) -> FusionStatus:
    """Read the message of fusion/verdict.

    Raises:
        BadMessage: It is no verdict of the fusion; the text names what is missing or wrong.
    """
    status = only_status(message)
    values = {pair.key: pair.value for pair in status.values}
    try:
        alert, since = values["alert"], values["alert_since_ns"]
        if alert not in ("true", "false"):
            raise ValueError(f"alert is {alert!r}")
        since_ns = int(since) if since else None
        if since_ns is not None and not 0 <= since_ns < 2**63:
            raise ValueError(f"alert_since_ns is {since}")
        return FusionStatus(
            header_stamp_ns(message),
            State(values["state"]),
            alert == "true",
            since_ns,
            float(values["confidence"]),
            tuple(values["lost"].split()),
            tuple(values["degraded"].split()),
            tuple(values["causes"].split()),
            status.message,
        )
    except KeyError as error:
        raise BadMessage(f"the verdict of the fusion has no {error}") from error
    except ValueError as error:
        raise BadMessage(f"the verdict of the fusion: {error}") from error
