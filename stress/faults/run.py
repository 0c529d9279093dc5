# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One fault: starts the monitor, plays a flight to it, breaks something, and listens."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool

from hijack_detect.nodes import COMPOSED, MONITOR
from hijack_detect.nodes.messages import message_class
from hijack_detect.nodes.qos import STATE
from stress.faults.attackers import Attacker
from stress.faults.cases import CASES, Case
from stress.faults.flight import BEGIN_S, END_S, FLIGHT_S, Sent, flight

ROOT = Path(__file__).parents[2]
READY_S, SETTLE_S = 60.0, 3.0
JUDGED = ("normal", "suspicious", "alarm")


class Watch(Node):
    """Plays the flight and records the monitor's outputs, in seconds of the flight."""

    def __init__(self, reliable: bool) -> None:
        """Listen."""
        super().__init__("watch")
        self._reliability = (
            ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT
        )
        self.begun = 0.0
        self.states: list[tuple[float, str, str, bool]] = []
        """When, state, missing detectors, and whether there is an alert, at each change."""
        self.words: list[float] = []
        """When hijack_alert was received,"""
        self.received: list[tuple[float, bool]] = []
        """and when it changed."""
        self.outlets: dict[str, Any] = {}
        self.create_subscription(Bool, "hijack_alert", self._alert, STATE)
        self.create_subscription(DiagnosticArray, "/diagnostics", self._state, 100)

    def outlet(self, topic: str, kind: str) -> Any:
        """A publisher of an input."""
        qos = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=100, reliability=self._reliability)
        return self.create_publisher(message_class(kind), topic, qos)

    def advertise(self, sent: Sequence[Sent]) -> None:
        """Make a publisher of every topic."""
        for one in sent:
            if one.topic not in self.outlets:
                self.outlets[one.topic] = self.outlet(one.topic, one.kind)

    def now_s(self) -> float:
        """Seconds of the flight."""
        return time.perf_counter() - self.begun

    @property
    def flying(self) -> bool:
        """Whether the flight has begun and is not over."""
        return self.begun > 0.0 and 0.0 <= self.now_s() <= FLIGHT_S

    def _alert(self, message: Bool) -> None:
        if self.flying:
            self.words.append(self.now_s())
            if not self.received or self.received[-1][1] != message.data:
                self.received.append((self.words[-1], message.data))

    def _state(self, message: DiagnosticArray) -> None:
        for one in message.status:
            if one.name != "/fusion: hijack alert" or not self.flying:
                continue
            values = {pair.key: pair.value for pair in one.values}
            state = values.get("state", "silent")
            news = (state, values.get("degraded", ""), values.get("alert") == "true")
            if not self.states or self.states[-1][1:] != news:
                self.states.append((self.now_s(), *news))


class Processes:
    """The monitor's processes."""

    def __init__(self, case: Case, environment: dict[str, str], log: Any) -> None:
        """Start them."""
        self._case, self._environment, self._log = case, environment, log
        names = (COMPOSED,) if case.composed else MONITOR
        self._running = {name: self._start(name) for name in names}

    def _start(self, name: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "hijack_detect.nodes", name, "--ros-args"]
        command += ["--params-file", "config/default.yaml", *self._case.arguments]
        return subprocess.Popen(
            command, cwd=ROOT, env=self._environment, stdout=self._log, stderr=subprocess.STDOUT
        )

    def hurt(self) -> None:
        """Send the victim its signal."""
        if self._case.signals is not None:
            self._running[self._case.victim].send_signal(self._case.signals)

    def heal(self) -> None:
        """Let the victim go on, or start it again."""
        victim = self._case.victim
        if self._case.signals == signal.SIGSTOP:
            self._running[victim].send_signal(signal.SIGCONT)
        elif self._case.signals == signal.SIGKILL:
            self._running[victim].wait()
            self._running[victim] = self._start(victim)

    def end(self) -> list[int]:
        """Interrupt all; return their exit codes."""
        for one in self._running.values():
            one.send_signal(signal.SIGINT)
        return [one.wait(20.0) for one in self._running.values()]


def play(case: Case, sent: Sequence[Sent], watch: Watch, processes: Processes) -> None:
    """Publish the flight in real time, with the fault."""
    executor = EventsExecutor()
    executor.add_node(watch)
    imu, subscribers = watch.outlets["/imu/data_raw"], 1 if case.composed else 3
    deadline = time.monotonic() + READY_S
    while case.reliable and imu.get_subscription_count() < subscribers:
        executor.spin_once(timeout_sec=0.1)
        if time.monotonic() > deadline:
            raise click.ClickException("the monitor does not listen")
    attacker: Attacker | None = None
    watch.begun = time.perf_counter() + 1.0
    hurt = healed = False
    for one in sent:
        while (wait := one.at_s - watch.now_s()) > 0.0:
            executor.spin_once(timeout_sec=wait)
        if not hurt and one.at_s >= BEGIN_S:
            hurt = True
            processes.hurt()
            if case.attacker is not None:
                attacker = case.attacker(watch)
        if not healed and one.at_s >= END_S:
            healed = True
            processes.heal()
            attacker = None
        watch.outlets[one.topic].publish(one.data)
        if attacker is not None:
            attacker(one)
    until = time.monotonic() + SETTLE_S
    while time.monotonic() < until:
        executor.spin_once(timeout_sec=0.1)
    executor.remove_node(watch)


def found(watch: Watch, output: str, codes: Sequence[int]) -> dict[str, Any]:
    """Outputs of the monitor, by seconds of the flight."""
    gaps = [after - before for before, after in zip(watch.words, watch.words[1:], strict=False)]
    warned = [line.split("]: ", 1)[-1] for line in output.splitlines() if "[WARN]" in line]
    fault = [one for one in watch.states if one[0] >= BEGIN_S]
    before = next((one for one in reversed(watch.states) if one[0] < BEGIN_S), None)
    troubled = next((one for one in fault if one[1] not in JUDGED or one[2]), None)
    if troubled is None and before is not None and before[1] not in JUDGED:
        troubled = (BEGIN_S, *before[1:])
    since_s = END_S if troubled is None else max(END_S, troubled[0])
    back = next((one for one in fault if one[0] >= since_s and one[1] == "normal"), None)
    return {
        "before": None if before is None else before[1],
        "after_s": None if troubled is None else troubled[0] - BEGIN_S,
        "said": None if troubled is None else " ".join(troubled[1:3]).strip(),
        "back_s": None if back is None else back[0] - END_S,
        "alert_s": next((one[0] for one in watch.states if one[3]), None),
        "last": watch.states[-1][1] if watch.states else None,
        "longest_silence_s": max(gaps, default=None),
        "states": watch.states,
        "heard": watch.received,
        "exit_codes": list(codes),
        "warnings": sorted(set(warned)),
    }


@click.command()
@click.argument("name", type=click.Choice(list(CASES)))
@click.argument("folder", type=click.Path(path_type=Path))
@click.argument("domain", type=int)
def main(name: str, folder: Path, domain: int) -> None:
    """Run the fault NAME with bags in FOLDER and print what was found as JSON."""
    case = CASES[name]
    sent = case.fault(flight(folder, case.place, case.spoofed_s))
    setting = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": str(domain)}
    os.environ.update(setting)
    with tempfile.TemporaryDirectory() as home, tempfile.TemporaryFile() as log:
        environment = {**os.environ, "ROS_HOME": home}
        rclpy.init()
        watch = Watch(case.reliable)
        watch.advertise(sent)
        processes = Processes(case, environment, log)
        codes: list[int] = []
        try:
            play(case, sent, watch, processes)
        finally:
            codes = processes.end()
        log.seek(0)
        output = log.read().decode(errors="replace")
    watch.destroy_node()
    rclpy.shutdown()
    click.echo(json.dumps(found(watch, output, codes)))


if __name__ == "__main__":
    main()
