# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Both directions of a link, put together: no threads, no ROS, no waiting.

Times are nanoseconds of a steady clock.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from typing import Any, Protocol

from hijack_detect.contract import Level
from hijack_detect.logs import mavlink as readings
from hijack_detect.logs.logged import Logged
from hijack_detect.mavlink.alarm import Alarm, Memory, Text
from hijack_detect.mavlink.clock import AutopilotClock
from hijack_detect.mavlink.codec import Codec
from hijack_detect.mavlink.commands import Commander, Order
from hijack_detect.mavlink.inputs import KINDS, RANKS, Inputs
from hijack_detect.mavlink.link import Address
from hijack_detect.mavlink.parameters import BridgeParameters
from hijack_detect.mavlink.vehicle import ADDRESS, Rates, Search, Vehicle, address_of
from hijack_detect.streams.samples import NANOSECONDS

HEARTBEAT_NS = NANOSECONDS
"""Period of HEARTBEAT: 1 Hz, as the MAVLink heartbeat protocol asks for."""
WIRE_VERSION = 3
"""`mavlink_version` of a HEARTBEAT."""
SYNC_NS, FIRST_SYNCS, FIRST_SYNC_NS = NANOSECONDS, 10, NANOSECONDS // 10
"""Period of TIMESYNC, and the number and period of the first ones. Chosen: AutopilotClock uses
30 s of them, and needs FIRST for a stamp."""
SILENT_NS = 3 * NANOSECONDS
"""Silence after which an autopilot (heartbeat) or its IMU is lost. Chosen: two heartbeats are
missing."""
ASK_NS = 5 * NANOSECONDS
"""Period of requests while there is no IMU. Chosen, not swept; a request lasts 2 s."""


class Outside(Protocol):
    """What a bridge does to the world."""

    def send(self, data: bytes, to: Address) -> None:
        """Send bytes over the link, if there is one."""

    def publish(self, reading: Logged) -> None:
        """Publish a reading."""

    def say(self, level: Level, text: str) -> None:
        """Write a log line."""


class Bridge:
    """Takes bytes and alerts, gives readings and bytes."""

    def __init__(
        self,
        parameters: BridgeParameters,
        codec: Codec,
        memory: Memory,
        outside: Outside,
        now_ns: Callable[[], int],
        system_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        """Begin; `now_ns` is the steady clock, `system_ns` that of stamps."""
        self._parameters, self._codec, self._outside = parameters, codec, outside
        self._now, self._system = now_ns, system_ns
        self.clock = AutopilotClock(parameters.speed)
        self.inputs = Inputs(
            self.clock, lambda text: self._log("info", text), self._system_less_local_ns
        )
        self.alarm = Alarm(memory, round(parameters.text_period_s * NANOSECONDS), now_ns())
        self.search = Search(parameters.target_system, codec.mavlink)
        self.commander = Commander(parameters, codec.mavlink, outside.say)
        self.ignored: Counter[str] = Counter()
        self._rates = Rates(parameters.imu_rate_hz, parameters.gps_rate_hz, codec.mavlink)
        self._ask_ns, self._asked = 0, set[str]()
        self._epoch = 0
        self._alive = False
        self._sent: Text | None = None
        self._to: Address = None
        self._heartbeat_ns = self._sync_ns = 0
        self._syncs = 0
        codec.send_as(parameters.own_system or parameters.target_system or 1)

    @property
    def vehicle(self) -> Vehicle | None:
        """The autopilot, once it is found."""
        return self.search.found

    @property
    def alive(self) -> bool:
        """Whether heartbeat and IMU of the autopilot arrive."""
        return self._alive

    @property
    def system_off_ns(self) -> int:
        """How far the clock of the system is ahead of the stamps, if it was set meanwhile."""
        return self._system_less_local_ns() - self.inputs.shift_ns

    def _system_less_local_ns(self) -> int:
        return self._system() - self.clock.local_ns(self._now())

    def connected(self) -> None:
        """A link was opened, or opened again."""
        self._codec.restart()
        self._heartbeat_ns = self._sync_ns = self._syncs = 0
        self._to = None
        self._rates.restart()

    def receive(self, data: bytes, source: Address) -> None:
        """Take bytes from the link."""
        if self._alive and source != self._to:
            self.ignored["datagrams from elsewhere"] += 1
            return
        for message in self._codec.parse(data):
            self._take(message, source)

    def receive_alert(self, *, alert: bool) -> None:
        """Take a message of the monitor: whether there is an alert."""
        now_ns = self._now()
        if not alert and self.alarm.on:
            self.commander.withdraw()
        self._send_texts(self.alarm.update(now_ns, alert=alert))
        self.tick()

    def tick(self) -> None:
        """Send and log everything that is due."""
        now_ns = self._now()
        self._watch(now_ns)
        texts, act = self.alarm.due(now_ns)
        self._send_texts(texts)
        if act:
            self._act()
        vehicle = self.vehicle
        if vehicle is not None and now_ns - vehicle.heartbeat_ns <= SILENT_NS:
            for order, confirmation in self.commander.due(now_ns):
                self._command(vehicle.address, order, confirmation)
        self._ask(now_ns)
        if now_ns - self._heartbeat_ns >= HEARTBEAT_NS or not self._heartbeat_ns:
            self._heartbeat_ns = now_ns
            self._heartbeat()
        first = self._syncs < FIRST_SYNCS
        if vehicle and now_ns - self._sync_ns >= (FIRST_SYNC_NS if first else SYNC_NS):
            self._sync_ns, self._syncs = now_ns, self._syncs + 1
            self._send("timesync", 0, self.clock.request(now_ns))

    def _ask(self, now_ns: int) -> None:
        """Ask for messages; again while there is no IMU."""
        likely = self.search.likely
        if likely is None:
            return
        if not self._alive and not self._rates.busy and now_ns >= self._ask_ns:
            self._rates.restart()
        if (wanted := self._rates.due(now_ns)) is not None:
            self._ask_ns = now_ns + ASK_NS
            self._command(likely, *wanted)
        if (news := self._rates.news()) and news not in self._asked:
            self._asked.add(news)
            self._log("info", f"asked for {news}")

    def _take(self, message: Any, source: Address) -> None:
        now_ns, kind = self._now(), message.get_type()
        if kind == "HEARTBEAT":
            if source is not None and self.vehicle is None:
                self._to = source
            other = self.search.heartbeat(message, now_ns)
            if other is not None:
                self._ignore(f"autopilot {other[0]}, component {other[1]}")
        elif kind in RANKS and self.search.imu(message):
            self._found(message)
        vehicle = self.vehicle
        if kind == "COMMAND_ACK" and vehicle is None and address_of(message) == self.search.likely:
            self._rates.acknowledge(message.command, message.result, now_ns)
        if vehicle is None or address_of(message) != vehicle.address:
            if address_of(message) != self.search.likely:
                self.ignored["messages of others"] += 1
            return
        vehicle.count(message.get_seq())
        self._to = source
        self._codec.speak(message)
        if kind in KINDS:
            raw = vehicle.kind.autopilot == self._codec.mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
            for reading in self.inputs.take(message, now_ns, raw_is_scaled=raw):
                self._outside.publish(reading)
        elif kind == "TIMESYNC" and message.tc1:
            self.clock.answer(message.tc1, message.ts1, now_ns)
        elif kind == "COMMAND_ACK" and self._is_for_us(message):
            self._rates.acknowledge(message.command, message.result, now_ns)
            self.commander.acknowledge(message.command, message.result, now_ns)
        if self.clock.epoch != self._epoch:
            self._restart()

    def _found(self, message: Any) -> None:
        vehicle = self.vehicle
        assert vehicle is not None
        if not self._parameters.own_system:
            self._codec.send_as(vehicle.address[0])
        kind = vehicle.kind
        names = self._codec.mavlink.enums
        autopilot, frame = (
            names[group][value].name if value in names[group] else str(value)
            for group, value in (("MAV_AUTOPILOT", kind.autopilot), ("MAV_TYPE", kind.vehicle))
        )
        system, component = vehicle.address
        self._log(
            "info", f"the autopilot is system {system}, component {component}: {autopilot}, {frame}"
        )
        self._log("info", readings.NO_CLIMB)
        self.commander.introduce(kind)

    def _restart(self) -> None:
        """The autopilot was started again, or a clock was set."""
        self._epoch, self._syncs = self.clock.epoch, 0
        self._log("warning", f"{self.clock.why}; stamps begin afresh")
        self._rates.restart()

    def _watch(self, now_ns: int) -> None:
        """Log when the autopilot comes and goes."""
        missing = self.missing(now_ns)
        if missing and self._alive:
            self._log("error", f"the autopilot is lost: {missing}")
        elif not missing and not self._alive:
            self._log("info", "the autopilot is heard")
        self._alive = not missing

    def missing(self, now_ns: int) -> str:
        """The missing part of the autopilot; empty for none."""
        vehicle, imu_ns = self.vehicle, self.inputs.received_ns
        if vehicle is None:
            return "no autopilot with heartbeat and IMU is heard"
        if now_ns - vehicle.heartbeat_ns > SILENT_NS:
            return f"no heartbeat for {_seconds(now_ns - vehicle.heartbeat_ns)}"
        if imu_ns is None or not self.clock.ready:
            return "its IMU is not known yet"
        if now_ns - imu_ns > SILENT_NS:
            return f"no {self.inputs.taken} for {_seconds(now_ns - imu_ns)}"
        return ""

    def _act(self) -> None:
        """Command the autopilot, once for an alert, whatever happens then."""
        if not self.commander.wanted:
            return
        try:
            if not self._parameters.dry_run:
                self.alarm.acted()
        except OSError as error:
            self._log("warning", f"a restart of this node could command again: {error}")
        self.commander.begin()

    def _is_for_us(self, message: Any) -> bool:
        """Whether a COMMAND_ACK answers this node; MAVLink 1 has no target in it."""
        system, component = self._codec.own
        return message.target_system in (0, system) and message.target_component in (0, component)

    def _send_texts(self, texts: list[Text]) -> None:
        for one in texts:
            self._outside.send(self._codec.text(one.severity, one.text), self._to)
            if one != self._sent:  # not each repetition
                self._log("info", f"told the ground station: {one.text}")
            self._sent = one

    def _command(self, target: ADDRESS, order: Order, confirmation: int) -> None:
        self._send("command_long", *target, order.command, confirmation, *order.params)

    def _heartbeat(self) -> None:
        mavlink = self._codec.mavlink
        kind = (mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID)
        self._send("heartbeat", *kind, 0, 0, mavlink.MAV_STATE_ACTIVE, WIRE_VERSION)

    def _send(self, name: str, *fields: Any) -> None:
        self._outside.send(self._codec.pack(name, *fields), self._to)

    def _ignore(self, sender: str) -> None:
        text = f"heartbeats of {sender}"
        self.ignored[text] += 1
        if self.ignored[text] == 1:
            self._log("warning", f"{sender} is on the link too, and is ignored")

    def _log(self, level: Level, text: str) -> None:
        self._outside.say(level, text)


def _seconds(nanoseconds: int) -> str:
    return f"{nanoseconds / NANOSECONDS:.1f} s"
