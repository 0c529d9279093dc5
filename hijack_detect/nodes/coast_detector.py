# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Inertial consistency: an acceleration of the GPS that the IMU did not feel.

Subscribes flight_phase, imu/data_raw, gps/fix, gps/vel (ENU) and mag; the last two may be absent.
Publishes coast/verdict (DiagnosticArray), coast/hijacked (Bool), coast/margin (score over
threshold, Float64), and as Float64 coast/score and coast/threshold (standard deviations),
coast/acceleration (m/s^2), coast/direction (rad, counter-clockwise from East) and
coast/smallest_visible (m/s^2: what it could see now). /diagnostics warn once a second of a GPS that
lags by more than receivers do.
"""

from __future__ import annotations

from hijack_detect.detectors.verdict import Verdict
from hijack_detect.estimation.lag_ekf import LATE, LATE_FIGURES, late_words
from hijack_detect.monitor.parts import Part
from hijack_detect.nodes.detector_node import DetectorNode, run_detector
from hijack_detect.nodes.receiver_report import ReceiverReport, Subject

LATENCY = Subject(
    "latency of the GPS",
    LATE_FIGURES,
    late_words,
    good="no later than receivers are",
    over="the GPS is no later than receivers are again",
    title=LATE,
    digits=2,
)


class CoastDetectorNode(DetectorNode):
    """Runs `CoastDetector`."""

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz)
        self._latency = ReceiverReport(self.diagnostics, self.log, LATENCY)

    def publish_output(self, output: Verdict) -> None:
        """Publish a verdict, and whether the GPS is late; see DetectorNode."""
        super().publish_output(output)
        self._latency.add(output)


def main() -> None:
    """Run the node."""
    run_detector("coast_detector", __doc__ or "")


if __name__ == "__main__":
    main()
