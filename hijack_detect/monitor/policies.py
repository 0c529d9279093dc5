# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameter sets by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from hijack_detect.monitor.graph import MonitorParameters
from hijack_detect.parameters import ParameterError, Parameters

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


def from_nodes(
    values: Mapping[str, Mapping[str, Any]],
    beside: Mapping[str, type[Parameters]] | None = None,
) -> MonitorParameters:
    """Parameters from values by node name, defaults for the rest.

    Args:
        values: Values by parameter name, by node name.
        beside: Parameter sets of the nodes beside the monitor; what is given for those is only
            checked.

    Raises:
        ParameterError: A node or parameter is unknown, or a value is refused.
    """
    kinds = {**_kinds(), **(beside or {})}
    made: dict[str, Parameters] = {}
    for node, given in values.items():
        if node not in kinds:
            raise ParameterError(f"no node '{node}' (there are: {', '.join(kinds)})")
        try:
            checked = kinds[node].from_mapping(given)
        except ParameterError as error:
            raise ParameterError(f"{node}: {error}") from error
        if node in NODE_FIELDS:
            made[NODE_FIELDS[node]] = checked
    return MonitorParameters(**made)  # type: ignore[arg-type]


def _kinds() -> dict[str, type[Parameters]]:
    """Parameter set of each node of the monitor, by node name."""
    fields = {field.name: field for field in dataclasses.fields(MonitorParameters)}
    kinds: dict[str, type[Parameters]] = {}
    for node, name in NODE_FIELDS.items():
        kind = fields[name].default_factory
        assert isinstance(kind, type) and issubclass(kind, Parameters)
        kinds[node] = kind
    return kinds
