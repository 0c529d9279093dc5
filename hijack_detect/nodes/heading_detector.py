# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Headings of gyroscope, compass and GPS against each other: yaw without trust in the GPS.

Subscribes flight_phase, imu/data_raw, mag (may be absent), gps/fix, gps/vel (ENU) and imu/data.
Publishes heading/verdict (DiagnosticArray, which names the heading that disagrees),
heading/hijacked (Bool), heading/margin (score over threshold, Float64) and heading/difference
(estimator minus compass, rad, Float64).
"""

from __future__ import annotations

from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import Imu, MagneticField, NavSatFix

from hijack_detect.detectors.heading import HeadingDetector
from hijack_detect.detectors.heading_parameters import HeadingParameters
from hijack_detect.nodes.detector_node import DetectorNode
from hijack_detect.nodes.qos import INTERNAL, SENSOR
from hijack_detect.nodes.running import run
from hijack_detect.nodes.wiring import Topics, Wiring, phase_input, sensor_input


class HeadingDetectorNode(DetectorNode[HeadingParameters]):
    """Runs `HeadingDetector`."""

    def __init__(self, wiring: Wiring) -> None:
        """Subscribe and advertise; see StageNode."""
        inputs = {
            "phase": phase_input(),
            "imu": sensor_input("imu", "imu/data_raw", Imu, SENSOR),
            "mag": sensor_input("mag", "mag", MagneticField, SENSOR),
            "fix": sensor_input("fix", "gps/fix", NavSatFix, SENSOR),
            "velocity": sensor_input("velocity", "gps/vel", TwistStamped, SENSOR),
            "attitude": sensor_input("attitude", "imu/data", Imu, INTERNAL),
        }
        super().__init__(
            HeadingDetector.NAME,
            HeadingParameters,
            HeadingDetector,
            inputs,
            wiring,
            ("difference",),
        )


def main() -> None:
    """Run the node."""
    run(lambda: HeadingDetectorNode(Topics()), __doc__ or "")


if __name__ == "__main__":
    main()
