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

from rclpy.executors import Executor
from rclpy.node import Node

from hijack_detect.monitor.parts import PARTS, load
from hijack_detect.nodes.composition import Composition
from hijack_detect.nodes.composition_parameters import CompositionParameters
from hijack_detect.nodes.parameters import declare, naming
from hijack_detect.nodes.running import run_composed


def make(executor: Executor) -> Sequence[Node]:
    """Make all nodes, run by an executor.

    Raises:
        ParameterError: A parameter of one of them is unknown or out of bounds.
    """
    monitor = Node("monitor", automatically_declare_parameters_from_overrides=True)
    with naming("monitor"):
        parameters = declare(monitor, CompositionParameters, read_only=True)
    composition = Composition(executor, parameters.publish_rate or None)
    nodes = [load(part.face)(part, composition) for part in PARTS]
    composition.connect(monitor)
    return nodes


def main() -> None:
    """Run all nodes."""
    run_composed(make, __doc__ or "")


if __name__ == "__main__":
    main()
