# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node of a detector, made from its row of the registry."""

from __future__ import annotations

import math
import sys
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.impl.rcutils_logger import RcutilsLogger
from std_msgs.msg import Bool, Float64, UInt8
from std_srvs.srv import Trigger

from hijack_detect.bags.topics import OPTIONAL_INPUTS
from hijack_detect.detectors.gnss_checks.latency import later_words
from hijack_detect.detectors.gnss_sanity import CLOCK_RATE, LATER
from hijack_detect.detectors.kld import CODES, KldDetector
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.clock_rate import clock_words
from hijack_detect.estimation.lag_ekf import LATE, LATE_FIGURES, late_words
from hijack_detect.estimation.receiver_health import POOR, POOR_FIGURES, poor_words
from hijack_detect.monitor.graph import input_names
from hijack_detect.monitor.parts import Part, load, own_part, row_of
from hijack_detect.nodes.diagnostics import Diagnostics, PublisherWatch
from hijack_detect.nodes.engine import IMU_TOPIC, INPUTS, run_part, verdict_topic
from hijack_detect.nodes.messages import verdict_message
from hijack_detect.nodes.part_node import PartNode
from hijack_detect.parameters import Parameters
from hijack_detect.streams.receiver_clock import REFERENCE, STAMPED
from hijack_detect.streams.samples import NANOSECONDS


@dataclass(frozen=True)
class Subject:
    """Something that can be wrong with a receiver.

    Attributes:
        name: Its name on /diagnostics, after the node's.
        figures: Values that a verdict has only while something is wrong.
        words: Puts them into words; empty without any.
        good: The text without any.
        over: What is logged once there are none any more.
        title: What stands before the words, if they need it.
        digits: Decimals of the values on /diagnostics.
    """

    name: str
    figures: frozenset[str]
    words: Callable[[Mapping[str, float]], str]
    good: str
    over: str
    title: str = ""
    digits: int = 1


class ReceiverReport:
    """A status once a second of the verdicts' stamps, and at once where something begins or ends.

    A WARN while something is wrong; its begin and end go to the log, too.
    """

    def __init__(self, diagnostics: Diagnostics, log: RcutilsLogger, subject: Subject) -> None:
        """Report as the node whose diagnostics and logger these are."""
        self._diagnostics, self._log, self._subject = diagnostics, log, subject
        self._wrong, self._second = False, 0

    def add(self, verdict: Verdict) -> None:
        """Take the next verdict."""
        subject, values = self._subject, verdict.values
        words = subject.words(values)
        wrong = f"{subject.title}: {words}" if words and subject.title else words
        news, self._wrong = bool(wrong) is not self._wrong, bool(wrong)
        second = verdict.stamp_ns // NANOSECONDS
        if news or second != self._second:
            self._second = second
            level = DiagnosticStatus.WARN if wrong else DiagnosticStatus.OK
            figures = {
                name: f"{values[name]:.{subject.digits}f}"
                for name in sorted(subject.figures & values.keys())
            }
            self._diagnostics.report(subject.name, level, wrong or subject.good, figures)
        if news:
            self._log.info(wrong or subject.over)


MARGIN = "margin"
"""The figure that every detector has: score over threshold, so that all fit on one plot."""


class DetectorNode(PartNode[Parameters]):
    """Publishes each verdict: NAME/verdict, NAME/hijacked, and Float64 for margin and figures."""

    BESIDE = ""
    """What it publishes and offers beside that, in sentences."""

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz)
        name = part.name
        self._verdict = self.outlet(DiagnosticArray, verdict_topic(name))
        self._hijacked = self.outlet(Bool, f"{name}/hijacked")
        self._figures = {
            figure: self.outlet(Float64, f"{name}/{figure}") for figure in (MARGIN, *part.figures)
        }
        self._state: State | None = None

    def publish_output(self, output: Verdict) -> None:
        """Publish a verdict; a figure that is not defined is NaN, a gap in every plot."""
        news, self._state = output.state is not self._state, output.state
        alarm, stamp_ns = output.state is State.ALARM, output.stamp_ns
        self._verdict.publish(stamp_ns, lambda: verdict_message(output), change=news)
        self._hijacked.publish(stamp_ns, lambda: Bool(data=alarm), change=news)
        for figure, outlet in self._figures.items():
            outlet.publish(stamp_ns, partial(_figure, output, figure), change=news)
        if news:
            self.log.info(f"{output.state.value} margin {output.margin:.2f}: {output.reason}")


LATENCY = Subject(
    "latency of the GPS",
    LATE_FIGURES,
    late_words,
    good="no later than receivers are",
    over="the GPS is no later than receivers are again",
    title=LATE,
    digits=2,
)


class CoastDetectorNode(DetectorNode):
    """The node of `CoastDetector`, which also reports a late GPS."""

    BESIDE = "/diagnostics warn once a second of a GPS that lags by more than receivers do."

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz)
        self._latency = ReceiverReport(self.diagnostics, self.log, LATENCY)

    def publish_output(self, output: Verdict) -> None:
        """Publish a verdict, and whether the GPS is late; see DetectorNode."""
        super().publish_output(output)
        self._latency.add(output)


FIX = "gps/fix"
RECEIVER = Subject(
    "receiver",
    POOR_FIGURES,
    poor_words,
    good="nothing to object by its own word",
    over="the receiver is good again by its own word",
    title=POOR,
)
CLOCK = Subject(
    "clock of the stamps",
    frozenset({CLOCK_RATE}),
    lambda values: clock_words(values[CLOCK_RATE]) if CLOCK_RATE in values else "",
    good="no other rate than the GPS's seen",
    over="the clock of the stamps runs as the GPS's again",
    digits=4,
)
GROWTH = Subject(
    "growth of the latency",
    frozenset({LATER}),
    lambda values: later_words(values[LATER]) if LATER in values else "",
    good="none that position and velocity show",
    over="position and velocity agree without a growth of the latency again",
)


class GnssSanityNode(DetectorNode):
    """The node of `GnssSanityDetector`, which also reports the receiver's own flags."""

    BESIDE = (
        "/diagnostics warn once a second of a receiver that is poor by its own word (lost fixes, "
        "satellites, claimed accuracy), of a clock behind the stamps that runs at another rate "
        "than the GPS's, of a latency that grew, and of more than one publisher on gps/fix; the "
        "verdict depends on stamped messages alone and looks for what two streams do."
    )

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz)
        self._watch = PublisherWatch(self, self.diagnostics, (FIX,))
        self._reports = [
            ReceiverReport(self.diagnostics, self.log, subject)
            for subject in (RECEIVER, CLOCK, GROWTH)
        ]

    def publish_output(self, output: Verdict) -> None:
        """Publish a verdict, and the receiver's own flags; see DetectorNode."""
        super().publish_output(output)
        for report in self._reports:
            report.add(output)


class KldDetectorNode(DetectorNode):
    """The node of `KldDetector`, which also publishes the code of Basan 2022."""

    BESIDE = (
        "Also kld/code (UInt8: 111 attack, 110 no attack, nothing while it cannot tell). Service "
        "~/reset (std_srvs/Trigger) takes a kept alarm back."
    )

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz)
        self._code = self.outlet(UInt8, "kld/code")
        self._published: int | None = None
        self.create_service(Trigger, "~/reset", self._reset)

    def publish_output(self, output: Verdict) -> None:
        """Publish a verdict and its code."""
        super().publish_output(output)
        code = CODES.get(output.state)
        if code is not None:
            change, self._published = code != self._published, code
            self._code.publish(output.stamp_ns, lambda: UInt8(data=code), change=change)

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        detector = self.stage.component
        assert isinstance(detector, KldDetector)
        detector.reset()
        self.log.warning("alarm reset on request")
        response.success, response.message = True, "alarm reset"
        return response


def _figure(output: Verdict, name: str) -> Float64:
    own = {"score": output.score, "threshold": output.threshold, MARGIN: output.margin}
    values = {**output.values, **own}
    return Float64(data=values.get(name, math.nan))


def summary(part: Part) -> str:
    """What the node of a detector asks, its topics and their units."""
    inputs = input_names(part)
    topics = [INPUTS[name].topic for name in inputs if name in INPUTS]
    if {*STAMPED} & {*inputs} and REFERENCE not in inputs:
        topics.append(f"{IMU_TOPIC} for its stamps")
    absent = [INPUTS[name].topic for name in inputs if name in OPTIONAL_INPUTS]
    may = f" ({_listed(absent)} may be absent)" if absent else ""
    published = {MARGIN: "score over threshold", **part.figures}
    figures = [f"{part.name}/{name} ({meaning})" for name, meaning in published.items()]
    text = (
        f"Subscribes {_listed(topics)}{may}. Publishes {part.name}/verdict (DiagnosticArray), "
        f"{part.name}/hijacked (Bool), and as Float64 {_listed(figures)}. {load(part.face).BESIDE}"
    )
    wrapped = textwrap.fill(text, 100, break_long_words=False, break_on_hyphens=False)
    return f"{part.question}\n\n{wrapped}"


def _listed(words: list[str]) -> str:
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def run_detector(which: str | type[Any], text: str = "") -> None:
    """Run the node of a detector until it is interrupted.

    Args:
        which: Its node, for one of the registry; its class, for one of the user's own.
        text: What `--help` prints, default `summary`.
    """
    part = row_of(which) if isinstance(which, str) else own_part(which)
    run_part(part, text or summary(part))


def main() -> None:
    """Run the node that is called as this program is."""
    run_detector(Path(sys.argv[0]).name)
