# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The launch files, where `launch` is installed: it is not among the wheels."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

LAUNCH = Path(__file__).parents[1] / "launch"

pytest.importorskip("launch_ros", reason="launch and launch_ros are not installed (not on PyPI)")


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, LAUNCH / f"{name}.launch.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("name", "arguments", "nodes"),
    [
        ("hijack_detect", {"mavros": "true", "uav": "uav1", "policy": "paper"}, 1),
        ("hijack_detect", {"record": "true"}, 2),
        ("hijack_detect", {"mavlink": "udpin:127.0.0.1:14540"}, 2),
        ("hijack_detect", {"px4": "true", "uav": "uav1"}, 2),
        ("hijack_detect", {"composed": "false", "record": "true"}, 12),
        ("replay", {"bag": "bags/curved_8", "rate": "4"}, 12),
    ],
)
def test_every_node_is_started(name: str, arguments: dict[str, str], nodes: int) -> None:
    from launch import LaunchContext  # noqa: PLC0415  only where it is installed
    from launch_ros.actions import Node  # noqa: PLC0415

    module = load(name)
    description = module.generate_launch_description()
    declared = {action.name for action in description.entities[:-1]}
    assert set(arguments) <= declared
    context = LaunchContext()
    for given, default, _ in module.ARGUMENTS:
        context.launch_configurations[given] = arguments.get(given, default or "")
    started = module.nodes(context)
    assert sum(isinstance(one, Node) for one in started) == nodes
