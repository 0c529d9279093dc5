# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""hijack_detect: tells a drone's mission manager that its GPS is being spoofed.

The names below are what researchers need (docs/python.md). None of them is imported before it is
used, and none needs ROS.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hijack_detect.analysis.flight_log import FlightLog
    from hijack_detect.detectors.verdict import State, Verdict
    from hijack_detect.evaluation.scores.evaluate import evaluate_folder
    from hijack_detect.monitor.graph import Monitor
    from hijack_detect.monitor.policies import policy_parameters
    from hijack_detect.parameters import Parameters, param
    from hijack_detect.spoofing.scenario import load_scenario, parse_scenario

__version__ = "0.1.0"
__all__ = [
    "FlightLog",
    "Monitor",
    "Parameters",
    "State",
    "Verdict",
    "evaluate_folder",
    "load_scenario",
    "param",
    "parse_scenario",
    "policy_parameters",
]

_MODULES = {
    "FlightLog": "analysis.flight_log",
    "Monitor": "monitor.graph",
    "Parameters": "parameters",
    "State": "detectors.verdict",
    "Verdict": "detectors.verdict",
    "evaluate_folder": "evaluation.scores.evaluate",
    "load_scenario": "spoofing.scenario",
    "param": "parameters",
    "parse_scenario": "spoofing.scenario",
    "policy_parameters": "monitor.policies",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is used."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    """Public names, those that are not imported yet included."""
    return sorted({*globals(), *__all__})
