# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Drag as an airspeed sensor: a GPS velocity that needs a wind no atmosphere makes.

Subscribes flight_phase, imu/data, gps/fix and gps/vel (ENU), and imu/data_raw for its stamps.
Publishes drag/verdict (DiagnosticArray), drag/hijacked (Bool), drag/margin (score over threshold,
Float64) and drag/wind_change (m/s, Float64).
"""

from __future__ import annotations

from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import Imu, NavSatFix

from hijack_detect.detectors.drag import DragDetector
from hijack_detect.detectors.drag_parameters import DragParameters
from hijack_detect.nodes.detector_node import DetectorNode
from hijack_detect.nodes.qos import INTERNAL, SENSOR
from hijack_detect.nodes.running import run
from hijack_detect.nodes.wiring import Topics, Wiring, phase_input, sensor_input


class DragDetectorNode(DetectorNode[DragParameters]):
    """Runs `DragDetector`."""

    def __init__(self, wiring: Wiring) -> None:
        """Subscribe and advertise; see StageNode."""
        inputs = {
            "phase": phase_input(),
            "attitude": sensor_input("attitude", "imu/data", Imu, INTERNAL),
            "fix": sensor_input("fix", "gps/fix", NavSatFix, SENSOR),
            "velocity": sensor_input("velocity", "gps/vel", TwistStamped, SENSOR),
        }
        super().__init__(
            DragDetector.NAME, DragParameters, DragDetector, inputs, wiring, ("wind_change",)
        )


def main() -> None:
    """Run the node."""
    run(lambda: DragDetectorNode(Topics()), __doc__ or "")


if __name__ == "__main__":
    main()
