# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""GPS acceleration against the accelerometer: the DATE method of Feng et al. 2018, section 3.4.

Subscribes flight_phase, imu/data, gps/fix and gps/vel (ENU), and imu/data_raw for its stamps.
Publishes date/verdict (DiagnosticArray), date/hijacked (Bool), date/margin (score over threshold,
Float64), date/delta_ax and date/delta_ay (body forward and left, m/s^2, Float64).
"""

from __future__ import annotations

from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import Imu, NavSatFix

from hijack_detect.detectors.date import DateDetector
from hijack_detect.detectors.date_parameters import DateParameters
from hijack_detect.nodes.detector_node import DetectorNode
from hijack_detect.nodes.qos import INTERNAL, SENSOR
from hijack_detect.nodes.running import run
from hijack_detect.nodes.wiring import Topics, Wiring, phase_input, sensor_input


class DateDetectorNode(DetectorNode[DateParameters]):
    """Runs `DateDetector`."""

    def __init__(self, wiring: Wiring) -> None:
        """Subscribe and advertise; see StageNode."""
        inputs = {
            "phase": phase_input(),
            "attitude": sensor_input("attitude", "imu/data", Imu, INTERNAL),
            "fix": sensor_input("fix", "gps/fix", NavSatFix, SENSOR),
            "velocity": sensor_input("velocity", "gps/vel", TwistStamped, SENSOR),
        }
        super().__init__(
            DateDetector.NAME,
            DateParameters,
            DateDetector,
            inputs,
            wiring,
            ("delta_ax", "delta_ay"),
        )


def main() -> None:
    """Run the node."""
    run(lambda: DateDetectorNode(Topics()), __doc__ or "")


if __name__ == "__main__":
    main()
