# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Yaw against GPS course: Feng et al. 2018, Algorithms 1 and 2.

Subscribes flight_phase, imu/data and gps/course. Publishes correlation/verdict (DiagnosticArray),
correlation/hijacked (Bool), correlation/margin (score over threshold, Float64),
correlation/coefficient (rho, Float64) and correlation/mean_difference (mean course minus mean yaw,
rad, Float64).
"""

from __future__ import annotations

from geometry_msgs.msg import QuaternionStamped
from sensor_msgs.msg import Imu

from hijack_detect.detectors.correlation import CorrelationDetector
from hijack_detect.detectors.correlation_parameters import CorrelationParameters
from hijack_detect.nodes.detector_node import DetectorNode
from hijack_detect.nodes.qos import INTERNAL
from hijack_detect.nodes.running import run
from hijack_detect.nodes.wiring import Topics, Wiring, phase_input, sensor_input


class CorrelationDetectorNode(DetectorNode[CorrelationParameters]):
    """Runs `CorrelationDetector`."""

    def __init__(self, wiring: Wiring) -> None:
        """Subscribe and advertise; see StageNode."""
        inputs = {
            "phase": phase_input(),
            "attitude": sensor_input("attitude", "imu/data", Imu, INTERNAL),
            "course": sensor_input("course", "gps/course", QuaternionStamped, INTERNAL),
        }
        super().__init__(
            CorrelationDetector.NAME,
            CorrelationParameters,
            CorrelationDetector,
            inputs,
            wiring,
            ("coefficient", "mean_difference"),
        )


def main() -> None:
    """Run the node."""
    run(lambda: CorrelationDetectorNode(Topics()), __doc__ or "")


if __name__ == "__main__":
    main()
