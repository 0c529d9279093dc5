# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Writes the reference of all nodes: topics and services of a running graph, and parameters.

    python -m tools.interface docs/interface.md

px4_bridge needs px4_msgs: source a workspace that has it.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import click
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from hijack_detect.cli.parameter_files import OTHER_NODES
from hijack_detect.monitor.parts import PARTS
from hijack_detect.nodes import COMPOSED, NODES, entry_point
from hijack_detect.nodes.all import CompositionParameters
from hijack_detect.nodes.detector_node import summary
from hijack_detect.parameters import Parameters, basic_first
from hijack_detect.replay.playback import ReplayParameters
from tools.documents import write
from tools.policies import graph, relative, run

OF_EVERY_NODE = ("/rosout", "/parameter_events")
HEAD = """\
# Interface

Every node with its topics, services and parameters. Made by
`python -m tools.interface docs/interface.md` from a running graph and from the declarations in
the code; a test compares it with a running graph.

* Names are relative: in the namespace `/uav1` the topic `hijack_alert` is `/uav1/hijack_alert`, and
  `~/reset` of `fusion` is `/uav1/fusion/reset`. `/diagnostics`, `/rosout` and `/parameter_events`
  stay where they are.
* Body vectors are FLU, world vectors ENU, units SI, angles radians. Stamps in headers are those of
  the measurement.
* QoS of an input can be changed with the standard `qos_overrides` parameters. Every node has the
  parameters and parameter services of ROS too.
* `all` has the topics and parameters of the nodes of the monitor; to each other they hand over
  samples instead of messages.
* A parameter file reaches a node in any namespace by `/**/fusion:`. [config](../config) has files
  with the same text as here.
"""
Rows = list[tuple[str, str, str, str]]
"""What it does, name, type, quality of service."""


def look(observer: Node, node: str) -> Rows:
    """Topics and services of a node of the graph in the root namespace, in order of name."""
    place = (node, "/")
    rows: Rows = []
    for does, found, info in (
        (
            "subscribes",
            observer.get_subscriber_names_and_types_by_node(*place),
            observer.get_subscriptions_info_by_topic,
        ),
        (
            "publishes",
            observer.get_publisher_names_and_types_by_node(*place),
            observer.get_publishers_info_by_topic,
        ),
    ):
        for topic, kinds in sorted(found):
            if topic not in OF_EVERY_NODE:
                own = [end.qos_profile for end in info(topic) if end.node_name == node]
                qos = quality(own[0]) if own else ""
                rows.append((does, relative(node, topic), short(kinds), qos))
    for does, services in (
        ("offers", observer.get_service_names_and_types_by_node(*place)),
        ("calls", observer.get_client_names_and_types_by_node(*place)),
    ):
        for service, kinds in sorted(services):
            if not kinds[0].startswith(("rcl_interfaces", "type_description_interfaces")):
                rows.append((does, relative(node, service), short(kinds), "service"))
    return rows


def quality(profile: QoSProfile) -> str:
    """Reliability, durability and deadline, as they matter to the other side."""
    words = ["reliable" if profile.reliability is ReliabilityPolicy.RELIABLE else "best effort"]
    if profile.durability is DurabilityPolicy.TRANSIENT_LOCAL:
        words.append("transient local")
    if 0 < profile.deadline.nanoseconds < 10**12:
        words.append(f"deadline {profile.deadline.nanoseconds / 1e9:g} s")
    return ", ".join(words)


def short(kinds: Sequence[str]) -> str:
    """A type as its package and name."""
    return kinds[0].replace("/msg/", "/").replace("/srv/", "/")


def parameters_of(node: str) -> type[Parameters] | None:
    """The parameter set of a node, None if it has none."""
    known = {"bag_replay": ReplayParameters, COMPOSED: CompositionParameters, **OTHER_NODES}
    return {**known, **{part.node: part.parameters for part in PARTS}}.get(node)


def parameter_rows(kind: type[Parameters]) -> Iterator[str]:
    """The table of a parameter set."""
    yield "| parameter | default | | meaning | source of the default |"
    yield "|---|---|---|---|---|"
    for field in basic_first(kind):
        meta = field.metadata
        low, high = meta["low"], meta["high"]
        ends = (("from", low), ("to", high)) if None in (low, high) else (("", low), ("to", high))
        bounds = " ".join(f"{word} {end:g}".strip() for word, end in ends if end is not None)
        allowed = ", ".join(f"`{one}`" for one in meta["choices"]) or f"{bounds} {meta['unit']}"
        default = f"`{field.default}`" if field.default != "" else "empty"
        name = f"**`{field.name}`**" if meta["basic"] else f"`{field.name}`"
        meaning, source = cell(meta["doc"]), cell(meta["source"])
        yield f"| {name} | {default} | {allowed.strip()} | {meaning} | {source} |"


def cell(text: str) -> str:
    """A text that can stand in a table."""
    return text.replace("|", "\\|")


def section(node: str, rows: Rows) -> str:
    """The part of the reference about one node."""
    lines = [f"## {node}", "", described(node), ""]
    if rows:
        lines += ["| | name | type | |", "|---|---|---|---|"]
        lines += [*table(rows), ""]
    if kind := parameters_of(node):
        lines += [*parameter_rows(kind), ""]
    return "\n".join(lines)


def table(rows: Rows) -> list[str]:
    """Rows as those of a table."""
    return [f"| {does} | `{name}` | {kind} | {qos} |" for does, name, kind, qos in rows]


def described(node: str) -> str:
    """The docstring of a node's module, without what is a heading in a terminal."""
    part = next((one for one in PARTS if one.weight is not None and one.node == node), None)
    module = importlib.import_module(entry_point(node).partition(":")[0])
    written = module.__doc__ or "" if part is None else summary(part)
    text = re.sub(r"(?<=\S)\n(?=\S)", " ", written.strip())
    # Names of topics are no emphasis.
    return text.replace("*", "\\*").replace("_", "\\_")


def tables(text: str) -> Mapping[str, set[str]]:
    """The rows of a reference for topics and services, by node."""
    parts = re.split(r"^## (\w+)$", text, flags=re.MULTILINE)[1:]
    rows = ("| subscribes", "| publishes", "| offers", "| calls")
    return {
        node: {line for line in part.splitlines() if line.startswith(rows)}
        for node, part in zip(parts[::2], parts[1::2], strict=True)
    }


@click.command()
@click.argument("document", type=click.Path(dir_okay=False, path_type=Path))
def main(document: Path) -> None:
    """Write the reference into DOCUMENT."""
    with graph():
        sections = [
            section(name, [] if name == COMPOSED else run(name, look)[name]) for name in NODES
        ]
    write(document, "\n".join([HEAD, *sections]).rstrip() + "\n")


if __name__ == "__main__":
    main()
