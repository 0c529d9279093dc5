# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node of a detector, made from its row of the registry."""

from __future__ import annotations

import math
import sys
import textwrap
from functools import partial
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Bool, Float64

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.graph import input_names
from hijack_detect.monitor.parts import Part, own_part, row_of
from hijack_detect.nodes.engine import run_part
from hijack_detect.nodes.inputs import IMU_TOPIC, INPUTS, verdict_topic
from hijack_detect.nodes.messages import verdict_message
from hijack_detect.nodes.outlet import Outlet
from hijack_detect.nodes.part_node import PartNode
from hijack_detect.parameters import Parameters
from hijack_detect.streams.receiver_clock import REFERENCE, STAMPED

MARGIN = "margin"
"""The figure that every detector has: score over threshold, so that all fit on one plot."""


class DetectorNode(PartNode[Parameters]):
    """Publishes each verdict: NAME/verdict, NAME/hijacked, and Float64 for margin and figures."""

    def __init__(self, part: Part, rate_hz: float | None = None) -> None:
        """Advertise; see PartNode."""
        super().__init__(part, rate_hz)
        name = part.name
        self._verdict = Outlet(self, DiagnosticArray, verdict_topic(name), rate_hz)
        self._hijacked = Outlet(self, Bool, f"{name}/hijacked", rate_hz)
        self._figures = {
            figure: Outlet(self, Float64, f"{name}/{figure}", rate_hz)
            for figure in (MARGIN, *part.figures)
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
    figures = {MARGIN: "score over threshold", **part.figures}
    told = [f"{part.name}/{name} ({meaning})" for name, meaning in figures.items()]
    text = (
        f"Subscribes {_listed(topics)}. Publishes {part.name}/verdict (DiagnosticArray), "
        f"{part.name}/hijacked (Bool), and as Float64 {_listed(told)}."
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
