# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node recorder, and a test as the autopilot and the monitor."""

from __future__ import annotations

import sqlite3
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from feed import GPS_NS, GPS_STEPS, NOW, START_NS, fix, imu, mag, velocity, verdict
from live import SECOND
from ros import Graph
from std_msgs.msg import Bool, String, UInt32

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import State
from hijack_detect.nodes.messages import fusion_message
from hijack_detect.nodes.qos import INTERNAL, STATE

TOPICS = {
    "imu/data_raw": 10,
    "gps/fix": 1,
    "gps/vel": 1,
    "mag": 1,
    "gps/satellites": 1,
    "date/verdict": 1,
    "fusion/verdict": 1,
    "hijack_alert": 1,
}
"""Topics of the flight, and messages in each GPS interval."""
STAMPED = [topic for topic in TOPICS if topic not in ("gps/satellites", "hijack_alert")]
INPUTS = [topic for topic in TOPICS if "verdict" not in topic and topic != "hijack_alert"]


def told(stamp_ns: int, *, alert: bool) -> DiagnosticArray:
    """A verdict of the fusion."""
    state = State.ALARM if alert else State.NORMAL
    since = stamp_ns if alert else None
    causes = ("date",) if alert else ()
    return fusion_message(
        FusionResult(stamp_ns, state, alert, since, 0.5, "date alarm", {}, (), causes)
    )


class Recorded:
    """A recorder, and the test as the autopilot and the monitor."""

    def __init__(
        self,
        graph: Graph,
        folder: Path,
        *ros_arguments: str,
        space: str = "",
        reliable: bool = True,
        **given: Any,
    ) -> None:
        self.graph, self.folder, self.space = graph, folder, space
        self.parameters = {"folder": folder, "before_s": 5.0, "after_s": 2.0, **given}
        self.arguments = [*ros_arguments]
        for topic in INPUTS if reliable else ():
            override = f"qos_overrides.{space}/{topic}.subscription"
            self.arguments += ["-p", f"{override}.reliability:=reliable"]
            self.arguments += ["-p", f"{override}.history:=keep_all"]
        self.stamp_ns = START_NS
        self._publishers: dict[tuple[str, type], Any] = {}
        self.diagnostics = graph.listen(DiagnosticArray, "/diagnostics")
        self.start()
        graph.until_known(f"{space}/recorder")

    def start(self) -> None:
        self.paths = self.graph.listen(String, f"{self.space}/recorder/snapshot", STATE)
        self.node = self.graph.start("recorder", *self.arguments, parameters=self.parameters)
        self.fly(0.0)
        self.graph.spin_until(
            lambda: all(one.get_subscription_count() for one in self._publishers.values()),
            "subscriptions of the recorder",
        )

    def fly(self, seconds: float, *, alert: bool = False) -> None:
        """Publish a flight; with 0 s only advertise."""
        for _ in range(max(round(seconds * SECOND / GPS_NS), 0 if seconds else 1)):
            self.stamp_ns += GPS_NS if seconds else 0
            now = self.stamp_ns
            for step in reversed(range(GPS_STEPS)):
                self._send("imu/data_raw", imu(now - step * GPS_NS // GPS_STEPS), seconds)
            self._send("gps/fix", fix(now), seconds)
            self._send("gps/vel", velocity(now), seconds)
            self._send("mag", mag(now), seconds)
            self._send("gps/satellites", UInt32(data=9), seconds)
            self._send("date/verdict", verdict(now), seconds)
            self._send("fusion/verdict", told(now, alert=alert), seconds)
            self._send("hijack_alert", Bool(data=alert), seconds)

    def _send(self, topic: str, message: Any, seconds: float) -> None:
        key = topic, type(message)
        if key not in self._publishers:
            qos = STATE if topic == "hijack_alert" else INTERNAL
            name = f"{self.space}/{topic}"
            self._publishers[key] = self.graph.node.create_publisher(type(message), name, qos)
        if seconds:
            self._publishers[key].publish(message)

    def start_again(self) -> None:
        """Start after a kill, and publish until it hears: subscriptions of the dead still count."""
        # Rarely the middleware never connects the test to a process that follows on a killed one.
        # What is tested are files, so another process is started then, in another place.
        for _ in range(3):
            (before,) = self.select("SELECT max(id) FROM sessions")
            self.graph.take_place()
            self.start()
            if self._heard_after(before):
                return
            assert self.node.interrupt() == 0
        pytest.fail(f"three recorders after a kill heard nothing; the last:\n{self.node.output}")

    def _heard_after(self, session: tuple[int]) -> bool:
        """Publish until a newer session has a row; whether one comes within 30 s."""
        deadline = time.monotonic() + 30.0  # a killed participant is forgotten after 20 s only

        def heard() -> bool:
            self.stamp_ns += GPS_NS
            self._send("fusion/verdict", told(self.stamp_ns, alert=False), GPS_NS)
            return self.select("SELECT coalesce(max(session), 0) FROM alerts") > [session]

        self.graph.spin_until(
            lambda: heard() or time.monotonic() > deadline, "the deadline", timeout_s=60.0
        )
        return heard()

    def publisher(self, topic: str) -> Any:
        """The publisher of a topic of the flight."""
        return next(one for (name, _), one in self._publishers.items() if name == topic)

    def acknowledged(self) -> bool:
        """Whether the recorder has acknowledged everything; never while a dead one is known."""
        return all(one.wait_for_all_acked(NOW) for one in self._publishers.values())

    def until_paths(self, count: int) -> list[Path]:
        self.graph.spin_until(lambda: len(self.paths.messages) >= count, f"{count} snapshots")
        return [Path(one.data) for one in self.paths.messages]

    def until_rows(self, table: str, count: int) -> None:
        """Wait until so many rows are committed."""
        self.graph.spin_until(
            lambda: self.select(f"SELECT count(*) FROM {table}") == [(count,)],
            f"{count} {table}",
        )

    def select(self, statement: str) -> list[tuple[Any, ...]]:
        path = self.folder / "journal.sqlite3"
        with closing(sqlite3.connect(path.as_uri() + "?mode=ro", uri=True)) as database:
            return database.execute(statement).fetchall()

    def status(self) -> DiagnosticStatus | None:
        """The newest status of the recorder."""
        name = f"{self.space}/recorder: recorder"
        found = [s for m in self.diagnostics.messages for s in m.status if s.name == name]
        return found[-1] if found else None

    def until_level(self, level: bytes, text: str = "") -> DiagnosticStatus:
        def there() -> bool:
            one = self.status()
            return one is not None and one.level == level and text in one.message

        self.graph.spin_until(there, f"level {level!r} with {text!r}")
        status = self.status()
        assert status is not None
        return status
