# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A bridge among others on one link: who is believed, who is commanded, and when. No sockets."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_mavlink_alarm import Kept

from hijack_detect.bags.encoding import encode_sample
from hijack_detect.logs.logged import Logged
from hijack_detect.mavlink.bridge import Bridge
from hijack_detect.mavlink.codec import Codec, read_key
from hijack_detect.mavlink.link import LinkLost, Place, open_link, place
from hijack_detect.mavlink.parameters import BridgeParameters

mavlink = pytest.importorskip(
    "pymavlink.dialects.v20.ardupilotmega", reason="the extra mavlink is not installed"
)
MS = 1_000_000
HOME, ELSEWHERE = ("10.0.0.1", 1), ("10.0.0.66", 2)
STATION = 255


class Link:
    """A bridge, time, and whoever sends it something."""

    def __init__(self, **parameters: Any) -> None:
        self.now_ns = 50_000 * MS
        self.said: list[str] = []
        self.readings: list[Logged] = []
        self.received: list[Any] = []
        self._reader = mavlink.MAVLink(None)
        self._senders: dict[tuple[int, int], Any] = {}
        values = {"imu_rate_hz": 0.0, "gps_rate_hz": 0.0, "command": "land", **parameters}
        self.bridge = Bridge(
            BridgeParameters(**values), Codec(191), Kept(), self, lambda: self.now_ns
        )
        self.bridge.connected()

    def send(self, data: bytes, to: Any) -> None:
        self.received += self._reader.parse_buffer(data) or ()

    def publish(self, reading: Logged) -> None:
        self.readings.append(reading)

    def say(self, level: str, text: str) -> None:
        self.said.append(text)

    def put(self, message: Any, system: int = 1, component: int = 1, source: Any = HOME) -> None:
        made = mavlink.MAVLink(None, srcSystem=system, srcComponent=component)
        sender = self._senders.setdefault((system, component), made)
        self.bridge.receive(message.pack(sender), source)
        sender.seq = (sender.seq + 1) % 256

    def beat(self, system: int = 1, kind: int = 2, autopilot: int = 3, source: Any = HOME) -> None:
        self.put(mavlink.MAVLink_heartbeat_message(kind, autopilot, 0, 0, 4, 3), system, 1, source)

    def imu(self, system: int = 1, source: Any = HOME) -> None:
        own_us = self.now_ns // 1000
        message = mavlink.MAVLink_highres_imu_message(own_us, 0, 0, -9.8, *[0.0] * 10, 63)
        self.put(message, system, 1, source)

    def fly(self, seconds: float, system: int = 1, *, imu: bool = True) -> None:
        for tick in range(round(seconds * 50)):
            self.now_ns += 20 * MS
            if tick % 25 == 0:
                self.beat(system)
            if imu:
                self.imu(system)
            self.bridge.tick()

    def commands(self) -> list[Any]:
        return [one for one in self.received if one.get_type() == "COMMAND_LONG"]


def test_only_the_system_with_the_imu_is_used_and_commanded() -> None:
    link = Link()
    link.beat(STATION, kind=mavlink.MAV_TYPE_GCS, autopilot=mavlink.MAV_AUTOPILOT_INVALID)
    link.beat(2)
    link.imu(STATION)
    link.fly(3.0, system=1)
    link.imu(2)
    before = len(link.readings)
    link.imu(2)
    assert len(link.readings) == before
    link.beat(2)
    assert "autopilot 2, component 1 is on the link too, and is ignored" in link.said
    link.bridge.receive_alert(alert=True)
    link.fly(0.5)
    assert [(one.target_system, one.target_component) for one in link.commands()] == [(1, 1)]


def test_an_acknowledgement_counts_only_from_the_autopilot_and_for_this_node() -> None:
    link = Link()
    link.fly(3.0)
    link.bridge.receive_alert(alert=True)
    link.fly(0.4)
    ack = mavlink.MAVLink_command_ack_message
    link.put(ack(21, 0), system=2)
    link.put(ack(21, 0), component=100)
    link.put(ack(21, 0, 0, 0, STATION, 190))
    link.put(ack(20, 0))
    assert "not answered yet" in link.bridge.commander.result
    link.put(ack(21, 0, 0, 0, 1, 191))
    assert link.bridge.commander.result == "land, sent once, accepted"


def test_datagrams_of_another_host_are_ignored_while_the_autopilot_is_heard() -> None:
    link = Link()
    link.fly(3.0)
    before = len(link.readings)
    link.now_ns += 10 * MS
    link.imu(source=ELSEWHERE)
    link.put(mavlink.MAVLink_command_ack_message(21, 0), source=ELSEWHERE)
    assert len(link.readings) == before
    assert link.bridge.ignored["datagrams from elsewhere"] == 2
    for _ in range(200):  # the autopilot is gone, and comes back from another port
        link.now_ns += 20 * MS
        link.bridge.tick()
    link.beat(source=ELSEWHERE)
    for _ in range(5):
        link.now_ns += 10 * MS
        link.imu(source=ELSEWHERE)
    assert len(link.readings) > before


def test_a_wanted_system_is_waited_for() -> None:
    link = Link(target_system=7)
    link.fly(2.0, system=1)
    assert link.bridge.vehicle is None and link.readings == []
    link.fly(2.0, system=7)
    assert link.bridge.vehicle is not None and link.bridge.vehicle.address == (7, 1)


def test_a_command_waits_for_an_autopilot_and_is_dropped_with_its_alert() -> None:
    link = Link()
    link.bridge.receive_alert(alert=True)
    for _ in range(50):
        link.now_ns += 20 * MS
        link.bridge.tick()
    assert link.commands() == []
    link.fly(1.0)
    assert len(link.commands()) == 1
    link = Link(ack_timeout_s=0.2)
    link.fly(3.0)
    link.bridge.receive_alert(alert=True)
    link.fly(0.6)
    link.bridge.receive_alert(alert=False)
    sent = len(link.commands())
    assert 1 <= sent <= 2
    link.fly(2.0)
    assert len(link.commands()) == sent
    assert "withdrawn" in link.bridge.commander.result


def test_no_acknowledgement_ends_after_the_given_attempts() -> None:
    link = Link(ack_timeout_s=0.1, command_attempts=3)
    link.fly(3.0)
    link.bridge.receive_alert(alert=True)
    link.fly(3.0)
    assert [one.confirmation for one in link.commands()] == [0, 1, 2]
    assert "the command land, sent 3 times, not acknowledged" in link.said


def test_an_imu_is_asked_for_until_it_comes() -> None:
    link = Link(imu_rate_hz=100.0)
    link.fly(20.0, imu=False)
    asked = [int(one.param1) for one in link.commands()]
    assert asked[0] == mavlink.MAVLINK_MSG_ID_HIGHRES_IMU
    assert {26, 27, 105} <= set(asked)
    assert asked.count(105) > 4, "again after a while"


def test_the_system_clock_may_be_set_in_flight() -> None:
    link = Link()
    system = [1_790_000_000_000 * MS]
    link.bridge = Bridge(
        BridgeParameters(command="none"), Codec(191), Kept(), link,
        lambda: link.now_ns, lambda: system[0] + link.now_ns,
    )  # fmt: skip
    link.fly(2.0)
    system[0] += 3600_000 * MS
    link.fly(2.0)
    stamps = [one.stamp_ns for one in link.readings if one.name == "imu"]
    assert max(b - a for a, b in itertools.pairwise(stamps)) < 25 * MS
    assert link.bridge.system_off_ns == 3600_000 * MS


@given(
    st.lists(
        st.tuples(
            st.integers(0, 2**64 - 1),
            st.floats(width=32),
            st.integers(-(2**31), 2**31 - 1),
            st.integers(0, 255),
            st.binary(max_size=40),
        ),
        max_size=12,
    )
)
@settings(max_examples=50, deadline=None)
def test_no_value_and_no_bytes_end_it(rows: list[tuple[int, float, int, int, bytes]]) -> None:
    link = Link()
    link.fly(1.2)
    for own_us, real, whole, byte, data in rows:
        for message in (
            mavlink.MAVLink_highres_imu_message(own_us, *[real] * 13, byte),
            mavlink.MAVLink_gps_raw_int_message(own_us, byte, *[whole] * 3, 0, 0, 0, 0, byte),
            mavlink.MAVLink_system_time_message(own_us, own_us % 2**32),
            mavlink.MAVLink_scaled_pressure_message(own_us % 2**32, real, real, 0),
            mavlink.MAVLink_timesync_message(whole, whole),
            mavlink.MAVLink_command_ack_message(21, byte),
            mavlink.MAVLink_heartbeat_message(byte, byte, byte, byte, byte, byte),
        ):
            link.put(message)
        link.bridge.receive(data, HOME)
        link.bridge.receive_alert(alert=bool(byte % 2))
    link.fly(3.0)
    assert link.bridge.alive
    assert all(encode_sample(one.value) for one in link.readings)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("connection", "expected"),
    [
        ("udp:0.0.0.0:14550", Place("udpin", "0.0.0.0", 14550)),
        ("udpout:localhost:14580", Place("udpout", "localhost", 14580)),
        ("tcp:10.0.0.1:5760", Place("tcp", "10.0.0.1", 5760)),
        ("serial:/dev/ttyACM0:57600", Place("serial", "/dev/ttyACM0", 57600)),
        (
            "/dev/serial/pci-0:14.0-usb-0:1.0",
            Place("serial", "/dev/serial/pci-0:14.0-usb-0:1.0", 921600),
        ),
        ("/dev/ttyAMA0", Place("serial", "/dev/ttyAMA0", 921600)),
    ],
)
def test_connection_strings(connection: str, expected: Place) -> None:
    assert place(connection, 921600) == expected


@pytest.mark.parametrize("connection", ["", "14550", "udp:14550", "http:a:1", "tcp:a:b", "tcp::1"])
def test_what_is_no_connection_string(connection: str) -> None:
    with pytest.raises(ValueError, match="is not understood; give udpin:HOST:PORT"):
        place(connection, 921600)


def test_a_link_that_cannot_be_opened_says_which_and_why(tmp_path: Path) -> None:
    for where in (Place("serial", str(tmp_path / "tty"), 9600), Place("tcp", "127.0.0.1", 1)):
        with pytest.raises(LinkLost, match=where.name):
            open_link(where)


def test_keys(tmp_path: Path) -> None:
    file = tmp_path / "key"
    for content in (bytes(range(32)), bytes(range(32)).hex().encode() + b"\n"):
        file.write_bytes(content)
        assert read_key(str(file)) == bytes(range(32))
    with pytest.raises(ValueError, match="No such file"):
        read_key(str(tmp_path / "none"))
