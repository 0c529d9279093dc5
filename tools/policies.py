# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Writes the SROS2 policy of every node: what it has in a running graph, and no more.

python -m tools.policies config/sros2

px4_bridge needs px4_msgs: source a workspace that has it.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeVar
from xml.etree import ElementTree as ET

import click
import rclpy
from rclpy.node import Node

from hijack_detect.nodes import COMPOSED, MONITOR, NODES

ROOT = Path(__file__).parents[1]
DOMAIN = 94
MANAGER = "mission_manager"
VIEWER = "live"
ABSOLUTE = ("/rosout", "/parameter_events", "/diagnostics", "/clock")
"""Topics that no namespace moves."""
PROGRAMS = {
    MANAGER: ["examples/mission_manager.py"],
    VIEWER: ["-m", "hijack_detect.cli.main", "live", "--port", "0"],
    "bag_replay": [
        *("-m", "hijack_detect.nodes", "bag_replay"),
        *("--ros-args", "-p", f"bag:={ROOT / 'bags/curved_8'}"),
    ],
}
"""Executables that are not started as a node without arguments."""
READY_S, SETTLE_S = 30.0, 3.0
T = TypeVar("T")
Rights = Mapping[tuple[str, str], Sequence[str]]
"""Names by what they are (topics, services) and what may be done (publish, reply and so on)."""


def rights(node: Node, name: str) -> Rights:
    """What a node of the graph has, relative to its namespace."""
    publish = node.get_publisher_names_and_types_by_node(name, "/")
    subscribe = node.get_subscriber_names_and_types_by_node(name, "/")
    reply = node.get_service_names_and_types_by_node(name, "/")
    request = node.get_client_names_and_types_by_node(name, "/")
    return {
        ("topics", "publish"): _names(name, publish),
        ("topics", "subscribe"): _names(name, subscribe),
        ("services", "reply"): _names(name, reply),
        ("services", "request"): _names(name, request),
    }


def _names(node: str, found: Sequence[tuple[str, Sequence[str]]]) -> list[str]:
    return sorted(relative(node, full) for full, _ in found)


def relative(node: str, full: str) -> str:
    """A full name as it is written in the code of a node in the root namespace."""
    if full in ABSOLUTE:
        return full
    private = full.removeprefix(f"/{node}/")
    return full.removeprefix("/") if private == full else f"~/{private}"


def policy(enclave: str, profiles: Mapping[str, Rights]) -> str:
    """A policy in the format of SROS2, version 0.2.0."""
    root = ET.Element("policy", version="0.2.0")
    found = ET.SubElement(
        ET.SubElement(root, "enclaves"), "enclave", path=f"/hijack_detect/{enclave}"
    )
    all_of = ET.SubElement(found, "profiles")
    for node, allowed in profiles.items():
        profile = ET.SubElement(all_of, "profile", ns="/", node=node)
        for (kind, what), names in allowed.items():
            if names:
                group = ET.SubElement(profile, kind, {what: "ALLOW"})
                for name in names:
                    ET.SubElement(group, kind.removesuffix("s")).text = name
    ET.indent(root)
    head = '<?xml version="1.0" encoding="UTF-8"?>\n<!-- Made by tools/policies.py -->\n'
    return f"{head}{ET.tostring(root, encoding='unicode')}\n"


@contextlib.contextmanager
def graph() -> Iterator[None]:
    """A separate graph for the processes that are started."""
    os.environ.update(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST", ROS_DOMAIN_ID=str(DOMAIN))
    rclpy.init()
    try:
        yield
    finally:
        rclpy.shutdown()


def run(name: str, look: Callable[[Node, str], T]) -> dict[str, T]:
    """Start a process, and give what `look` makes of an observer and each of its nodes."""
    program = PROGRAMS.get(name, ["-m", "hijack_detect.nodes", name])
    process = subprocess.Popen([sys.executable, *program], cwd=ROOT)
    wanted = ("monitor", *MONITOR) if name == COMPOSED else (name,)
    observer = Node("observer")
    try:
        deadline = time.monotonic() + READY_S
        while not set(wanted) <= set(observer.get_node_names()):
            if time.monotonic() > deadline:
                raise click.ClickException(f"{name} does not start")
            time.sleep(0.1)
        time.sleep(SETTLE_S)
        return {one: look(observer, one) for one in wanted}
    finally:
        process.terminate()
        process.wait()
        observer.destroy_node()


@click.command()
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
def main(folder: Path) -> None:
    """Write NODE.policy.xml for every node into FOLDER."""
    folder.mkdir(parents=True, exist_ok=True)
    with graph():
        for name in (*NODES, MANAGER, VIEWER):
            text = policy(name, run(name, rights))
            (folder / f"{name}.policy.xml").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
