# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Kullback-Leibler divergence of GPS statistics: Basan et al. 2022.

Subscribes flight_phase, gps/fix, gps/vel (ENU) and gps/satellites (UInt32), of which the last two
may be absent, and imu/data_raw for its stamps. Publishes kld/verdict (DiagnosticArray, with the
two divergences of every parameter), kld/hijacked (Bool), kld/margin (score over threshold,
Float64), kld/divergence (of the parameter that decides, nats, Float64) and kld/code (UInt8: 111
attack, 110 no attack, nothing while it cannot tell). Service ~/reset (std_srvs/Trigger) takes a
kept alarm back.
"""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import TwistStamped
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import NavSatFix
from std_msgs.msg import UInt8, UInt32
from std_srvs.srv import Trigger

from hijack_detect.detectors.kld import CODES, KldDetector
from hijack_detect.detectors.kld_parameters import KldParameters
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.nodes.detector_node import DetectorNode
from hijack_detect.nodes.outlet import Outlet
from hijack_detect.nodes.qos import SENSOR
from hijack_detect.nodes.running import run
from hijack_detect.nodes.wiring import Input, Topics, Wiring, phase_input, sensor_input
from hijack_detect.streams.headerless import SatelliteStamps
from hijack_detect.streams.messages import satellite_count


class KldDetectorNode(DetectorNode[KldParameters]):
    """Runs `KldDetector`.

    A number of satellites has no header. It gets the stamp of its fix by the order of publication,
    for which the executor must hand out the source times of messages: SingleThreadedExecutor does.
    """

    NEEDS_SOURCE_TIMES = True

    def __init__(self, wiring: Wiring) -> None:
        """Subscribe and advertise; see StageNode."""
        inputs = {
            "phase": phase_input(),
            "fix": sensor_input("fix", "gps/fix", NavSatFix, SENSOR),
            "velocity": sensor_input("velocity", "gps/vel", TwistStamped, SENSOR),
            "satellites": Input("gps/satellites", UInt32, SENSOR, satellite_count),
        }
        self._stamps = SatelliteStamps()
        super().__init__(
            KldDetector.NAME, KldParameters, KldDetector, inputs, wiring, ("divergence",)
        )
        self._code = Outlet(self, UInt8, "kld/code", wiring.rate_hz)
        self._said: int | None = None
        self.create_service(Trigger, "~/reset", self._reset)

    def samples(self, name: str, converted: Any, published_ns: int) -> list[tuple[str, Any]]:
        """See StageNode; a count follows once the fix after it is there."""
        return self._stamps.samples(name, published_ns, converted)

    def publish_output(self, output: Verdict) -> None:
        """Publish a verdict and its code."""
        super().publish_output(output)
        code = CODES.get(output.state)
        if code is not None:
            change, self._said = code != self._said, code
            self._code.publish(output.stamp_ns, lambda: UInt8(data=code), change=change)

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        detector = self.stage.component
        assert isinstance(detector, KldDetector)
        detector.reset()
        self.log.warning("alarm reset on request")
        response.success, response.message = True, "alarm reset"
        return response


def main() -> None:
    """Run the node."""
    run(lambda: KldDetectorNode(Topics()), __doc__ or "", SingleThreadedExecutor)


if __name__ == "__main__":
    main()
