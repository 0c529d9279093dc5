# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Fuses the detectors' verdicts into hijack_alert.

Subscribes DETECTOR/verdict of every detector, also of those that the parameter further_detectors
names. Publishes hijack_alert (Bool, latched, reliable and transient local, repeated every second
with a deadline and a sign of life), hijack_confidence (Float64, 0 to 1, NaN while nothing is known
of the GPS), fusion/verdict (DiagnosticArray; STALE by the clock when nothing comes for 2 s) and
/diagnostics, which also reports a second publisher of the alert or of a verdict. Service ~/reset
(std_srvs/Trigger) takes the alert back.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from std_msgs.msg import Bool, Float64
from std_srvs.srv import Trigger

from hijack_detect.contract import REPEAT_S
from hijack_detect.detectors.fusion import SILENT_S, Fusion, FusionResult
from hijack_detect.detectors.likelihood import FusionParameters
from hijack_detect.detectors.verdict import State
from hijack_detect.monitor.parts import Part, row_of, weights
from hijack_detect.nodes.diagnostics import PublisherWatch
from hijack_detect.nodes.engine import run_part, verdict_topic
from hijack_detect.nodes.messages import fusion_message
from hijack_detect.nodes.part_node import PartNode
from hijack_detect.nodes.qos import ALERT
from hijack_detect.nodes.state_file import Survivor
from hijack_detect.streams.samples import NANOSECONDS

ALERT_TOPIC = "hijack_alert"
ALERT_SUBJECT = "hijack alert"
"""What the diagnostics are about."""
WATCH_S = 0.25
"""Whether the detectors have fallen silent is looked at this often. Chosen, not swept."""


class FusionNode(PartNode[FusionParameters]):
    """Runs `Fusion`. Parameters are read-only: a change would lose a latched alert."""

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz, read_only=True)
        self._detectors = weights(self.parameters)
        self._alert = self.create_publisher(Bool, ALERT_TOPIC, ALERT)
        watched = (ALERT_TOPIC, *map(verdict_topic, self._detectors))
        self._watch = PublisherWatch(self, self.diagnostics, watched)
        self._confidence = self.outlet(Float64, "hijack_confidence")
        self._verdict = self.outlet(DiagnosticArray, "fusion/verdict")
        self.create_service(Trigger, "~/reset", self._reset)
        self._result: FusionResult | None = None
        self._newest_result_s = time.monotonic()
        self._silence_reported_s: float | None = None
        """When silence was last reported; None while verdicts come."""
        self._old = range(0)
        """Stamps of results of before nothing came, see `_current`."""
        self._survivor = Survivor(self.get_fully_qualified_name(), self.parameters.survive_s)
        self._cannot_keep = ""
        self._go_on()
        # ROS time may be paused or set; a consumer of the sign of life does not wait for it.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(REPEAT_S, self._heartbeat, clock=steady)
        self.create_timer(WATCH_S, self._watch_silence, clock=steady)
        self._heartbeat()

    @property
    def _fusion(self) -> Fusion:
        fusion = self.stage.component
        assert isinstance(fusion, Fusion)
        return fusion

    def _go_on(self) -> None:
        """Take over the alert of this node's process before, if that has just died."""
        alert = self._survivor.read() if self.parameters.survive_s else None
        if alert is not None:
            self._fusion.keep(alert)
            self.log.error(
                f"HIJACK ALERT of {alert.since_ns / NANOSECONDS:.3f} s goes on after a restart: "
                f"{alert.cause}"
            )

    def publish_output(self, output: FusionResult) -> None:
        """Publish a result; log when the state, the alert or the missing detectors change."""
        output = self._current(output)
        before, self._result = self._result, output
        self._newest_result_s, self._silence_reported_s = time.monotonic(), None
        if before is None or before.alert != output.alert:
            self._alert.publish(Bool(data=output.alert))
            self._keep()
        news = before is None or _news(before) != _news(output)
        self._publish_result(output, news=news)
        if news:
            self._diagnose()
            seconds = output.stamp_ns / NANOSECONDS
            if output.alert:
                self.log.error(f"HIJACK ALERT at {seconds:.3f} s: {output.reason}")
            elif output.degraded:
                self.log.warning(f"{output.state.value} at {seconds:.3f} s: {output.reason}")
            else:
                self.log.info(f"{output.state.value} at {seconds:.3f} s: {output.reason}")

    def _publish_result(self, output: FusionResult, *, news: bool) -> None:
        """Publish a result on the intermediate topics."""
        stamp_ns, claim = output.stamp_ns, output.claim
        self._confidence.publish(stamp_ns, lambda: Float64(data=claim), change=news)
        self._verdict.publish(stamp_ns, lambda: fusion_message(output), change=news)

    def _current(self, output: FusionResult) -> FusionResult:
        """The result as it holds now.

        The first ones after a silence may be of messages that had waited through it, before a gap:
        that all was well then is no statement about now. Messages that were late and not lost bring
        the stamps on at once.
        """
        if output.stamp_ns not in self._old:
            return output
        return replace(output.silent(self._silent_s), silent_s=None)

    def _watch_silence(self) -> None:
        """Report that nothing comes, which no stamp can: once a second, and in the log once.

        No alert follows from it, and none ends: those are decided on stamps.
        """
        now_s = time.monotonic()
        if self._result is None or self._silent_s <= self._longest_silence_s:
            return
        if self._silence_reported_s is None:
            last_ns = self._result.stamp_ns
            self._old = range(last_ns, last_ns + round(SILENT_S * NANOSECONDS) + 1)
            self._result = self._result.silent(self._silent_s)
            self.log.warning(f"no detector has said anything for {self._silent_s:.1f} s")
            self._diagnose()
        elif now_s - self._silence_reported_s < REPEAT_S:
            return
        self._silence_reported_s = now_s
        self._publish_result(self._result.silent(self._silent_s), news=True)

    @property
    def _silent_s(self) -> float:
        """Seconds without a result, by a clock that nobody sets."""
        return time.monotonic() - self._newest_result_s

    @property
    def _longest_silence_s(self) -> float:
        return min(SILENT_S, self.parameters.stale_s)

    def _keep(self) -> None:
        """Keep the alert beyond the end of this process; warn once if that cannot be done."""
        alert = self._fusion.latched
        if alert is None or not self.parameters.survive_s:
            return
        try:
            self._survivor.write(alert)
        except OSError as error:
            why = f"{self._survivor.path}: {error.strerror}: the alert is lost if this node dies"
            if why != self._cannot_keep:
                self.log.warning(why)
            self._cannot_keep = why

    def ended(self) -> None:
        """See PartNode."""
        self._survivor.forget()

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._fusion.reset()
        self._survivor.forget()
        self._result = None
        self._alert.publish(Bool(data=False))
        self.log.warning("alert reset on request")
        response.success, response.message = True, "alert reset"
        return response

    def _heartbeat(self) -> None:
        """Repeat the alert, keep it, and report the monitor's state on /diagnostics."""
        self._alert.publish(Bool(data=self._fusion.latched is not None))
        self._keep()
        self._diagnose()

    def _diagnose(self) -> None:
        """Report on /diagnostics what the monitor can see."""
        silent_s = self._silent_s
        if self._result is None or silent_s > self._longest_silence_s:
            missing = self.silent(self._longest_silence_s)
            who = ", ".join(missing) if 0 < len(missing) < len(self._detectors) else "any detector"
            text = f"DEGRADED, nothing can be said for {silent_s:.0f} s: no verdict of {who}"
            values = {"state": State.STALE.value, "degraded": " ".join(missing)}
            self.diagnostics.report(ALERT_SUBJECT, DiagnosticStatus.STALE, text, values)
        else:
            self.diagnostics.publish(ALERT_SUBJECT, fusion_message(self._result).status[0])


def _news(result: FusionResult) -> tuple[Any, ...]:
    """What is published and logged when it changes."""
    return result.state, result.alert, result.degraded


def main() -> None:
    """Run the node."""
    run_part(row_of("fusion"), __doc__ or "")


if __name__ == "__main__":
    main()
