# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A day of flights through the monitor over DDS, as fast as it follows: does its memory grow?

    python -m stress.faults.soak build/bench docs/reliability.md

The same clean flight of ten minutes again and again, half a minute apart, 100 Hz of Imu and 5 Hz of
fixes, with every sensor, to the node `all`.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import click
import psutil
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rich.console import Console
from rich.progress import track
from std_msgs.msg import Bool

from benchmarks.load import load_bag
from hijack_detect.bags.reader import BagReader
from hijack_detect.evaluation.scores.evaluation_page import TextTable
from hijack_detect.nodes import COMPOSED
from hijack_detect.nodes.messages import message_class
from hijack_detect.nodes.qos import INTERNAL, STATE
from hijack_detect.streams.samples import NANOSECONDS
from stress.faults.flight import Sent
from tools.documents import fill, write

ROOT = Path(__file__).parents[2]
PATH = click.Path(path_type=Path)
DOMAIN = "93"
FLIGHT_S, APART_S, IMU_HZ, GPS_HZ = 600.0, 30.0, 100, 5
AHEAD_NS, BATCH_NS = 3 * NANOSECONDS, NANOSECONDS
"""The monitor may be behind by this much, and is given this much at a time."""
STUCK_S = 1.0
"""It is not waited for any longer: at the end of a flight nothing follows."""
HOURS = (1, 3, 6, 12, 18, 24)


class Player(Node):
    """Publishes flights and notes how far the monitor has come."""

    def __init__(self) -> None:
        """Listen to the fusion."""
        super().__init__("player")
        self.passed_ns, self.alerts, self.state = 0, 0, ""
        self.outlets: dict[str, Any] = {}
        self.create_subscription(DiagnosticArray, "fusion/verdict", self._passed, INTERNAL)
        self.create_subscription(Bool, "hijack_alert", self._alert, STATE)

    def publish(self, one: Sent) -> None:
        """Publish a message."""
        if one.topic not in self.outlets:
            kind = message_class(one.kind)
            self.outlets[one.topic] = self.create_publisher(kind, one.topic, INTERNAL)
        self.outlets[one.topic].publish(one.data)

    def _passed(self, message: DiagnosticArray) -> None:
        stamp = message.header.stamp
        self.passed_ns = stamp.sec * NANOSECONDS + stamp.nanosec
        values = {pair.key: pair.value for pair in message.status[0].values}
        self.state = values["state"]

    def _alert(self, message: Bool) -> None:
        self.alerts += message.data


def fly(player: Player, executor: EventsExecutor, flight: list[Sent], shift_ns: int) -> None:
    """Publish a flight, no faster than the monitor follows."""
    next_ns = 0
    for one in flight:
        moved = one.restamped(lambda ns: ns + shift_ns)
        player.publish(moved)
        sent_ns = moved.stamp_ns
        if sent_ns is None or sent_ns < next_ns:
            continue
        next_ns = sent_ns + BATCH_NS
        since_s, before_ns = time.monotonic(), player.passed_ns
        while player.passed_ns < sent_ns - AHEAD_NS and time.monotonic() - since_s < STUCK_S:
            executor.spin_once(timeout_sec=0.02)
            if player.passed_ns > before_ns:
                since_s, before_ns = time.monotonic(), player.passed_ns


def table(rows: list[dict[str, Any]]) -> TextTable:
    """Some rows of what was noted."""
    shown = [min(rows, key=lambda one: abs(one["hours"] - hour)) for hour in HOURS]
    heads = (
        "hours flown",
        "memory",
        "threads",
        "open files",
        "alerts",
        "state",
        "faster than life",
    )
    return TextTable(
        "",
        heads,
        tuple(
            (
                f"{one['hours']:.1f}",
                f"{one['mb']:.1f} MB",
                str(one["threads"]),
                str(one["files"]),
                str(one["alerts"]),
                one["state"],
                f"{one['times']:.0f} times",
            )
            for one in shown
        ),
    )


@click.command()
@click.argument("folder", type=PATH)
@click.argument("document", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--hours", type=click.FloatRange(0.1), default=24.0, show_default=True)
def main(folder: Path, document: Path, hours: float) -> None:
    """Fly with bags in FOLDER, and write the table into DOCUMENT."""
    with BagReader(load_bag(folder, FLIGHT_S, IMU_HZ, GPS_HZ)) as reader:
        flight = [Sent(0.0, raw.topic, raw.msgtype, raw.data) for raw in reader.messages()]
    os.environ.update(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST", ROS_DOMAIN_ID=DOMAIN)
    rclpy.init()
    player, executor = Player(), EventsExecutor()
    executor.add_node(player)
    command = [sys.executable, "-m", "hijack_detect.nodes", COMPOSED, "--ros-args"]
    for name in ("default", "replay"):
        command += ["--params-file", f"config/{name}.yaml"]
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as home:
        process = subprocess.Popen(command, cwd=ROOT, env={**os.environ, "ROS_HOME": home})
        watched = psutil.Process(process.pid)
        while player.count_subscribers("/imu/data_raw") == 0:
            executor.spin_once(timeout_sec=0.1)
        flights = round(hours * 3600.0 / (FLIGHT_S + APART_S))
        for number in track(range(flights), "flights", console=Console(stderr=True)):
            begun_s = time.monotonic()
            fly(player, executor, flight, round(number * (FLIGHT_S + APART_S) * NANOSECONDS))
            rows.append(
                {
                    "hours": (number + 1) * (FLIGHT_S + APART_S) / 3600.0,
                    "mb": watched.memory_info().rss / 1e6,
                    "threads": watched.num_threads(),
                    "files": watched.num_fds(),
                    "alerts": player.alerts,
                    "state": player.state,
                    "times": FLIGHT_S / (time.monotonic() - begun_s),
                }
            )
            write(folder / "soak.json", json.dumps(rows, indent=1) + "\n")
        process.send_signal(signal.SIGINT)
        click.echo(f"exit code {process.wait(30.0)}")
    rclpy.shutdown()
    fill(document, lambda what: table(rows) if what == "soak" else None)


if __name__ == "__main__":
    main()
