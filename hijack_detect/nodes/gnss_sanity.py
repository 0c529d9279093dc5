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

from typing import Any

from geometry_msgs.msg import TwistStamped
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import NavSatFix
from std_msgs.msg import UInt32

from hijack_detect.detectors.gnss_checks.latency import later_words
from hijack_detect.detectors.gnss_sanity import CLOCK_RATE, LATER, GnssSanityDetector
from hijack_detect.detectors.gnss_sanity_parameters import GnssSanityParameters
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.estimation.clock_rate import clock_words
from hijack_detect.estimation.receiver_health import POOR, POOR_FIGURES, poor_words
from hijack_detect.nodes.detector_node import DetectorNode
from hijack_detect.nodes.publishers import PublisherWatch
from hijack_detect.nodes.qos import SENSOR
from hijack_detect.nodes.receiver_report import ReceiverReport, Subject
from hijack_detect.nodes.running import run
from hijack_detect.nodes.wiring import Input, Topics, Wiring, phase_input, sensor_input
from hijack_detect.streams.headerless import SatelliteStamps
from hijack_detect.streams.messages import satellite_count

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
FIGURES = ("jump", "freeze", "velocity_mismatch", "velocity_mismatch_limit")


class GnssSanityNode(DetectorNode[GnssSanityParameters]):
    """Runs `GnssSanityDetector`.

    A number of satellites has no header; see `KldDetectorNode`.
    """

    NEEDS_SOURCE_TIMES = True

    def __init__(self, wiring: Wiring) -> None:
        """Subscribe and advertise; see StageNode."""
        inputs = {
            "phase": phase_input(),
            "fix": sensor_input("fix", FIX, NavSatFix, SENSOR),
            "velocity": sensor_input("velocity", "gps/vel", TwistStamped, SENSOR),
            "satellites": Input("gps/satellites", UInt32, SENSOR, satellite_count),
        }
        self._stamps = SatelliteStamps()
        super().__init__(
            GnssSanityDetector.NAME,
            GnssSanityParameters,
            GnssSanityDetector,
            inputs,
            wiring,
            FIGURES,
            node_name="gnss_sanity",
        )
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

    def samples(self, name: str, converted: Any, published_ns: int) -> list[tuple[str, Any]]:
        """See StageNode; a count follows once the fix after it is there."""
        return self._stamps.samples(name, published_ns, converted)


def main() -> None:
    """Run the node."""
    run(lambda: GnssSanityNode(Topics()), __doc__ or "", SingleThreadedExecutor)


if __name__ == "__main__":
    main()
