# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Consistency of the GPS stream with itself: jumps, freezes, impossible motion, stamps.

Subscribes flight_phase, gps/fix, gps/vel (ENU) and gps/satellites (UInt32), of which the last two
may be absent, and imu/data_raw for its stamps. Publishes gnss/verdict (DiagnosticArray, with the
margin of every check), gnss/hijacked (Bool), gnss/margin (score over threshold, Float64), and the
margins gnss/jump, gnss/freeze, gnss/velocity_mismatch and gnss/velocity_mismatch_limit (part of the
full limits in force) as Float64. /diagnostics warn once a second of a receiver that is poor by its
own word (lost fixes, satellites, claimed accuracy), of a clock behind the stamps that runs at
another rate than the GPS's, of a latency that grew, and of more than one publisher on gps/fix; the
verdict depends on stamped messages alone and looks for what two streams do.
"""

from __future__ import annotations

from hijack_detect.detectors.gnss_checks.latency import later_words
from hijack_detect.detectors.gnss_sanity import CLOCK_RATE, LATER
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.estimation.clock_rate import clock_words
from hijack_detect.estimation.receiver_health import POOR, POOR_FIGURES, poor_words
from hijack_detect.monitor.parts import Part
from hijack_detect.nodes.detector_node import DetectorNode, run_detector
from hijack_detect.nodes.diagnostics import PublisherWatch
from hijack_detect.nodes.receiver_report import ReceiverReport, Subject

FIX = "gps/fix"
RECEIVER = Subject(
    "receiver",
    POOR_FIGURES,
    poor_words,
    good="nothing to object by its own word",
    over="the receiver is good again by its own word",
    title=POOR,
)
CLOCK = Subject(
    "clock of the stamps",
    frozenset({CLOCK_RATE}),
    lambda values: clock_words(values[CLOCK_RATE]) if CLOCK_RATE in values else "",
    good="no other rate than the GPS's seen",
    over="the clock of the stamps runs as the GPS's again",
    digits=4,
)
GROWTH = Subject(
    "growth of the latency",
    frozenset({LATER}),
    lambda values: later_words(values[LATER]) if LATER in values else "",
    good="none that position and velocity show",
    over="position and velocity agree without a growth of the latency again",
)


class GnssSanityNode(DetectorNode):
    """Runs `GnssSanityDetector`."""

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz)
        self._watch = PublisherWatch(self, self.diagnostics, (FIX,))
        self._reports = [
            ReceiverReport(self.diagnostics, self.log, subject)
            for subject in (RECEIVER, CLOCK, GROWTH)
        ]

    def publish_output(self, output: Verdict) -> None:
        """Publish a verdict, and what the receiver says of itself; see DetectorNode."""
        super().publish_output(output)
        for report in self._reports:
            report.add(output)


def main() -> None:
    """Run the node."""
    run_detector("gnss_sanity", __doc__ or "")


if __name__ == "__main__":
    main()
