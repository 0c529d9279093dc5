# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The demonstration: real nodes, a replayed flight, a spoofed GPS."""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import rclpy
from rclpy.executors import Executor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rich.console import Console
from rich.live import Live

from hijack_detect.bags.reader import BagReader
from hijack_detect.cli.common import find_scenario, share_folder
from hijack_detect.cli.demo_view import live_view, timeline
from hijack_detect.cli.listener import Listener
from hijack_detect.cli.processes import NodeError, NodeProcesses, interrupt_held
from hijack_detect.nodes import MONITOR
from hijack_detect.replay.offline import OfflineRun, spoofed_samples
from hijack_detect.replay.truth import alert_is_right, scenario_attack
from hijack_detect.spoofing.scenario import Scenario

DEFAULT_BAG = "bags/curved_8"
DEFAULT_SCENARIO = "turn_away_track"
LAST_WORDS_S = 1.0
"""Quiet time after the replay's end that shows that every verdict has arrived. Chosen, not
swept."""
DOMAINS = range(1, 101)
"""Domain ids that a demonstration chooses from; the ports of higher ones are taken at random by
other programs."""


@dataclass(frozen=True)
class DemoOptions:
    """Flight and attack to show; None means the demonstration's own."""

    bag: Path | None
    scenario: str | None
    onset_s: float | None
    rate: float
    policy: str
    logs: Path | None


def run_demo(options: DemoOptions) -> bool:
    """Run the demonstration and print its timeline; true if the alert came when it should.

    Raises:
        ValueError: The bag or scenario cannot be used, or a node does not run.
    """
    share = share_folder()
    bag = options.bag or share / DEFAULT_BAG
    scenario = _scenario(options)
    console = Console()
    with contextlib.ExitStack() as stack:
        reader = stack.enter_context(BagReader(bag))
        reader.inputs()
        attack = None if scenario is None else scenario_attack(scenario, reader)
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="hijack_detect_")))
        logs = options.logs or folder
        logs.mkdir(parents=True, exist_ok=True)
        replay = ["-p", f"bag:={reader.path.resolve()}", "-p", f"rate:={options.rate}"]
        if scenario is not None:
            moved = folder / "scenario.yaml"
            moved.write_text(scenario.to_yaml(), encoding="utf-8")
            replay += ["-p", f"scenario:={moved}"]
        console.print(
            f"[bold]{_shown(reader.path)}[/] ({reader.duration_s:.0f} s), policy {options.policy}, "
            f"{options.rate:g}× real time; {len(MONITOR) + 1} processes over DDS"
        )
        listener = _play(console, options, share, replay, logs)
        run = OfflineRun(reader.start_ns)
        for _ in spoofed_samples(reader, scenario, run):
            pass
        if not console.is_terminal:
            console.print()
        console.print(timeline(listener, attack, run))
    return alert_is_right(listener.alert_ns, attack)


def _shown(path: Path) -> str:
    """A path as its reader would write it."""
    with contextlib.suppress(ValueError):
        return str(path.resolve().relative_to(Path.cwd()))
    return str(path)


def _scenario(options: DemoOptions) -> Scenario | None:
    given = options.scenario or DEFAULT_SCENARIO
    return None if given == "none" else find_scenario(given, options.onset_s)


def _play(
    console: Console, options: DemoOptions, share: Path, replay: list[str], logs: Path
) -> Listener:
    """Start all nodes, play the bag, and return what was received."""
    domain = os.environ.get("ROS_DOMAIN_ID") or str(DOMAINS[os.getpid() % len(DOMAINS)])
    graph = {"ROS_DOMAIN_ID": domain, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    os.environ.update(graph)
    inputs = ["--params-file", str(share / "config/replay.yaml")]
    policy = ["--params-file", str(share / f"config/{options.policy}.yaml")]
    with (
        interrupt_held() as pressed,
        NodeProcesses(logs, graph) as processes,
        _listening() as (listener, executor),
    ):
        for node in MONITOR:
            processes.start(node, [*policy, *inputs])
        wait = " ".join((*MONITOR, listener.get_name()))
        processes.start("bag_replay", [*replay, "-p", f"wait_for:={wait}"])
        with Live(live_view(listener), console=console, refresh_per_second=10) as live:
            received, quiet_since = 0, time.monotonic()
            while not pressed and (
                not listener.finished or time.monotonic() - quiet_since < LAST_WORDS_S
            ):
                executor.spin_once(timeout_sec=0.1)
                _check(processes, logs, finished=listener.finished)
                count = sum(map(len, listener.verdicts.values()))
                if count != received:
                    received, quiet_since = count, time.monotonic()
                live.update(live_view(listener))
    return listener


@contextlib.contextmanager
def _listening() -> Iterator[tuple[Listener, Executor]]:
    """The demonstration's own node; Ctrl-C stays with this process."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    listener = Listener()
    executor = EventsExecutor()
    executor.add_node(listener)
    try:
        yield listener, executor
    finally:
        executor.remove_node(listener)
        rclpy.try_shutdown()


def _check(processes: NodeProcesses, logs: Path, *, finished: bool) -> None:
    """Raise NodeError if a node has ended that should not have."""
    for node, code in processes.ended().items():
        if node != "bag_replay" or (code != 0 and not finished):
            last = processes.log(node).strip().splitlines()[-1:]
            raise NodeError(f"{node} ended with code {code}: {' '.join(last)} (logs in {logs})")
