# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Phase of the flight and health of the IMU, by which the detectors know when they may judge.

Subscribes imu/data_raw, pressure, gps/vel (ENU) and gps/fix; all but the first may be absent.
Publishes flight_phase (diagnostic_msgs/DiagnosticArray with the stamp of the IMU sample: phase is
unknown, standing, handled, flying, landing or crashed; since_ns; imu_rate_hz; imu_fault, empty
while the IMU can be used; the message has the reason), five times a second, and the same on
/diagnostics once a second.
"""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray

from hijack_detect.estimation.flight_phase import FlightPhaseParameters
from hijack_detect.monitor.parts import Part, row_of
from hijack_detect.nodes.engine import PHASE_TOPIC, run_part
from hijack_detect.nodes.messages import phase_message
from hijack_detect.nodes.part_node import PartNode
from hijack_detect.streams.samples import NANOSECONDS, PhaseSample

PHASE_SUBJECT = "phase of the flight"
"""What the diagnostics are about."""


class FlightPhaseNode(PartNode[FlightPhaseParameters]):
    """Runs `FlightPhaseEstimator`."""

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz)
        self._phase = self.outlet(DiagnosticArray, PHASE_TOPIC)
        self._last: tuple[object, str] | None = None
        self._diagnosed_s = 0

    def publish_output(self, output: PhaseSample) -> None:
        """Publish flight_phase, and log its changes."""
        now = (output.phase, output.imu_fault)
        news, self._last = now != self._last, now
        self._phase.publish(output.stamp_ns, lambda: phase_message(output), change=news)
        second = output.stamp_ns // NANOSECONDS
        if news or second != self._diagnosed_s:
            self._diagnosed_s = second
            self.diagnostics.publish(PHASE_SUBJECT, phase_message(output).status[0])
        if news:
            fault = f"; {output.imu_fault}" if output.imu_fault else ""
            self.log.info(f"{output.phase.value}: {output.reason}{fault}")


def main() -> None:
    """Run the node."""
    run_part(row_of("flight_phase"), __doc__ or "")


if __name__ == "__main__":
    main()
