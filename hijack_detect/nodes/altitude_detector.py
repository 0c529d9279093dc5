# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""GPS height against the barometer, and against the vertical specific force.

Subscribes flight_phase, imu/data, pressure (sensor_msgs/FluidPressure, Pa), gps/vel (ENU) and
gps/fix; pressure and gps/vel may be absent. imu/data_raw is heard for its stamps. Publishes
altitude/verdict (DiagnosticArray), altitude/hijacked (Bool), altitude/margin (score over
threshold, Float64) and altitude/difference (GPS height less barometer less reference, m, Float64).
"""

from __future__ import annotations

from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import FluidPressure, Imu, NavSatFix

from hijack_detect.detectors.altitude import AltitudeDetector
from hijack_detect.detectors.altitude_parameters import AltitudeParameters
from hijack_detect.nodes.detector_node import DetectorNode
from hijack_detect.nodes.qos import INTERNAL, SENSOR
from hijack_detect.nodes.running import run
from hijack_detect.nodes.wiring import Topics, Wiring, phase_input, sensor_input


class AltitudeDetectorNode(DetectorNode[AltitudeParameters]):
    """Runs `AltitudeDetector`."""

    def __init__(self, wiring: Wiring) -> None:
        """Subscribe and advertise; see StageNode."""
        inputs = {
            "phase": phase_input(),
            "attitude": sensor_input("attitude", "imu/data", Imu, INTERNAL),
            "pressure": sensor_input("pressure", "pressure", FluidPressure, SENSOR),
            "velocity": sensor_input("velocity", "gps/vel", TwistStamped, SENSOR),
            "fix": sensor_input("fix", "gps/fix", NavSatFix, SENSOR),
        }
        super().__init__(
            AltitudeDetector.NAME,
            AltitudeParameters,
            AltitudeDetector,
            inputs,
            wiring,
            ("difference",),
        )


def main() -> None:
    """Run the node."""
    run(lambda: AltitudeDetectorNode(Topics()), __doc__ or "")


if __name__ == "__main__":
    main()
