# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The monitor as processes over DDS: what its nodes are fed, and what they say.

The nodes of the monitor, a replayed bag, and every verdict that was heard, beside what an offline
run of the same bag says. Messages are compared, so equal means equal to the bit: the numbers of a
verdict are text that reads back exactly.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from kept import kept
from ros import READY, ROOT, Graph, Listener, RosProcess
from std_msgs.msg import Bool

from hijack_detect.bags.reader import BagReader
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.parts import DETECTORS
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.nodes import MONITOR
from hijack_detect.nodes.messages import fusion_message, verdict_message
from hijack_detect.nodes.qos import STATE
from hijack_detect.replay.offline import (
    OfflineRun,
    run_offline,
    run_samples,
    spoofed_samples,
)
from hijack_detect.spoofing.scenario import load_scenario

SECOND = 1_000_000_000
SCENARIO = ROOT / "config/scenarios/turn_away_track.yaml"


@dataclass
class Live:
    """A running monitor and what was heard of it."""

    nodes: dict[str, RosProcess]
    verdicts: dict[str, Listener]
    """DETECTOR/verdict of each detector, and fusion/verdict."""
    alert: Listener


def start_monitor(graph: Graph, policy: str, programs: Sequence[str] = MONITOR) -> Live:
    """Start the nodes as the demonstration does, or all of them in one process."""
    verdicts = {
        name: graph.listen(DiagnosticArray, f"{name}/verdict") for name in (*DETECTORS, "fusion")
    }
    alert = graph.listen(Bool, "hijack_alert", STATE)
    files = [f"config/{policy}.yaml", "config/replay.yaml"]
    arguments = [word for file in files for word in ("--params-file", str(ROOT / file))]
    arguments += ["-p", "monitor:publish_rate:=0.0"]  # composed nodes leave nothing out either
    return Live({name: graph.start(name, *arguments) for name in programs}, verdicts, alert)


def start_replay(
    graph: Graph, bag: Path, nodes: Sequence[str], *arguments: str, space: str = "", **given: Any
) -> RosProcess:
    """Start a replay in a namespace, beside what is started already.

    It begins when its nodes are complete and know all that listens now, a while after the last
    subscription came, so that they know each other, too: see its parameter settle_s.
    """
    named = [f"{space}/{node}" for node in nodes]
    place = ("-r", f"__ns:={space}") if space else ()
    parameters = {"bag": bag, "wait_for": " ".join((*named, READY)), **given}
    process = graph.start("bag_replay", *place, *arguments, parameters=parameters)
    graph.until_known(*named, f"{space}/bag_replay")
    return process


def replay(
    graph: Graph, bag: Path, timeout_s: float, nodes: Sequence[str] = MONITOR, **given: Any
) -> RosProcess:
    """Replay a bag to nodes, and listen until everything has arrived."""
    process = start_replay(graph, bag, nodes, **given)
    graph.be_ready()
    assert graph.spin_to_end(process, timeout_s) == 0, process.output
    return process


def offline(bag: Path, policy: str, scenario: Path | None, end_s: float = math.inf) -> OfflineRun:
    """What the same bag, or its begin, says without ROS; computed once, so not to be changed."""

    def run() -> OfflineRun:
        with BagReader(bag) as reader:
            attack = None if scenario is None else load_scenario(scenario)
            if math.isinf(end_s):
                return run_offline(reader, policy_parameters(policy), attack)
            done = OfflineRun(reader.start_ns)
            end_ns = done.start_ns + round(end_s * SECOND)
            samples = spoofed_samples(reader, attack, done)
            part = itertools.takewhile(lambda one: one[1].stamp_ns < end_ns, samples)
            return run_samples(part, Monitor(policy_parameters(policy)), done)

    return kept(f"offline {bag} {policy} {scenario} {end_s}", run)


def expected(run: OfflineRun) -> dict[str, list[DiagnosticArray]]:
    """The messages that the nodes would publish for an offline run, by detector, and fusion."""
    found = {name: [verdict_message(one) for one in told] for name, told in run.verdicts.items()}
    return {**found, "fusion": [fusion_message(one) for one in run.results]}


def assert_same(
    name: str,
    heard: Sequence[DiagnosticArray],
    wanted: Sequence[DiagnosticArray],
    complaints: Sequence[str] = (),
) -> None:
    """Fail with the first message that differs, and with what the nodes complained of."""
    for index, (ours, theirs) in enumerate(itertools.zip_longest(heard, wanted)):
        if ours != theirs:
            pytest.fail(
                f"{name}: live and offline differ at message {index} (heard {len(heard)}, "
                f"offline {len(wanted)}):\nlive    {told(ours)}\noffline {told(theirs)}\n"
                + "\n".join(complaints)
            )


def told(message: DiagnosticArray | None) -> str:
    """A verdict in one line."""
    if message is None:
        return "nothing"
    one = message.status[0]
    pairs = " ".join(f"{pair.key}={pair.value}" for pair in one.values)
    return f"{stamp_ns(message)} level {one.level!r} {one.message!r} {pairs}"


def stamp_ns(message: Any) -> int:
    """Header stamp, nanoseconds."""
    return int(message.header.stamp.sec) * SECOND + int(message.header.stamp.nanosec)


def values_of(one: DiagnosticStatus | DiagnosticArray) -> dict[str, str]:
    """Key and value of each pair of a diagnostic status."""
    found = one.status[0] if isinstance(one, DiagnosticArray) else one
    return {pair.key: pair.value for pair in found.values}
