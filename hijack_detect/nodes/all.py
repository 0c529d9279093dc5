# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The whole monitor in one process: a fraction of the processor time that its nodes take alone.

Subscribes once to each of imu/data_raw, gps/fix, gps/vel (ENU), gps/satellites, mag and pressure.
Publishes hijack_alert, /diagnostics, and while somebody listens what else the nodes publish that
are in it: at most publish_rate times a second, and at every change of state. They keep their
names, parameters and services, so the same parameter files hold, and hand each other samples. A
further node, monitor, has the parameter publish_rate and receives the messages of the GPS.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rclpy.executors import Executor
from rclpy.node import Node

from hijack_detect.monitor.parts import PARTS, load
from hijack_detect.nodes.engine import Engine
from hijack_detect.nodes.parameters import declare, naming
from hijack_detect.nodes.running import run_composed
from hijack_detect.parameters import Parameters, param


@dataclass(frozen=True)
class CompositionParameters(Parameters):
    """What composed nodes publish beside hijack_alert."""

    publish_rate: float = param(
        50.0,
        "Intermediate topics (imu/data, verdicts, figures, hijack_confidence) are published at "
        "most so often, by stamp, and at every change of state; 0 publishes every output.",
        source="chosen: what a plot shows; each output of the IMU's rate costs a message",
        unit="Hz",
        low=0.0,
        high=10_000.0,
    )


def make(executor: Executor) -> Sequence[Node]:
    """Make all nodes, run by an executor.

    Raises:
        ParameterError: A parameter of one of them is unknown or out of bounds.
    """
    monitor = Node("monitor", automatically_declare_parameters_from_overrides=True)
    with naming("monitor"):
        parameters = declare(monitor, CompositionParameters, read_only=True)
    nodes = [load(part.face)(part, parameters.publish_rate or None) for part in PARTS]
    Engine(nodes).connect(executor, monitor)
    return nodes


def main() -> None:
    """Run all nodes."""
    run_composed(make, __doc__ or "")


if __name__ == "__main__":
    main()
