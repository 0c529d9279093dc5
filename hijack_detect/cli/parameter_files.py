# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameter files that are the manual: every key with meaning, unit, bounds and default."""

from __future__ import annotations

import dataclasses
import json
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from hijack_detect.mavlink.parameters import BridgeParameters
from hijack_detect.monitor.parts import Part
from hijack_detect.monitor.policies import MonitorParameters, from_nodes, policy_parameters
from hijack_detect.parameters import ParameterError, Parameters, basic_first
from hijack_detect.px4.topics import Px4BridgeParameters
from hijack_detect.recording.parameters import RecorderParameters
from hijack_detect.spoofing.live import SpooferParameters
from hijack_detect.yaml_text import plain_data

OTHER_NODES: Mapping[str, type[Parameters]] = {
    "recorder": RecorderParameters,
    "gps_spoofer": SpooferParameters,
    "mavlink_bridge": BridgeParameters,
    "px4_bridge": Px4BridgeParameters,
}
"""Parameters of the nodes beside the monitor, which decide nothing."""

HEADER = """\
# Parameters of hijack_detect, policy `{policy}`. Made by `hijack-detect params --policy {policy}`
# from the declarations in the code: copy it, change values, and give the copy to the nodes with
# --params-file, or to the launch file as params_file:=. A misspelt key or a value outside its
# bounds is refused at start.
"""

OTHER_HEADER = """\
# Parameters of `{node}`. Made by `hijack-detect params --node {node}` from the
# declarations in the code: copy it, change values, and give the copy to the node with
# --params-file. A misspelt key or a value outside its bounds is refused at start.
"""

WIDTH = 98


def load_parameters(path: Path, own: Sequence[Part] = ()) -> MonitorParameters:
    """Read a ROS parameter file, as `--params-file` of the nodes takes it.

    Args:
        path: The file.
        own: Rows of the user's own detectors, which have their sections too.

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
        return from_nodes(given, OTHER_NODES, own)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error}") from error


def parameter_file(policy: str, own: Sequence[Part] = ()) -> str:
    """The text of a policy's parameter file, with the user's own detectors in it.

    Raises:
        ParameterError: There is no such policy, or the name of a detector cannot be used.
    """
    chosen = policy_parameters(policy, own)
    return manual(chosen, HEADER.format(policy=policy) + _basic(chosen))


def manual(chosen: MonitorParameters, header: str, *, changed_only: bool = False) -> str:
    """The text of a parameter file.

    Args:
        chosen: The parameters.
        header: Comment lines above everything, each with its line break.
        changed_only: Leave out what has its default.
    """
    blocks = [header]
    for part in chosen.parts:
        values, plain = chosen[part.name], part.parameters()
        if not changed_only or values != plain:
            blocks.append(_block(part.node, values, plain, changed_only=changed_only))
    return "\n".join(blocks)


def _basic(chosen: MonitorParameters) -> str:
    """Which parameters an integrator sets for a vehicle, as comment lines."""
    lines = ["#", "# BASIC parameters, which a vehicle may need, first in their sections:"]
    for part in chosen.parts:
        fields = dataclasses.fields(part.parameters)
        if names := [field.name for field in fields if field.metadata["basic"]]:
            lines.append(_comment(f"{part.node}: {', '.join(names)}", 0))
    return "\n".join(lines) + "\n"


def node_file(node: str) -> str:
    """The text of the parameter file of a node beside the monitor, one of OTHER_NODES."""
    values = OTHER_NODES[node]()
    block = _block(node, values, values, changed_only=False)
    return f"{OTHER_HEADER.format(node=node)}\n{block}"


def _block(node: str, values: Parameters, plain: Parameters, *, changed_only: bool) -> str:
    """The parameters of one node."""
    summary = (type(values).__doc__ or "").strip().splitlines()[0]
    lines = [_comment(summary, 0), f"/**/{node}:", "  ros__parameters:"]
    for field in basic_first(type(values)):
        value, default = getattr(values, field.name), getattr(plain, field.name)
        if changed_only and value == default:
            continue
        lines.append(_comment(_meaning(field, default), 4))
        lines.append(f"    {field.name}: {_scalar(value)}")
    return "\n".join(lines) + "\n"


def _scalar(value: Any) -> str:
    """A value as YAML; its small numbers have a point before the exponent, those of JSON do not."""
    text = json.dumps(value)
    return yaml.safe_dump(value).split()[0] if "e" in text and isinstance(value, float) else text


def _meaning(field: dataclasses.Field[Any], default: Any) -> str:
    meta = field.metadata
    facts = []
    if meta["choices"]:
        facts.append("one of " + ", ".join(meta["choices"]))
    if meta["low"] is not None:
        facts.append(f"{meta['low']:g} to {meta['high']:g} {meta['unit']}".rstrip())
    facts.append(f"default {json.dumps(default)}")
    basic = "BASIC. " if meta["basic"] else ""
    return f"{basic}{meta['doc']} Source: {meta['source']}. [{'; '.join(facts)}]"


def _comment(text: str, indent: int) -> str:
    prefix = " " * indent + "# "
    return textwrap.fill(text, WIDTH, initial_indent=prefix, subsequent_indent=prefix)
