# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The output of a detector: one verdict per evaluation, never silence."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field


class State(enum.Enum):
    """What a verdict claims. Only NORMAL and worse are statements about the GPS."""

    NOT_READY = "not_ready"
    """Too little data yet."""
    NOT_OBSERVABLE = "not_observable"
    """In this phase of flight the method cannot tell; see the reason."""
    NORMAL = "normal"
    SUSPICIOUS = "suspicious"
    ALARM = "alarm"
    STALE = "stale"
    """An input has stopped."""


JUDGED = frozenset({State.NORMAL, State.SUSPICIOUS, State.ALARM})
"""States that judge the GPS."""
RAISED = frozenset({State.SUSPICIOUS, State.ALARM})
"""States that are evidence against the GPS."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """One evaluation of one detector at one header stamp.

    `score` grows with suspicion and alarms at `threshold` (same unit); both are NaN-free:
    a score that is not defined is 0, as the state shows. `values` are further figures by name.
    """

    detector: str
    stamp_ns: int
    state: State
    score: float
    threshold: float
    reason: str
    values: Mapping[str, float] = field(default_factory=dict)

    @property
    def margin(self) -> float:
        """`score / threshold`: 1 and above would alarm, a gate that never fires stays visible."""
        return self.score / self.threshold
