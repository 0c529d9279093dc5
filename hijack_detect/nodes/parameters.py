# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""ROS parameters from parameter dataclasses."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterable, Iterator
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from hijack_detect.parameters import ParameterError, Parameters

P = TypeVar("P", bound=Parameters)

ROS_PREFIXES = ("qos_overrides.", "use_sim_time", "start_type_description_service")
"""Parameters that rclpy itself knows."""


def declare(node: Node, kind: type[P], *, read_only: bool) -> P:
    """Declare every field of a parameter dataclass on a node and return the values given.

    The node must have been made with `automatically_declare_parameters_from_overrides`, so that
    a misspelt name in a parameter file is seen.

    Raises:
        ParameterError: A name is unknown, or a value has the wrong type or is out of bounds;
            the text names the parameter and what is allowed.
    """
    given = {
        name: node.get_parameter(name).value
        for name in node.get_parameters_by_prefix("")
        if not name.startswith(ROS_PREFIXES)
    }
    parameters = kind.from_mapping(given)
    for name in given:
        node.undeclare_parameter(name)
    for field in dataclasses.fields(kind):
        node.declare_parameter(
            field.name,
            getattr(parameters, field.name),
            descriptor(field, read_only=read_only),
            ignore_override=True,
        )
    return parameters


@contextlib.contextmanager
def naming(node: str) -> Iterator[None]:
    """Let a ParameterError name the node that it is about."""
    try:
        yield
    except ParameterError as error:
        raise ParameterError(f"{node}: {error}") from error


def current(node: Node, kind: type[P], changes: dict[str, Any]) -> P:
    """The node's parameters with some changed.

    Raises:
        ParameterError: As for `declare`.
    """
    values = {f.name: node.get_parameter(f.name).value for f in dataclasses.fields(kind)}
    unknown = set(changes) - set(values)
    if unknown:
        raise ParameterError(f"unknown parameter '{min(unknown)}'")
    return kind.from_mapping({**values, **changes})


def own_changes(kind: type[Parameters], changes: Iterable[Parameter]) -> dict[str, Any]:
    """The new values of those changed parameters that are fields of a parameter dataclass."""
    names = {field.name for field in dataclasses.fields(kind)}
    return {change.name: change.value for change in changes if change.name in names}


def descriptor(field: dataclasses.Field[Any], *, read_only: bool) -> ParameterDescriptor:
    """Description, unit and bounds of a field, as `ros2 param describe` shows them."""
    meta = field.metadata
    unit = f" [{meta['unit']}]" if meta["unit"] else ""
    source = f" Source: {meta['source']}."
    result = ParameterDescriptor(
        description=meta["doc"] + source + unit, read_only=read_only or meta["fixed"]
    )
    result.additional_constraints = (
        "one of: " + ", ".join(meta["choices"]) if meta["choices"] else ""
    )
    if meta["low"] is not None and meta["high"] is not None:
        if isinstance(field.default, float):
            result.floating_point_range = [
                FloatingPointRange(from_value=float(meta["low"]), to_value=float(meta["high"]))
            ]
        else:
            result.integer_range = [
                IntegerRange(from_value=int(meta["low"]), to_value=int(meta["high"]))
            ]
    return result
