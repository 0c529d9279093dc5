# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameter sets by name, and parameter files."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hijack_detect.mavlink.parameters import BridgeParameters
from hijack_detect.monitor.graph import MonitorParameters
from hijack_detect.parameters import ParameterError, Parameters
from hijack_detect.px4.parameters import Px4BridgeParameters
from hijack_detect.recording.parameters import RecorderParameters
from hijack_detect.spoofing.live_parameters import SpooferParameters
from hijack_detect.yaml_text import plain_data

NODE_FIELDS = {
    "attitude_estimator": "attitude",
    "gps_angle": "course",
    "flight_phase": "phase",
    "correlation_detector": "correlation",
    "date_detector": "date",
    "kld_detector": "kld",
    "coast_detector": "coast",
    "gnss_sanity": "gnss",
    "altitude_detector": "altitude",
    "heading_detector": "heading",
    "drag_detector": "drag",
    "fusion": "fusion",
}
"""Node name to field of `MonitorParameters`."""

BESIDE: Mapping[str, type[Parameters]] = {
    "recorder": RecorderParameters,
    "gps_spoofer": SpooferParameters,
    "mavlink_bridge": BridgeParameters,
    "px4_bridge": Px4BridgeParameters,
}
"""Parameters of the nodes beside the monitor. They say nothing of what the monitor decides."""

POLICIES: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    "default": {},
    "paper": {
        "attitude_estimator": {"use_mag": False},
        "correlation_detector": {
            "mu_deg": 10.0,
            "min_sigma_deg": 0.0,
            "persist_s": 0.0,
            "course_lag_s": 0.0,
            "follow_s": 0.0,
            "max_heading_sigma_deg": 180.0,
            "in_flight": False,
        },
        "date_detector": {
            "gps_lag_s": 0.0,
            "max_lag_s": 0.0,
            "persist_s": 0.0,
            "max_tilt_deg": 180.0,
            "noise_gain": 0.0,
            "max_force": 1000.0,
            "in_flight": False,
        },
        "kld_detector": {
            "mode": "faithful",
            "quorum": 2,
            "together": 1,
            "altitude_threshold": 2.5e-4,
            "satellites_threshold": 0.03,
            "speed_threshold": 50.0,
            "track_threshold": 750.0,
            "latitude_threshold": 6e-12,
            "longitude_threshold": 3e-12,
        },
        "fusion": {"policy": "paper"},
    },
}
"""What each policy sets differently from the defaults, by node."""


def policy_parameters(name: str) -> MonitorParameters:
    """Parameters of a policy.

    Raises:
        ParameterError: There is no such policy.
    """
    if name not in POLICIES:
        raise ParameterError(f"no policy '{name}' (there are: {', '.join(POLICIES)})")
    return from_nodes(POLICIES[name])


def from_nodes(values: Mapping[str, Mapping[str, Any]]) -> MonitorParameters:
    """Parameters from values by node name, defaults for the rest.

    Those of the nodes beside the monitor are only checked.

    Raises:
        ParameterError: A node or parameter is unknown, or a value is refused.
    """
    made: dict[str, Parameters] = {}
    for node, given in values.items():
        kind = BESIDE.get(node) or _kind(node)
        try:
            checked = kind.from_mapping(given)
        except ParameterError as error:
            raise ParameterError(f"{node}: {error}") from error
        if node in NODE_FIELDS:
            made[NODE_FIELDS[node]] = checked
    return MonitorParameters(**made)  # type: ignore[arg-type]


def _kind(node: str) -> type[Parameters]:
    """Parameter set of a node of the monitor."""
    if node not in NODE_FIELDS:
        raise ParameterError(f"no node '{node}' (there are: {', '.join((*NODE_FIELDS, *BESIDE))})")
    fields = {field.name: field for field in dataclasses.fields(MonitorParameters)}
    kind = fields[NODE_FIELDS[node]].default_factory
    assert isinstance(kind, type) and issubclass(kind, Parameters)
    return kind


def load_parameters(path: Path) -> MonitorParameters:
    """Read a ROS parameter file, as `--params-file` of the nodes takes it.

    Raises:
        ParameterError: The file cannot be read or sets something that is refused.
    """
    try:
        document = plain_data(path.read_text(encoding="utf-8"))
        given = {
            node.strip("/").removeprefix("**/"): dict(body["ros__parameters"])
            for node, body in (document or {}).items()
        }
    except OSError as error:
        raise ParameterError(f"{path}: {error.strerror or error}") from error
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise ParameterError(f"{path}: not a ROS parameter file: {error}") from error
    try:
        return from_nodes(given)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error}") from error
