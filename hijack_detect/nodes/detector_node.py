"""What every detector node publishes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Bool, Float64

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.evaluation.monitor.stage import Component
from hijack_detect.nodes.messages import verdict_message
from hijack_detect.nodes.qos import INTERNAL
from hijack_detect.nodes.stage_node import Input, P, StageNode


class DetectorNode(StageNode[P]):
    """Publishes each verdict as NAME/verdict, NAME/hijacked and one Float64 per figure."""

    def __init__(
        self,
        name: str,
        parameters: type[P],
        make: Callable[[P], Component],
        inputs: Mapping[str, Input],
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
            figures: Values of the verdict, its `score` or its `threshold`, that are published
                as NAME/FIGURE.
            node_name: Name of the node, default NAME_detector.
        """
        super().__init__(node_name or f"{name}_detector", parameters, make, inputs)
        self._verdict = self.create_publisher(DiagnosticArray, f"{name}/verdict", INTERNAL)
        self._hijacked = self.create_publisher(Bool, f"{name}/hijacked", INTERNAL)
        self._figures: dict[str, Any] = {
            figure: self.create_publisher(Float64, f"{name}/{figure}", INTERNAL)
            for figure in figures
        }
        self._state: State | None = None

    def publish_output(self, output: Verdict) -> None:
        """Publish a verdict; a figure that is not defined is NaN, a gap in every plot."""
        self._verdict.publish(verdict_message(output))
        self._hijacked.publish(Bool(data=output.state is State.ALARM))
        values = {**output.values, "score": output.score, "threshold": output.threshold}
        for figure, publisher in self._figures.items():
            publisher.publish(Float64(data=values.get(figure, math.nan)))
        if output.state is not self._state:
            self._state = output.state
            self.log.info(f"{output.state.value} margin {output.margin:.2f}: {output.reason}")
