# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Starting and stopping a node's process cleanly."""

from __future__ import annotations

import ctypes
import itertools
import os
import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Protocol, runtime_checkable

import rclpy
from rclpy.executors import Executor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.utilities import ok, try_shutdown

NOT_BUILT_IN = (
    "ROS_SECURITY_ENABLE is true, but this Fast DDS was built without DDS security, as all wheels "
    "from PyPI are: use an installed ROS 2 Jazzy, or unset ROS_SECURITY_ENABLE to run without "
    "protection"
)


def is_asked_for(environment: Mapping[str, str] = os.environ) -> bool:
    """Whether ROS is set to protect this process."""
    return environment.get("ROS_SECURITY_ENABLE") == "true"


def unprotected(arguments: Sequence[str], environment: Mapping[str, str] = os.environ) -> str:
    """Why this process runs without the protection that was asked for; empty if it does not.

    With any strategy but Enforce, rcl goes on without security where it finds no keys.
    """
    if not is_asked_for(environment):
        return ""
    enclave = environment.get("ROS_SECURITY_ENCLAVE_OVERRIDE") or _enclave(arguments)
    keystore = environment.get("ROS_SECURITY_KEYSTORE", "")
    keys = Path(keystore, "enclaves", enclave.strip("/"))
    if keystore and keys.is_dir():
        return ""
    return (
        f"NOT PROTECTED although ROS_SECURITY_ENABLE is true: {keys} has no keys for the enclave "
        f"{enclave}; make them with `ros2 security create_enclave`, and set "
        "ROS_SECURITY_STRATEGY=Enforce to rather not start"
    )


def _enclave(arguments: Sequence[str]) -> str:
    for flag, value in itertools.pairwise(arguments):
        if flag in ("-e", "--enclave"):
            return value
    return "/"


EXIT_BAD_INPUT = 2
END_S = 5
"""Fast DDS 2.14 can lock itself up when a node is destroyed while another one leaves the graph: it
waits, in DomainParticipant::set_listener, for a callback that waits for it. No process stays
behind for that; it then ends with SIGALRM."""
SPIN_S = 0.1
"""The events executor of Jazzy sees signals only between calls with a time-out."""


@runtime_checkable
class Ending(Protocol):
    """A node that does something when its process was asked to end, and not when it crashes."""

    def ended(self) -> None:
        """ROS was shut down by a signal."""


def run(
    make: Callable[[], Node], summary: str, executor_type: Callable[[], Executor] = EventsExecutor
) -> None:
    """Run a node until it is interrupted: the whole `main` of a node's executable.

    See `run_composed`.
    """
    run_composed(lambda _: [make()], summary, executor_type)


def run_composed(
    make: Callable[[Executor], Sequence[Node]],
    summary: str,
    executor_type: Callable[[], Executor] = EventsExecutor,
) -> None:
    """Run several nodes in one executor until they are interrupted.

    ROS arguments that cannot be used, and a ValueError while a node is made (a parameter out
    of bounds, a bag that cannot be read), end the process with one line on stderr and exit
    code 2. So does DDS security that was asked for and is not built in. `--help` prints the
    summary.
    """
    if {"-h", "--help"} & set(sys.argv[1:]):
        program = Path(sys.argv[0]).stem
        print(f"usage: {program} [--ros-args -p NAME:=VALUE --params-file FILE -r FROM:=TO]\n")
        print(summary.strip())
        return
    # rclpy ends the node at Ctrl-C; a KeyboardInterrupt would hit it in the middle of a callback.
    pressed: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        rclpy.init(args=sys.argv)
    except RuntimeError as error:  # a parameter file that cannot be read
        print(f"error: {' '.join(str(error).split())}", file=sys.stderr)
        sys.exit(EXIT_BAD_INPUT)
    if pressed:  # before rclpy was listening
        try_shutdown()
        return
    executor = executor_type()
    # The events executor of Jazzy aborts the process in its destructor if a signal came while a
    # node was being added. This reference is never given back.
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(executor))
    try:
        nodes = make(executor)
    except (ValueError, RuntimeError) as error:
        if not ok():  # interrupted while it started
            end_soon()
            return
        built_out = "security libraries" in str(error)
        if not isinstance(error, ValueError) and not (is_asked_for() and built_out):
            raise
        print(f"error: {NOT_BUILT_IN if built_out else error}", file=sys.stderr)
        try_shutdown()
        sys.exit(EXIT_BAD_INPUT)
    if why := unprotected(sys.argv):
        nodes[0].get_logger().error(why)
    try:
        _spin(executor, nodes)
        for node in nodes:
            if isinstance(node, Ending):
                node.ended()
    finally:
        end_soon()
        for node in nodes:
            executor.remove_node(node)
            node.destroy_node()
        try_shutdown()


def end_soon() -> None:
    """Let the process end within END_S, whatever Fast DDS does."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(END_S)


def _spin(executor: Executor, nodes: Sequence[Node]) -> None:
    """Work until ROS is shut down."""
    try:
        for node in nodes:
            executor.add_node(node)
        while ok():
            executor.spin_once(timeout_sec=SPIN_S)
    except Exception:  # a callback that was publishing when rclpy shut down
        if ok():
            raise
