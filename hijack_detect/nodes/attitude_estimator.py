# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attitude from raw IMU and GPS, with the magnetometer where there is one.

Subscribes imu/data_raw, gps/fix, gps/vel (ENU), mag. Publishes imu/data (sensor_msgs/Imu with
orientation FLU to ENU, REP-145; covariance -1 until the heading is known) and yaw
(std_msgs/Float64, rad counter-clockwise from East).
"""

from __future__ import annotations

from sensor_msgs.msg import Imu
from std_msgs.msg import Float64

from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.rotation import heading
from hijack_detect.monitor.parts import Part, row_of
from hijack_detect.nodes.engine import run_part
from hijack_detect.nodes.messages import imu_message
from hijack_detect.nodes.part_node import PartNode
from hijack_detect.streams.samples import AttitudeSample


class AttitudeEstimatorNode(PartNode[AttitudeParameters]):
    """Runs `AttitudeEstimator`.

    Parameters are read-only: a restart in flight would blind every detector until the heading
    is found again.
    """

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz, read_only=True)
        self._imu = self.outlet(Imu, "imu/data")
        self._yaw = self.outlet(Float64, "yaw")

    def publish_output(self, output: AttitudeSample) -> None:
        """Publish imu/data and yaw."""
        self._imu.publish(output.stamp_ns, lambda: imu_message(output, "base_link"))
        q = output.orientation
        if q is not None:
            self._yaw.publish(output.stamp_ns, lambda: Float64(data=heading(q)))


def main() -> None:
    """Run the node."""
    run_part(row_of("attitude_estimator"), __doc__ or "")


if __name__ == "__main__":
    main()
