# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The registry: its rows fit the classes, and what is made by hand has all of them."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from ros import ROOT

from hijack_detect.detectors.likelihood import SOURCES_OF_ERROR
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.parts import DETECTORS, PARTS, Part, load
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.parameters import Parameters

SENSORS = ("imu", "fix", "velocity", "satellites", "mag", "pressure")


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.name)
def test_a_row_fits_its_class(part: Part) -> None:
    assert issubclass(part.parameters, Parameters)
    assert set(part.paper) <= set(part.parameters.__dataclass_fields__)
    assert load(part.face).__name__.endswith("Node")
    if part.weight is not None:
        assert part.name == part.kind.NAME
        assert part.asks
        assert part.weight.shares in ("", *SOURCES_OF_ERROR)


def test_names_are_different_and_a_part_comes_after_its_inputs() -> None:
    assert len({part.name for part in PARTS} | {part.node for part in PARTS} - {"fusion"}) == (
        2 * len(PARTS) - 1
    )
    known = {*SENSORS}
    for name, stage in Monitor(MonitorParameters()).stages.items():
        assert {*stage.component.inputs} <= known, name
        known.add(name)


def test_reading_the_registry_loads_no_detector() -> None:
    """Completion, launch files and setup.py read it."""
    code = (
        "import sys, hijack_detect.nodes, hijack_detect.cli.completion\n"
        "print([name for name in ('numpy', 'rclpy', 'hijack_detect.detectors.coast')"
        " if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_the_readme_says_what_each_detector_asks() -> None:
    table = (ROOT / "README.md").read_text(encoding="utf-8")
    rows = [one.lower() for one in re.findall(r"^\| \*\*(\w+)\*\*", table, re.MULTILINE)]
    assert rows == list(DETECTORS)
