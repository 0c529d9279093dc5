# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect doctor`."""

from __future__ import annotations

import json
import os
import secrets
import sys
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import click

from hijack_detect.cli.common import share_folder
from hijack_detect.cli.doctor import machine, packages, ros_settings, shared_memory
from hijack_detect.cli.doctor.child import Child, ChildError, findings
from hijack_detect.cli.doctor.finding import Check, Finding, Level, findings_of
from hijack_detect.nodes.running import NOT_BUILT_IN, is_asked_for, unprotected

PEER, GRAPH = "hijack_detect.cli.doctor.peer", "hijack_detect.cli.doctor.graph"
TALK_S, LOOK_S = 12.0, 25.0
"""Timeouts of the child processes. Chosen, not swept."""
STYLES = {Level.OK: "green", Level.INFO: "dim", Level.WARN: "yellow", Level.FAIL: "bold red"}


@click.command()
@click.option("--namespace", default="", metavar="/NAME", help="Namespace of the vehicle.")
@click.option("--mavros", is_flag=True, help="Expect the inputs under the names of mavros.")
@click.option("--no-dds", is_flag=True, help="Leave out what needs ROS to talk (10 s).")
@click.option("--clean", is_flag=True, help="Remove what dead processes left in shared memory.")
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
def doctor(namespace: str, mavros: bool, no_dds: bool, clean: bool, as_json: bool) -> None:
    """Check whether the monitor can run here, and what to mend.

    Looks at Python and ROS, at this installation, at the settings of DDS, at shared memory, clock,
    disk and processors; lets two processes talk over DDS; and looks whether the inputs of the
    monitor are there, how fast they come, and whether other monitors run.

    Exits with 0 if nothing fails, with 1 if something does. A warning is no failure.
    """
    if clean:
        removed = shared_memory.clean(shared_memory.leftovers())
        click.echo(f"removed {removed} leftovers of dead processes", err=True)
    checks = local_checks()
    if not no_dds:
        checks |= {"DDS": talk, "graph": partial(look, namespace, mavros=mavros)}
    found = []
    for name, check in checks.items():
        for one in findings_of(name, check):
            found.append(one)
            if not as_json:
                _show(one)
    if as_json:
        rows = [
            {"what": one.what, "level": one.level.value, "text": one.text, "mend": one.mend}
            for one in found
        ]
        click.echo(json.dumps(rows, indent=2, ensure_ascii=False))
    sys.exit(1 if any(one.level is Level.FAIL for one in found) else 0)


def local_checks() -> dict[str, Check]:
    """Checks that need no ROS, by name."""
    from hijack_detect.recording.parameters import RecorderParameters  # noqa: PLC0415  slow to load

    environment = dict(os.environ)
    prefixes = environment.get("AMENT_PREFIX_PATH", "")
    return {
        "Python": packages.python,
        "ROS": partial(packages.installation, environment),
        "dependencies": packages.dependencies,
        "shared files": partial(_share, prefixes),
        "RMW": partial(ros_settings.middleware, environment),
        "ROS_DOMAIN_ID": partial(ros_settings.domain, environment),
        "discovery": partial(ros_settings.discovery, environment),
        "Fast DDS profiles": partial(ros_settings.profiles, environment),
        "security": partial(_security, environment),
        "shared memory": shared_memory.memory,
        "clock": machine.clock,
        "processors": machine.processors,
        "recorder": partial(machine.disk, Path(RecorderParameters().folder)),
        "UDP": machine.sockets,
    }


def talk() -> Iterator[Finding]:
    """Let two processes talk over DDS, with the settings of this one."""
    topic = f"hijack_detect_doctor_{secrets.token_hex(8)}"
    with Child(PEER, ["publish", topic]), Child(PEER, ["subscribe", topic]) as subscriber:
        try:
            late_ms = subscriber.answer(TALK_S)
        except ChildError as error:
            mend = "mend what is wrong above; is multicast or loopback blocked by a firewall?"
            text = f"two processes receive nothing from each other: {error}"
            yield Finding("DDS", Level.FAIL, text, mend)
        else:
            yield Finding("DDS", Level.OK, f"two processes talk, {late_ms:.1f} ms a message")


def look(namespace: str, *, mavros: bool) -> Iterator[Finding]:
    """Look at inputs and monitors in the graph."""
    with Child(GRAPH, [namespace, str(mavros).lower()]) as child:
        try:
            yield from findings(child.answer(LOOK_S))
        except ChildError as error:
            text = f"cannot be looked at: {error}"
            yield Finding("graph", Level.FAIL, text, "mend what is wrong above")


def _security(environment: Mapping[str, str]) -> Iterator[Finding]:
    """Check that requested DDS security is there; nothing where it is not requested."""
    if not is_asked_for(environment):
        return
    mend = "unset ROS_SECURITY_ENABLE, or see docs/security.md"
    if packages.from_wheels():
        yield Finding("security", Level.FAIL, NOT_BUILT_IN, mend)
    elif text := unprotected([], environment):
        yield Finding("security", Level.FAIL, text, mend)
    else:
        yield Finding("security", Level.OK, "asked for, and there are keys")


def _share(prefixes: str) -> Iterator[Finding]:
    yield from packages.share(share_folder(), prefixes)


def _show(one: Finding) -> None:
    from rich.console import Console  # noqa: PLC0415  slow to load
    from rich.text import Text  # noqa: PLC0415

    line = Text.assemble(
        (f"{one.level.name:<5}", STYLES[one.level]), (f"{one.what}: ", "bold"), one.text
    )
    if one.mend:
        line.append(f"\n     → {one.mend}", "cyan")
    Console(soft_wrap=True).print(line)
