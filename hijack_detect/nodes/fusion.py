"""Fuses the detectors' verdicts into hijack_alert.

Subscribes DETECTOR/verdict of every detector. Publishes hijack_alert (Bool, latched, reliable
and transient local, repeated every second), hijack_confidence (Float64, 0 to 1), fusion/verdict
(DiagnosticArray) and /diagnostics. Service ~/reset (std_srvs/Trigger) takes the alert back.
"""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_msgs.msg import Bool, Float64
from std_srvs.srv import Trigger

from hijack_detect.detectors.fusion import Fusion, FusionResult
from hijack_detect.detectors.fusion_parameters import FusionParameters
from hijack_detect.evaluation.monitor.graph import DETECTORS
from hijack_detect.nodes.messages import fusion_message, verdict_from
from hijack_detect.nodes.outlet import Outlet
from hijack_detect.nodes.qos import INTERNAL, STATE
from hijack_detect.nodes.running import run
from hijack_detect.nodes.stage_node import StageNode
from hijack_detect.nodes.wiring import Input, Topics, Wiring
from hijack_detect.streams.samples import NANOSECONDS

HEARTBEAT_S = 1.0
ALERT = "hijack alert"
"""What the diagnostics are about."""


class FusionNode(StageNode[FusionParameters]):
    """Runs `Fusion`. Parameters are read-only: a change would lose a latched alert."""

    def __init__(self, wiring: Wiring) -> None:
        """Subscribe and advertise; see StageNode."""
        inputs = {
            name: Input(f"{name}/verdict", DiagnosticArray, INTERNAL, verdict_from)
            for name in DETECTORS
        }
        super().__init__(
            "fusion",
            FusionParameters,
            lambda parameters: Fusion(parameters, DETECTORS),
            inputs,
            wiring,
            read_only=True,
        )
        self._alert = self.create_publisher(Bool, "hijack_alert", STATE)
        self._confidence = Outlet(self, Float64, "hijack_confidence", wiring.rate_hz)
        self._verdict = Outlet(self, DiagnosticArray, "fusion/verdict", wiring.rate_hz)
        self.create_service(Trigger, "~/reset", self._reset)
        self._result: FusionResult | None = None
        self._heard_ns = self.get_clock().now().nanoseconds
        self.create_timer(HEARTBEAT_S, self._heartbeat)
        self._heartbeat()

    def publish_output(self, output: FusionResult) -> None:
        """Publish a result; log when the state or the alert changes."""
        before, self._result = self._result, output
        self._heard_ns = self.get_clock().now().nanoseconds
        if before is None or before.alert != output.alert:
            self._alert.publish(Bool(data=output.alert))
        news = before is None or (before.state, before.alert) != (output.state, output.alert)
        stamp_ns, confidence = output.stamp_ns, output.confidence
        self._confidence.publish(stamp_ns, lambda: Float64(data=confidence), change=news)
        self._verdict.publish(stamp_ns, lambda: fusion_message(output), change=news)
        if news:
            seconds = output.stamp_ns / NANOSECONDS
            if output.alert:
                self.log.error(f"HIJACK ALERT at {seconds:.3f} s: {output.reason}")
            else:
                self.log.info(f"{output.state.value} at {seconds:.3f} s: {output.reason}")

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        fusion = self.stage.component
        assert isinstance(fusion, Fusion)
        fusion.reset()
        self._result = None
        self._alert.publish(Bool(data=False))
        self.log.warning("alert reset on request")
        response.success, response.message = True, "alert reset"
        return response

    def _heartbeat(self) -> None:
        """Repeat the alert and say in /diagnostics what the monitor can tell."""
        result = self._result
        self._alert.publish(Bool(data=result is not None and result.alert))
        silent_s = (self.get_clock().now().nanoseconds - self._heard_ns) / NANOSECONDS
        if result is None or silent_s > self.parameters.stale_s:
            text = f"no verdict of any detector for {silent_s:.0f} s"
            self.diagnostics.tell(ALERT, DiagnosticStatus.STALE, text, {})
        else:
            self.diagnostics.publish(ALERT, fusion_message(result).status[0])


def main() -> None:
    """Run the node."""
    run(lambda: FusionNode(Topics()), __doc__ or "")


if __name__ == "__main__":
    main()
