# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Course over ground from successive fixes.

Subscribes gps/fix, and imu/data_raw for its stamps. Publishes gps/course
(geometry_msgs/QuaternionStamped, rotation about Up from East, all zeros where the course is not
observable) and gps_angle (std_msgs/Float64, Eq. 1 of Feng 2018: rad clockwise from North, 0 to 2
pi; the last value is held while not observable).
"""

from __future__ import annotations

from geometry_msgs.msg import QuaternionStamped
from std_msgs.msg import Float64

from hijack_detect.estimation.course import CourseParameters, gps_angle
from hijack_detect.monitor.parts import Part, row_of
from hijack_detect.nodes.engine import run_part
from hijack_detect.nodes.messages import course_message
from hijack_detect.nodes.part_node import PartNode
from hijack_detect.streams.samples import CourseSample


class GpsAngleNode(PartNode[CourseParameters]):
    """Runs `CourseEstimator`."""

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz)
        self._course = self.outlet(QuaternionStamped, "gps/course")
        self._angle = self.outlet(Float64, "gps_angle")
        self._held: float | None = None

    def publish_output(self, output: CourseSample) -> None:
        """Publish gps/course and gps_angle."""
        self._course.publish(output.stamp_ns, lambda: course_message(output, "map"))
        if output.observable:
            self._held = gps_angle(output)
        held = self._held
        if held is not None:
            self._angle.publish(output.stamp_ns, lambda: Float64(data=held))


def main() -> None:
    """Run the node."""
    run_part(row_of("gps_angle"), __doc__ or "")


if __name__ == "__main__":
    main()
