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

from std_msgs.msg import UInt8
from std_srvs.srv import Trigger

from hijack_detect.detectors.kld import CODES, KldDetector
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.monitor.parts import Part
from hijack_detect.nodes.detector_node import DetectorNode, run_detector
from hijack_detect.nodes.outlet import Outlet


class KldDetectorNode(DetectorNode):
    """Runs `KldDetector`."""

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz)
        self._code = Outlet(self, UInt8, "kld/code", rate_hz)
        self._said: int | None = None
        self.create_service(Trigger, "~/reset", self._reset)

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
    run_detector("kld_detector", __doc__ or "")


if __name__ == "__main__":
    main()
