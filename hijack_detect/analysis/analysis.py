# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The analysis of a bag as data: `docs/analysis.schema.json` describes it."""

from __future__ import annotations

import enum
import json
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from hijack_detect.detectors.verdict import State
from hijack_detect.replay.truth import Source


class Outcome(enum.Enum):
    """Comparison of the alerts with what is known of the attack.

    - detected: the first alert came inside the attack.
    - missed: there was an attack and no alert.
    - late: the first alert came after the attack had ended.
    - false_alert: the first alert came before the attack, or the flight is known to be clean.
    - no_attack_no_alert: the flight is known to be clean, and there was no alert.
    - alert_unlabelled: an alert, and nothing is known of an attack.
    - no_alert_unlabelled: no alert, and nothing is known of an attack.
    - not_judged: no alert, no attack that is known, and nothing could have seen one; `not_judged`
      has the reason.
    """

    DETECTED = "detected"
    MISSED = "missed"
    LATE = "late"
    FALSE_ALERT = "false_alert"
    NO_ATTACK_NO_ALERT = "no_attack_no_alert"
    ALERT_UNLABELLED = "alert_unlabelled"
    NO_ALERT_UNLABELLED = "no_alert_unlabelled"
    NOT_JUDGED = "not_judged"


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)


class Interval(_Model):
    """A time, from start (inclusive) to end (exclusive)."""

    start_s: float
    """Seconds from the bag's first message."""
    end_s: float
    """Seconds from the bag's first message; the bag's end for what was still going on there."""


class Alert(Interval):
    """One alert, as `hijack_alert` publishes it."""

    detectors: tuple[str, ...]
    """Detectors that led to it."""
    confidence: float = Field(ge=0.0, le=1.0)
    """`hijack_confidence` at its start; not a calibrated probability."""
    cause: str
    """Why, in words."""


class Peak(_Model):
    """The largest margin of a detector."""

    margin: float = Field(ge=0.0)
    """Score over threshold: above 1 the detector calls the GPS spoofed."""
    at_s: float
    """Seconds from the bag's first message."""
    reason: str
    """The detector's reason then."""


class DetectorAnalysis(_Model):
    """Verdicts of one detector."""

    alarms: tuple[Interval, ...]
    """Times in the state `alarm`."""
    state_s: dict[State, float]
    """Seconds in each state; together they are the flight."""
    told_s: float = Field(ge=0.0)
    """Seconds in the air in which it could tell."""
    largest_margin: Peak | None
    """Null for a detector that could never tell."""


class Visible(_Model):
    """Time in which a pull would have been seen: an offset of the GPS that accelerates steadily."""

    acceleration: float = Field(gt=0.0)
    """Acceleration in m/s²."""
    time_s: float = Field(ge=0.0)
    """Seconds in the air in which `coast` claimed to see this size, and all that is larger."""


class Spoof(_Model):
    """The attack, where it is known from elsewhere."""

    onset_s: float
    """First spoofed fix, seconds from the bag's first message."""
    end_s: float | None
    """Seconds from the bag's first message; null if it lasts to the end of the flight."""
    known_from: Source
    """The injected scenario, ground truth topics in the bag, or the label beside it."""
    largest_deviation_m: float | None
    """Largest distance of the reported from the true position, if the true one is known."""


class Analysis(_Model):
    """The analysis of one bag. Times are seconds from the bag's first message.

    A message is placed by its header stamp, and the first message by its log time.
    """

    version: Literal[2] = 2
    """Version of this format; it grows when a field changes its meaning or is taken away."""
    bag: str
    """The bag, as it was named."""
    start_ns: int
    """Log time of its first message, nanoseconds since 1970."""
    duration_s: float
    """Seconds from its first to its last message."""
    scenario: str | None
    """The file of the injected attack."""
    policy: str
    """Policy of the fusion."""
    outcome: Outcome
    """Comparison of the alerts with what is known of the attack."""
    verdict: str
    """The outcome in one sentence."""
    not_judged: str | None
    """Reason why nothing could have seen a carry-off; null if something could."""
    alerts: tuple[Alert, ...]
    """All alerts. One is latched: it lasts to the end of the bag."""
    alarms: tuple[Alert, ...]
    """All alerts that there are if each is taken back once its causes have been quiet."""
    detectors: dict[str, DetectorAnalysis]
    """Verdicts of each detector, by name."""
    in_air_s: float = Field(ge=0.0)
    """Seconds in the air."""
    judged_s: float = Field(ge=0.0)
    """Seconds in the air in which a detector could tell that could see a carry-off."""
    at_risk_s: float = Field(ge=0.0)
    """Seconds in the air in which an alert was possible, until the first alert."""
    receiver_poor_s: float = Field(default=0.0, ge=0.0)
    """Seconds for which the receiver was poor by its own claim; a note names in what."""
    gps_late_s: float = Field(default=0.0, ge=0.0)
    """Seconds for which the GPS lagged by more than receivers do; a note gives by how much."""
    visible: Visible | None
    """Worth of a clean verdict, see docs/analyze-a-log.md; null if `coast` could not tell."""
    visible_steps: tuple[Visible, ...]
    """The same for pulls of other sizes."""
    spoof: Spoof | None
    """The attack, null if there is none or none is known; see `outcome`."""
    time_to_detect_s: float | None
    """From the onset to the first alert at or after it."""
    deviation_at_alarm_m: float | None
    """Distance of the reported from the true position at that alert, if it is known."""
    skipped: dict[str, int]
    """Number of messages that were left out, by reason."""
    notes: tuple[str, ...]
    """Notes on the sensors and their clocks, a sentence each."""


def schema_text() -> str:
    """The JSON schema of an analysis, as docs/analysis.schema.json holds it."""
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **Analysis.model_json_schema(mode="serialization"),
    }
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"
