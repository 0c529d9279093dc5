"""Attitude from raw IMU and GPS, with the magnetometer where there is one.

Subscribes imu/data_raw, gps/fix, gps/vel (ENU), mag. Publishes imu/data (sensor_msgs/Imu with
orientation FLU to ENU, REP-145; covariance -1 until the heading is known) and yaw
(std_msgs/Float64, rad counter-clockwise from East).
"""

from __future__ import annotations

from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import Imu, MagneticField, NavSatFix
from std_msgs.msg import Float64

from hijack_detect.estimation.attitude import AttitudeEstimator
from hijack_detect.estimation.attitude_parameters import AttitudeParameters
from hijack_detect.estimation.rotation import heading
from hijack_detect.nodes.messages import imu_message
from hijack_detect.nodes.qos import INTERNAL, SENSOR
from hijack_detect.nodes.running import run
from hijack_detect.nodes.stage_node import StageNode, sensor_input
from hijack_detect.streams.samples import AttitudeSample


class AttitudeEstimatorNode(StageNode[AttitudeParameters]):
    """Runs `AttitudeEstimator`.

    Parameters are read-only: a restart in flight would blind every detector until the heading
    is found again.
    """

    def __init__(self) -> None:
        """Subscribe and advertise."""
        inputs = {
            "imu": sensor_input("imu", "imu/data_raw", Imu, SENSOR),
            "fix": sensor_input("fix", "gps/fix", NavSatFix, SENSOR),
            "velocity": sensor_input("velocity", "gps/vel", TwistStamped, SENSOR),
            "mag": sensor_input("mag", "mag", MagneticField, SENSOR),
        }
        super().__init__(
            "attitude_estimator", AttitudeParameters, AttitudeEstimator, inputs, read_only=True
        )
        self._imu = self.create_publisher(Imu, "imu/data", INTERNAL)
        self._yaw = self.create_publisher(Float64, "yaw", INTERNAL)

    def publish_output(self, output: AttitudeSample) -> None:
        """Publish imu/data, and yaw while somebody listens."""
        self._imu.publish(imu_message(output, "base_link"))
        if output.orientation is not None and self._yaw.get_subscription_count():
            self._yaw.publish(Float64(data=heading(output.orientation)))


def main() -> None:
    """Run the node."""
    run(AttitudeEstimatorNode, __doc__ or "")


if __name__ == "__main__":
    main()
