# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What an analysis keeps of all that is said about a flight, however long that is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hijack_detect.detectors.verdict import JUDGED, Verdict
from hijack_detect.evaluation.analysis.alarms import AlertSpan, AlertSpans, Span, StateSpans

MONITOR = "monitor"
"""Name of the fusion's spans."""
FUSION = "fusion"


class Account:
    """Listens to a monitor and keeps states, alerts and the largest margins.

    Attributes:
        peaks: The verdict with the largest margin of each detector that could ever tell.
        newest_ns: Stamp of the fusion's last word, nanoseconds; 0 before the first.
    """

    def __init__(self, detectors: Sequence[str], start_ns: int, stale_ns: int) -> None:
        """Begin a flight.

        Args:
            detectors: Names of the parts that give verdicts.
            start_ns: Where it begins, nanoseconds.
            stale_ns: Longest time for which a verdict holds, nanoseconds.
        """
        self._spans = {name: StateSpans(start_ns, stale_ns) for name in (MONITOR, *detectors)}
        self._alerts = AlertSpans()
        self.peaks: dict[str, Verdict] = {}
        self.newest_ns = 0

    def hear(self, part: str, output: Any) -> None:
        """Take what a part of the monitor puts out."""
        if part == FUSION:
            self._spans[MONITOR].add(output)
            self._alerts.add(output)
            self.newest_ns = output.stamp_ns
        elif part in self._spans:
            self._spans[part].add(output)
            self._compare(part, output)

    def _compare(self, name: str, verdict: Verdict) -> None:
        peak = self.peaks.get(name)
        if verdict.state in JUDGED and (peak is None or verdict.margin > peak.margin):
            self.peaks[name] = verdict

    def spans(self, end_ns: int) -> dict[str, list[Span]]:
        """The states of the fusion, under `MONITOR`, and of each detector, until a flight's end."""
        return {name: one.finish(end_ns) for name, one in self._spans.items()}

    def alerts(self, end_ns: int) -> list[AlertSpan]:
        """All alerts until a flight's end, nanoseconds."""
        return self._alerts.finish(end_ns)
