# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What every detector node publishes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial

from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Bool, Float64

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.stage import Component
from hijack_detect.nodes.messages import verdict_message
from hijack_detect.nodes.outlet import Outlet
from hijack_detect.nodes.stage_node import P, StageNode
from hijack_detect.nodes.wiring import Input, Wiring

MARGIN = "margin"
"""The figure that every detector has: score over threshold, so that all fit on one plot."""


class DetectorNode(StageNode[P]):
    """Publishes each verdict: NAME/verdict, NAME/hijacked, and Float64 for margin and figures."""

    def __init__(
        self,
        name: str,
        parameters: type[P],
        make: Callable[[P], Component],
        inputs: Mapping[str, Input],
        wiring: Wiring,
        figures: tuple[str, ...],
        *,
        node_name: str = "",
    ) -> None:
        """Subscribe and advertise.

        Args:
            name: Name of the detector.
            parameters: Parameter dataclass.
            make: Makes the detector from its parameters.
            inputs: Subscription of each input.
            wiring: See StageNode.
            figures: Values of the verdict, its `score` or its `threshold`, that are published
                as NAME/FIGURE beside NAME/margin.
            node_name: Name of the node, default NAME_detector.
        """
        verdict = f"{name}/verdict"
        super().__init__(
            node_name or f"{name}_detector", parameters, make, inputs, wiring, output=verdict
        )
        self._verdict = Outlet(self, DiagnosticArray, verdict, wiring.rate_hz)
        self._hijacked = Outlet(self, Bool, f"{name}/hijacked", wiring.rate_hz)
        self._figures = {
            figure: Outlet(self, Float64, f"{name}/{figure}", wiring.rate_hz)
            for figure in (MARGIN, *figures)
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
