# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Nodes as processes, started as the launch file starts them."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType

from ament_index_python.packages import PackageNotFoundError, get_package_prefix

PACKAGE = "hijack_detect"
STOP_S = 5.0
"""From SIGINT to SIGKILL. Chosen, as `ros2 launch` waits (sigterm_timeout)."""


class NodeError(ValueError):
    """A node cannot be started, or has ended by itself."""


class NodeProcesses:
    """Runs nodes until the block is left; none of them outlives it."""

    def __init__(self, logs: Path, environment: Mapping[str, str]) -> None:
        """Keep each node's output as NAME.log in a folder.

        Raises:
            NodeError: The package is not installed.
        """
        try:
            self._programs = Path(get_package_prefix(PACKAGE), "lib", PACKAGE)
        except PackageNotFoundError as error:
            raise NodeError(f"{PACKAGE} is not installed: run `make setup`, ({error})") from error
        self._logs = logs
        self._environment = {**os.environ, **environment}
        self._running: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, node: str, arguments: Sequence[str]) -> None:
        """Start a node's executable with ROS arguments."""
        with (self._logs / f"{node}.log").open("wb") as log, interrupt_held():
            self._running[node] = subprocess.Popen(
                [str(self._programs / node), "--ros-args", *arguments],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=self._environment,
                start_new_session=True,
            )

    def ended(self) -> dict[str, int]:
        """Exit codes of the nodes that have ended."""
        codes = {name: process.poll() for name, process in self._running.items()}
        return {name: code for name, code in codes.items() if code is not None}

    def log(self, node: str) -> str:
        """Output of a node."""
        return (self._logs / f"{node}.log").read_text(errors="replace")

    def __enter__(self) -> NodeProcesses:
        """Nothing runs yet."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Interrupt all nodes, and kill what has not ended after five seconds."""
        for process in self._running.values():
            _signal(process, signal.SIGINT)
        deadline = time.monotonic() + STOP_S
        for process in self._running.values():
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except (subprocess.TimeoutExpired, KeyboardInterrupt):
                _signal(process, signal.SIGKILL)
                process.wait()


@contextlib.contextmanager
def interrupt_held() -> Iterator[list[int]]:
    """Let Ctrl-C wait until the block is left, and raise KeyboardInterrupt there.

    In the middle of a start it would leave a process running, and in a callback of
    the executor it would be lost. The list yielded has an entry once it was pressed.
    """
    pressed: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed:
        raise KeyboardInterrupt


def _signal(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    """Signal the process and its children; it may have ended already."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, number)
