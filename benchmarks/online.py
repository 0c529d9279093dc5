# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Cost of the running monitor: processor, memory, and the time from a fix to the alert.

A simulated flight is played at its own pace, 200 Hz of Imu and 10 Hz of fixes and velocities, to
(a) the nodes as processes, (b) all of them in one, and (c) a node that only receives. Load is
measured on the clean part, with a mission manager as the only subscriber. Then a carry-off pulls
harder and harder, and each alert is taken back at once, so that a fix soon decides the next one:
the latency is the time from publishing the fix with the alert's stamp until hijack_alert arrives,
beside that of a bare answer of (c), which is two hops. Loss is counted at 1000 Hz.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
import psutil
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from load import load_bag
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rich.table import Table
from section import Section
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from hijack_detect.bags.encoding import encode_sample
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.bags.topics import OWN_TOPICS, TYPES
from hijack_detect.nodes import COMPOSED, MONITOR
from hijack_detect.nodes.messages import message_class
from hijack_detect.nodes.qos import INTERNAL, STATE
from hijack_detect.spoofing.scenario import parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import NANOSECONDS

HERE = Path(__file__).parent
INPUTS = ("imu", "velocity", "fix")
"""In the order in which messages with equal stamps are published."""
CLEAN_S, ATTACK_S = 60.0, 30.0
FAST_S, FAST_HZ = 60.0, 1000
SETTLED_S = 15.0
"""From when on load is measured."""
ATTACK = {
    "segments": [
        {
            "start": CLEAN_S,
            "model": {
                "type": "drift",
                "speed_m_s": 60.0,
                "bearing_deg": 45.0,
                "onset_acceleration_m_s2": 2.0,
            },
        }
    ]
}
SETTING = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": "101"}
READY_S = 60.0
SHOWN = ("core_percent", "memory_mb", "latency_p50_ms", "latency_p99_ms", "latency_max_ms")
COMPARED = SHOWN[:3]


@dataclass(frozen=True)
class Sent:
    """A message to publish: seconds after the first, input, stamp and bytes."""

    at_s: float
    name: str
    stamp_ns: int
    data: bytes


def flight(folder: Path, seconds: float, imu_hz: int) -> list[Sent]:
    """The messages of a flight that is attacked at CLEAN_S, if it is that long."""
    with BagReader(load_bag(folder, seconds, imu_hz)) as reader:
        read = read_samples(reader, reader.inputs(), on_rejected=Rejected().add)
        spoofer = Spoofer(parse_scenario(ATTACK), reader.start_ns)
        samples = [(name, one) for name, one in read if name in INPUTS]
    samples.sort(key=lambda pair: (pair[1].stamp_ns, INPUTS.index(pair[0])))
    start_ns = samples[0][1].stamp_ns
    messages = []
    for name, true in samples:
        one = spoofer.report(true)
        at_s = (one.stamp_ns - start_ns) / NANOSECONDS
        messages.append(Sent(at_s, name, one.stamp_ns, encode_sample(one)[1]))
    return messages


class Autopilot(Node):
    """Plays a flight, and is the mission manager too."""

    def __init__(self) -> None:
        """Advertise and subscribe."""
        super().__init__("autopilot")
        self.publishers_of = {
            name: self.create_publisher(message_class(TYPES[name]), OWN_TOPICS[name], INTERNAL)
            for name in INPUTS
        }
        self.create_subscription(Bool, "hijack_alert", self._hear_alert, STATE)
        self.create_subscription(Bool, "echo", self._hear_echo, INTERNAL)
        self.create_subscription(DiagnosticArray, "/diagnostics", self._hear_report, INTERNAL)
        self.resets = [
            self.create_client(Trigger, f"{name}/reset") for name in ("fusion", "kld_detector")
        ]
        self.fix_s = 0.0
        """When the newest fix was published."""
        self.fixes: dict[int, float] = {}
        """When the fix with a stamp was published."""
        self.alerts: list[float] = []
        self.alert_stamps: list[int] = []
        self.echoes: list[float] = []
        self.received = 0
        """Imu messages that the coast detector has received."""
        self._alerted = False

    def listen(self) -> None:
        """Hear which stamp has an alert, from now on."""
        self.create_subscription(DiagnosticArray, "fusion/verdict", self._hear_verdict, INTERNAL)

    def _hear_alert(self, message: Bool) -> None:
        if message.data and not self._alerted:
            self.alerts.append(time.perf_counter())
            for client in self.resets:
                client.call_async(Trigger.Request())
        self._alerted = message.data

    def _hear_verdict(self, message: DiagnosticArray) -> None:
        values = {pair.key: pair.value for pair in message.status[0].values}
        since = values["alert_since_ns"]
        if since and (not self.alert_stamps or self.alert_stamps[-1] != int(since)):
            self.alert_stamps.append(int(since))

    def _hear_report(self, message: DiagnosticArray) -> None:
        for one in message.status:
            if one.name == "/coast_detector: inputs":
                values = {pair.key: pair.value for pair in one.values}
                self.received = int(values.get("received imu", "0"))

    def _hear_echo(self, _: Bool) -> None:
        self.echoes.append(time.perf_counter() - self.fix_s)

    def publish(self, one: Sent) -> None:
        """Publish a message."""
        if one.name == "fix":
            self.fix_s = self.fixes[one.stamp_ns] = time.perf_counter()
        self.publishers_of[one.name].publish(one.data)

    def latencies_s(self) -> list[float]:
        """Seconds from publishing the fix that an alert is stamped with until it was received."""
        found = []
        for at_s, stamp_ns in zip(self.alerts, self.alert_stamps, strict=False):
            earlier = [ns for ns in self.fixes if ns <= stamp_ns]
            found.append(at_s - self.fixes[max(earlier)])
        return found


class Load:
    """Processor time and memory of processes and all that they have started."""

    def __init__(self, pids: Sequence[int]) -> None:
        """Begin to count."""
        parents = [psutil.Process(pid) for pid in pids]
        self._all = [one for parent in parents for one in (parent, *parent.children(True))]
        self._before, self._began = self._cpu_s(), time.perf_counter()

    def _cpu_s(self) -> float:
        times = [one.cpu_times() for one in self._all]
        return sum(one.user + one.system for one in times)

    def figures(self) -> dict[str, float]:
        """Percent of a core since it was made, and megabytes."""
        seconds = time.perf_counter() - self._began
        unique = sum(one.memory_full_info().uss for one in self._all)
        return {
            "core_percent": 100.0 * (self._cpu_s() - self._before) / seconds,
            "memory_mb": unique / 1e6,
        }


def measured(programs: Sequence[list[str]], subscribers: int, sent: Sequence[Sent]) -> Any:
    """Play a flight to programs.

    Args:
        programs: Their commands.
        subscribers: How many subscriptions to the Imu they have together.
        sent: The flight.

    Returns:
        The figures of the load, the node that played, and how often messages were late.
    """
    running = [
        subprocess.Popen(one, env={**os.environ, **SETTING}, stderr=subprocess.DEVNULL)
        for one in programs
    ]
    os.environ.update(SETTING)
    rclpy.init()
    node, executor = Autopilot(), EventsExecutor()
    executor.add_node(node)
    try:
        deadline = time.monotonic() + READY_S
        while node.publishers_of["imu"].get_subscription_count() < subscribers:
            executor.spin_once(timeout_sec=0.1)
            if time.monotonic() > deadline:
                raise click.ClickException(f"{programs[0]} does not listen")
        load, figures = None, {}
        late = []
        start = time.perf_counter() + 1.0
        for one in sent:
            while (wait := start + one.at_s - time.perf_counter()) > 0.0:
                executor.spin_once(timeout_sec=wait)
            late.append(-wait)
            node.publish(one)
            if load is None and one.at_s > SETTLED_S:
                load = Load([process.pid for process in running])
            if load and not figures and one.at_s > CLEAN_S - 1.0:
                figures = load.figures()
                node.listen()
        figures = figures or load.figures() if load else figures
        for _ in range(20):
            executor.spin_once(timeout_sec=0.1)
        figures["autopilot_late_p99_ms"] = 1e3 * float(np.quantile(late, 0.99))
        return figures, node
    finally:
        for process in running:
            process.send_signal(signal.SIGINT)
        for process in running:
            process.wait()
        executor.remove_node(node)
        node.destroy_node()
        rclpy.shutdown()


def spread(seconds: Sequence[float], prefix: str) -> dict[str, float]:
    """Median, 99th percentile and largest in milliseconds, and how many there are."""
    if not seconds:
        return {f"{prefix}_count": 0}
    p50, p99 = np.quantile(seconds, [0.5, 0.99]) * 1e3
    return {
        f"{prefix}_p50_ms": float(p50),
        f"{prefix}_p99_ms": float(p99),
        f"{prefix}_max_ms": 1e3 * max(seconds),
        f"{prefix}_count": len(seconds),
    }


def node_command(name: str) -> list[str]:
    """Command that starts a node of the package with the default policy."""
    config = str(HERE.parent / "config/default.yaml")
    node = ["-m", "hijack_detect.nodes", name]
    return [sys.executable, *node, "--ros-args", "--params-file", config]


def measure(folder: Path, repeats: int) -> Section:
    """Load and latency over those of a node that only receives. Once: it takes real time."""
    sent = flight(folder, CLEAN_S + ATTACK_S, 200)
    graphs: dict[str, tuple[list[list[str]], int]] = {
        "processes": ([node_command(name) for name in MONITOR], 3),
        "composed": ([node_command(COMPOSED)], 1),
        "echo": ([[sys.executable, str(HERE / "echo.py")]], 1),
    }
    found: dict[str, dict[str, float]] = {}
    for name, (programs, subscribers) in graphs.items():
        click.echo(f"live, {name}: {sent[-1].at_s:.0f} s", err=True)
        figures, node = measured(programs, subscribers, sent)
        seconds = node.echoes if name == "echo" else node.latencies_s()
        found[name] = {**figures, **spread(seconds, "latency")}
    fast = flight(folder, FAST_S, FAST_HZ)
    click.echo(f"live, composed at {FAST_HZ} Hz: {FAST_S:.0f} s", err=True)
    figures, node = measured(*graphs["composed"], fast)
    readings = sum(one.name == "imu" for one in fast)
    found["fast"] = {**figures, "sent": readings, "lost": readings - node.received}
    table = Table("live", "% of a core", "MB", "p50 ms", "p99 ms", "max ms", "alerts")
    for name in graphs:
        one = found[name]
        cells = [f"{one[key]:.1f}" if key in one else "-" for key in SHOWN]
        table.add_row(name, *cells, str(one["latency_count"]))
    ratios = {
        f"{name}, {key}": found[name][key] / found["echo"][key]
        for name in ("processes", "composed")
        for key in COMPARED
        if key in found[name]
    }
    text = "{lost} of {sent} Imu messages lost, {core_percent:.1f} % of a core"
    remark = f"composed at {FAST_HZ} Hz: " + text.format(**found["fast"])
    return Section(ratios, found, table, (remark,))
