# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node mavlink_bridge, with a real MAVLink peer as its autopilot."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TwistStamped
from live import stamp_ns, values_of
from mavlink_peer import (
    BOOT_US,
    GRAVITY,
    Peer,
    PtyWay,
    Schedule,
    TcpWay,
    UdpWay,
    Way,
    free_port,
    ticks,
)
from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros import ROOT, Graph, RosProcess
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, NavSatFix
from std_msgs.msg import Bool, UInt32

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import read_samples
from hijack_detect.detectors.verdict import State
from hijack_detect.mavlink.clock import SLEW
from hijack_detect.nodes.qos import ALERT
from hijack_detect.nodes.running import EXIT_BAD_INPUT
from hijack_detect.spoofing.scenario import load_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import (
    FixSample,
    ImuSample,
    MagneticSample,
    PressureSample,
    SatelliteSample,
)

SECOND = 1_000_000_000
TOPICS = {
    "imu/data_raw": Imu,
    "gps/fix": NavSatFix,
    "gps/vel": TwistStamped,
    "gps/satellites": UInt32,
    "mag": MagneticField,
    "pressure": FluidPressure,
}
SUBJECT = "/mavlink_bridge: mavlink"
PART_S, ONSET_US = (12.0, 80.0), BOOT_US + 48_000_000
GPS_LATE_US = 150_000
"""A fix is measured so long before it is sent."""


def scaled(name: str) -> Callable[[Any], Schedule]:
    """100 Hz of an IMU in thousandths (27 RAW_IMU, 26 SCALED_IMU), fixes and pressure at 5 Hz."""

    def messages(mavlink: Any) -> Iterator[tuple[int, Any]]:
        make = getattr(mavlink, f"MAVLink_{name}_message")
        for index, at in enumerate(ticks(100, 600.0)):
            time_of = at if name == "raw_imu" else at // 1000
            yield at, make(time_of, 100, -200, -1000, 10, 20, -30, 210, -40, 430)
            if index % 20 == 0:
                place = (481234567, 112345678, 523400)
                own_us = at - GPS_LATE_US
                yield (
                    at,
                    mavlink.MAVLink_gps_raw_int_message(
                        own_us, 3, *place, 120, 65535, 500, 9000, 13
                    ),
                )
                yield at, mavlink.MAVLink_scaled_pressure_message(at // 1000, 953.25, 0.0, 2000)

    return messages


def highres(mavlink: Any) -> Iterator[tuple[int, Any]]:
    """HIGHRES_IMU at 100 Hz, as PX4 sends it: the field and the pressure are new in some only."""
    for index, at in enumerate(ticks(100, 600.0)):
        updated = 0x3F | (0x3C0 if index % 10 == 0 else 0)
        values = (0.5, -1.5, -9.8, 0.01, 0.02, -0.03, 0.21, -0.04, 0.43, 953.25, 0.0, 0.0, 20.0)
        yield at, mavlink.MAVLink_highres_imu_message(at, *values, updated)
        yield at, mavlink.MAVLink_scaled_imu_message(at // 1000, *[1] * 9)
        if index % 20 == 0:
            place = (-481234567, -112345678, -12400)
            gps = (
                at - GPS_LATE_US,
                2 if index % 100 == 0 else 3,
                *place,
                120,
                65535,
                500,
                9000,
                255,
            )
            yield at, mavlink.MAVLink_gps_raw_int_message(*gps)


class Flight:
    """A bridge, its autopilot, and the test as its monitor."""

    def __init__(self, graph: Graph, way: Way, connection: str, peer: dict[str, Any]) -> None:
        self.graph, self.connection = graph, connection
        self.peer = Peer(way, **{"schedule": scaled("scaled_imu"), **peer})
        self.heard = {topic: graph.listen(kind, topic) for topic, kind in TOPICS.items()}
        self.diagnostics = graph.listen(DiagnosticArray, "/diagnostics")
        self.alert = graph.node.create_publisher(Bool, "hijack_alert", ALERT)
        reliable = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
        self.verdict = graph.node.create_publisher(DiagnosticArray, "fusion/verdict", reliable)
        self.node: RosProcess

    def start(self, **parameters: Any) -> None:
        heard = ("hijack_alert", "fusion/verdict")
        self._dead = set.union(*map(self.graph.subscribers, heard))
        given = {"connection": self.connection, **parameters}
        self.node = self.graph.start("mavlink_bridge", parameters=given)

    def until_it_flies(self, count: int = 20) -> None:
        imu = self.heard["imu/data_raw"].messages
        first = len(imu)
        self.graph.spin_until(lambda: len(imu) >= first + count, "an Imu")
        for publisher in (self.alert, self.verdict):
            self.graph.until_subscribed(publisher, dead=self._dead)
        self.graph.until_known("mavlink_bridge")

    def say(self, *, alert: bool, since: str = "123", cause: str = "coast alarm") -> None:
        """Say what the fusion would."""
        self.alert.publish(Bool(data=alert))
        state = State.ALARM if alert else State.NORMAL
        values = {
            "state": state.value,
            "alert": str(alert).lower(),
            "alert_since_ns": since,
            "confidence": "0.9",
            "lost": "",
            "degraded": "",
            "causes": "coast gnss",
        }
        status = DiagnosticStatus(name="fusion", message=cause)
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        self.verdict.publish(DiagnosticArray(status=[status]))

    def told(self, text: str, count: int = 1) -> None:
        self.graph.spin_until(
            lambda: [one for _, one in self.peer.texts()].count(text) >= count, repr(text)
        )

    def until_logged(self, text: str) -> None:
        self.graph.spin_until(lambda: text in self.node.output, repr(text))

    def status(self, text: str) -> DiagnosticStatus:
        """The next status whose text begins so."""
        before = len(self.diagnostics.messages)

        def found() -> list[DiagnosticStatus]:
            new = [one.status[0] for one in self.diagnostics.messages[before:]]
            return [one for one in new if one.name == SUBJECT and one.message.startswith(text)]

        self.graph.spin_until(found, f"the status {text!r}")
        return found()[-1]


Fly = Callable[..., Flight]


@pytest.fixture
def fly(graph: Graph) -> Iterator[Fly]:
    """Start a bridge over UDP, or over another way, with arguments for the peer."""
    with ExitStack() as stack:

        def make(way: Way | None = None, connection: str = "", **peer: Any) -> Flight:
            if way is None:
                port = free_port()
                way, connection = UdpWay(port), f"udpin:127.0.0.1:{port}"
            flight = Flight(graph, way, connection, peer)
            stack.callback(flight.peer.close)
            return flight

        yield make


def off_s(flight: Flight, message: Any, own_us: int) -> float:
    """A stamp less the true time at which the autopilot measured it."""
    wall_less_steady = time.time() - time.monotonic()
    return stamp_ns(message) * 1e-9 - (flight.peer.local_s(own_us) + wall_less_steady)


def assert_steady(stamps: list[int]) -> None:
    """No delay of any message is seen in stamps of 100 Hz.

    The offset of the clocks moves at SLEW at most, of the time between two arrivals: a machine that
    is busy for 0.1 s puts that into one step, and into the sum what it puts there anyway.
    """
    off = sorted(abs(b - a - 10_000_000) for a, b in itertools.pairwise(stamps))
    assert sum(off) <= 2.0 * SLEW * (stamps[-1] - stamps[0])
    assert off[len(off) * 9 // 10] < 50_000
    assert off[-1] < 1_000_000


def test_ardupilot_in_mavlink_1(fly: Fly) -> None:
    flight = fly(schedule=scaled("raw_imu"), v1=True, refused=("HIGHRES_IMU", "SCALED_IMU"))
    flight.start(imu_rate_hz=50.0, gps_rate_hz=4.0)
    flight.until_it_flies(150)
    heard = {topic: listener.messages for topic, listener in flight.heard.items()}
    imu = heard["imu/data_raw"][-1]
    force, rate = imu.linear_acceleration, imu.angular_velocity
    assert (force.x, force.y, force.z) == pytest.approx((0.1 * GRAVITY, 0.2 * GRAVITY, GRAVITY))
    assert (rate.x, rate.y, rate.z) == pytest.approx((0.010, -0.020, 0.030))
    assert (imu.orientation_covariance[0], imu.header.frame_id) == (-1.0, "base_link")
    fix = heard["gps/fix"][-1]
    linear = heard["gps/vel"][-1].twist.linear
    assert (linear.x, linear.y) == pytest.approx((5.0, 0.0), abs=1e-9)
    assert math.isnan(linear.z)
    assert (fix.latitude, fix.longitude, fix.altitude) == pytest.approx(
        (48.1234567, 11.2345678, 523.4)
    )
    assert (fix.status.status, fix.position_covariance_type) == (0, 0), "MAVLink 1 has no accuracy"
    assert heard["gps/satellites"][-1].data == 13
    field = heard["mag"][-1].magnetic_field
    assert (field.x, field.y, field.z) == pytest.approx((210e-7, 40e-7, -430e-7))
    assert heard["pressure"][-1].fluid_pressure == pytest.approx(95_325.0)
    assert_steady([stamp_ns(one) for one in heard["imu/data_raw"]])
    lag = stamp_ns(heard["gps/fix"][-1]) % (SECOND // 5) - stamp_ns(imu) % (SECOND // 100)
    assert abs((lag * 1e-9 + GPS_LATE_US * 1e-6 + 0.001) % 0.01 - 0.001) < 0.001
    imus = [f"{name} 20000" for name in ("HIGHRES_IMU", "SCALED_IMU", "RAW_IMU")]
    assert flight.peer.asked[:5] == [*imus, "GPS_RAW_INT 250000", "SCALED_PRESSURE 250000"]
    (beat, *_) = flight.peer.of("HEARTBEAT")
    assert (beat.type, beat.autopilot) == (18, 8), "an onboard controller, no autopilot"
    assert (beat.get_srcSystem(), beat.get_srcComponent()) == (1, 191)
    assert flight.peer.of("TIMESYNC")[-1].get_msgbuf()[0] == 254, "answers in MAVLink 1"
    values = values_of(flight.status("RAW_IMU is published"))
    assert values["autopilot"] == "1.1"
    assert abs(float(values["imu Hz"]) - 100.0) < 10.0
    assert flight.node.interrupt() == 0
    assert "velocities are horizontal" in flight.node.output
    assert "the IMU is RAW_IMU" in flight.node.output


def test_px4_in_mavlink_2_with_time_synchronised(fly: Fly) -> None:
    flight = fly(schedule=highres, dialect="common", autopilot="PX4", system=7)
    flight.start(own_component=192, command="hold")
    flight.until_it_flies(200)
    heard = {topic: listener.messages for topic, listener in flight.heard.items()}
    imu = heard["imu/data_raw"][-1]
    force, rate = imu.linear_acceleration, imu.angular_velocity
    assert (force.x, force.y, force.z) == pytest.approx((0.5, 1.5, 9.8))
    assert (rate.x, rate.y, rate.z) == pytest.approx((0.01, -0.02, 0.03))
    (*_, fix) = (one for one in heard["gps/fix"] if one.status.status == 0)
    assert (fix.latitude, fix.longitude) == pytest.approx((-48.1234567, -11.2345678))
    assert fix.altitude == pytest.approx(-12.4)
    assert {one.status.status for one in heard["gps/fix"]} == {0, -1}
    assert heard["gps/satellites"] == [], "255 is unknown"
    field = heard["mag"][-1].magnetic_field
    assert (field.x, field.y, field.z) == pytest.approx((21e-6, 4e-6, -43e-6))
    assert heard["pressure"][-1].fluid_pressure == pytest.approx(95_325.0)
    assert len(heard["mag"]) <= len(heard["imu/data_raw"]) / 9
    own_us = round((stamp_ns(imu) * 1e-9 - (time.time() - time.monotonic())) * 1e6)
    first_us = round((flight.peer.local_s(0)) * 1e6)
    since_tick_s = ((own_us - first_us) % 10_000) * 1e-6
    assert min(since_tick_s, 0.01 - since_tick_s) < 0.003, "a tick of the autopilot's clock"
    assert_steady([stamp_ns(one) for one in heard["imu/data_raw"]])
    assert flight.peer.of("HEARTBEAT")[-1].get_srcSystem() == 7
    assert flight.peer.of("HEARTBEAT")[-1].get_srcComponent() == 192
    flight.say(alert=True)
    flight.told("GPS SPOOFED? coast alarm")
    flight.until_logged("mode Hold, sent once, accepted")
    (command,) = flight.peer.commands()
    assert (command.target_system, command.target_component, command.command) == (7, 1, 176)
    assert (command.param1, command.param2, command.param3) == (1.0, 4.0, 3.0)
    assert flight.node.interrupt() == 0
    assert "mode Hold follows a false GPS" in flight.node.output


def test_a_link_that_loses_repeats_and_swaps_and_an_autopilot_that_starts_again(fly: Fly) -> None:
    flight = fly(loss=0.2)
    flight.start()
    flight.until_it_flies(250)
    flight.peer.reboot()
    flight.until_logged("the autopilot was started again")
    flight.until_it_flies(100)
    imu = [stamp_ns(one) for one in flight.heard["imu/data_raw"].messages]
    fixes = [stamp_ns(one) for one in flight.heard["gps/fix"].messages]
    for stamps in (imu, fixes):
        assert all(b > a for a, b in itertools.pairwise(stamps))
    steps = [b - a for a, b in itertools.pairwise(imu)]
    gap = steps.index(max(steps))
    for step in (*steps[:gap], *steps[gap + 1 :]):
        assert abs(step - round(step / 1e7) * 1e7) < 200_000, "no jitter, though some are missing"
    values = values_of(flight.status("SCALED_IMU is published"))
    assert int(values["left out: late or repeated"]) > 5
    assert int(values["messages missing"]) > 20
    assert values["clock began afresh"] == "1"
    assert flight.peer.asked.count("HIGHRES_IMU 10000") >= 2, "asked again after the start"
    assert flight.node.interrupt() == 0
    assert flight.node.output.count("the autopilot was started again") == 1
    assert "Traceback" not in flight.node.output


def test_a_command_is_acknowledged_at_the_third_time_and_is_never_repeated(fly: Fly) -> None:
    flight = fly(results=(None, None, 0, 2))
    flight.start(command="land", ack_timeout_s=0.2, text_period_s=1.0)
    flight.until_it_flies()
    stranger = flight.peer.mavlink.MAVLink(None, srcSystem=9, srcComponent=1)
    denied = flight.peer.mavlink.MAVLink_command_ack_message(21, 2)
    flight.say(alert=False)
    begun = time.monotonic()
    flight.say(alert=True)
    flight.peer.send(denied, stranger)
    flight.told("GPS SPOOFED? coast alarm")
    assert time.monotonic() - begun < 1.0
    flight.until_logged("land, sent 3 times, accepted")
    for count in (2, 3):  # the fusion repeats an alert, and so does the bridge
        flight.say(alert=True)
        flight.told("GPS SPOOFED? coast alarm", count)
    assert [one.confirmation for one in flight.peer.commands()] == [0, 1, 2]
    assert {(one.command, one.target_system) for one in flight.peer.commands()} == {(21, 1)}
    flight.told("hijack monitor silent")
    flight.say(alert=True)
    flight.told("hijack monitor heard")
    flight.say(alert=False)
    flight.told("hijack alert is over")
    assert len(flight.peer.commands()) == 3
    flight.say(alert=True, since="456")
    flight.until_logged("land, sent once, refused: denied")
    told = flight.status("the command failed")
    assert told.level == DiagnosticStatus.ERROR
    assert values_of(told)["command"] == "land, sent once, refused: denied"
    severities = dict((text, severity) for severity, text in flight.peer.texts())
    assert severities["GPS SPOOFED? coast alarm"] == 0
    assert severities["hijack monitor silent"] == 4
    assert len(flight.peer.commands()) == 4
    flight.node.signal(9)
    flight.node.wait()
    flight.start(command="land")
    flight.until_it_flies()
    before = len(flight.peer.texts())
    flight.say(alert=True, since="456")
    flight.graph.spin_until(lambda: len(flight.peer.texts()) > before, "the alert told")
    flight.status("SCALED_IMU is published")
    assert len(flight.peer.commands()) == 4, "it was acted on before the crash"
    assert flight.node.interrupt() == 0


def test_tcp_comes_back_and_a_dry_run_sends_nothing(fly: Fly) -> None:
    way = TcpWay()
    flight = fly(way, f"tcp:127.0.0.1:{way.port}")
    flight.start(command="hold", dry_run=True)
    flight.until_it_flies()
    way.put(b"no MAVLink at all\xfe\x01")
    flight.say(alert=True, cause="a cause that is far too long for the fifty bytes of a text")
    flight.told("GPS SPOOFED? found by coast, gnss")
    flight.until_logged("dry run: mode ALT_HOLD, MAV_CMD 176 (1, 2, 0, 0, 0, 0, 0) is not sent")
    way.cut()
    flight.until_logged("no link: the other side has closed it; it is tried again")
    flight.graph.spin_until(lambda: way.connections >= 2, "the second connection")
    flight.until_it_flies(50)
    flight.peer.quiet = True
    told = flight.status("no heartbeat for")
    assert told.level == DiagnosticStatus.ERROR
    flight.peer.quiet = False
    told = flight.status("the monitor is silent")
    assert told.level == DiagnosticStatus.WARN
    assert "bad: damaged" in values_of(told)
    assert flight.peer.commands() == []
    assert flight.node.interrupt() == 0
    assert flight.node.output.count("the autopilot is lost") == 1


def test_a_serial_port_and_signed_messages(fly: Fly, tmp_path: Path) -> None:
    key = bytes(range(32))
    file = tmp_path / "key"
    file.write_text(key.hex() + "\n")
    way = PtyWay()
    flight = fly(way, way.path, key=key)
    flight.start(signing_key_file=file, command="user_1")
    flight.until_it_flies()
    unsigned = flight.peer.mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    flight.peer.send(flight.peer.mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3), unsigned)
    flight.say(alert=True)
    flight.until_logged("MAV_CMD_USER_1, parameter 1 = 1, sent once, accepted")
    (command,) = flight.peer.commands()
    assert (command.command, command.param1, command.get_signed()) == (31010, 1.0, True)
    refused = "bad: not signed with the key"
    told = [values_of(flight.status("SCALED_IMU is published")).get(refused) for _ in range(2)]
    assert told[-1] == "1", "the first report may have been made before it came"
    assert flight.node.interrupt() == 0


def test_what_cannot_be_used_ends_it_at_the_start(graph: Graph, tmp_path: Path) -> None:
    short = tmp_path / "short"
    short.write_bytes(b"secret")
    cases: list[tuple[dict[str, Any], str]] = [
        ({"connection": "udpin:14550"}, "connection 'udpin:14550' is not understood; give udpin:"),
        ({"connection": "tcp:localhost:0"}, "there is no port 0"),
        ({"command": "explode"}, "parameter 'command' must be one of none, land, rtl, hold"),
        ({"signing_key_file": short}, f"{short}: has 6 bytes; a key is 32 bytes"),
    ]
    started = [(graph.start("mavlink_bridge", parameters=given), said) for given, said in cases]
    for process, said in started:
        assert process.wait() == EXIT_BAD_INPUT
        assert said in process.output
        assert "Traceback" not in process.output


def as_messages(start_s: float, end_s: float) -> Callable[[Any], Schedule]:
    """A part of bags/curved_8, attacked by turn_away, as a PX4 would send it."""

    def messages(mavlink: Any) -> Iterator[tuple[int, Any]]:
        with BagReader(ROOT / "bags/curved_8") as reader:
            start_ns = reader.start_ns
            scenario = load_scenario(ROOT / "config/scenarios/turn_away.yaml")
            spoofer = Spoofer(scenario, start_ns)
            count, field, pressure = 0, (0.0, 0.0, 0.0), 0.0
            for _, sample in read_samples(reader, reader.inputs()):
                flown_ns = sample.stamp_ns - start_ns
                if not start_s * SECOND <= flown_ns <= end_s * SECOND:
                    continue
                at = BOOT_US + flown_ns // 1000 - round(start_s * 1e6)
                updated = 0x3F
                if isinstance(sample, SatelliteSample):
                    count = sample.count
                elif isinstance(sample, MagneticSample):
                    x, y, z = sample.field
                    field = (x * 1e4, -y * 1e4, -z * 1e4)
                elif isinstance(sample, PressureSample):
                    pressure = sample.pressure_pa / 100.0
                elif isinstance(sample, ImuSample):
                    fx, fy, fz = sample.specific_force
                    gx, gy, gz = sample.angular_velocity
                    if pressure:
                        updated, pressure_now, pressure = 0x3FF, pressure, 0.0
                    else:
                        pressure_now = 0.0
                    values = (fx, -fy, -fz, gx, -gy, -gz, *field, pressure_now, 0.0, 0.0, 20.0)
                    yield at, mavlink.MAVLink_highres_imu_message(at, *values, updated)
                elif isinstance(sample, FixSample):
                    fix = spoofer.fix(sample)
                    place = (
                        round(fix.latitude_deg * 1e7),
                        round(fix.longitude_deg * 1e7),
                        round(fix.altitude_m * 1e3),
                    )
                    gps = (at, 3, *place, 100, 100, 0xFFFF, 0xFFFF, count or 10)
                    yield at, mavlink.MAVLink_gps_raw_int_message(*gps)

    return messages


@pytest.mark.slow
def test_a_spoofed_flight_over_mavlink_ends_in_a_landing(fly: Fly) -> None:
    """At three times its speed, the peer's clock included: nothing slows an autopilot down."""
    speed = 3.0
    flight = fly(schedule=lambda _: iter(()), dialect="common", autopilot="PX4", speed=speed)
    monitor = flight.graph.start(
        "all", "--params-file", str(ROOT / "config/default.yaml"), "--params-file",
        str(ROOT / "config/replay.yaml"),
    )  # fmt: skip
    alerts = flight.graph.listen(Bool, "hijack_alert", ALERT)
    verdicts = flight.graph.listen(DiagnosticArray, "fusion/verdict")
    sent = list(as_messages(*PART_S)(flight.peer.mavlink))
    false = {
        (one.lat, one.lon) for at, one in sent if at >= ONSET_US and one.get_type() == "GPS_RAW_INT"
    }
    flight.start(command="land", speed=speed)
    flight.graph.spin_until(lambda: alerts.messages, "the monitor")
    flight.graph.until_known("fusion", "mavlink_bridge")
    flight.until_logged("asked for SCALED_PRESSURE")
    flight.status("no autopilot with heartbeat and IMU")
    flight.peer.play(lambda _: sent)
    flight.graph.spin_until(flight.peer.commands, "a command")
    # A busy machine loses messages of a link over UDP, the first false fix like any other.
    heard = [
        stamp_ns(one)
        for one in flight.heard["gps/fix"].messages
        if (round(one.latitude * 1e7), round(one.longitude * 1e7)) in false
    ]
    assert heard, f"a command before the attack: {flight.peer.texts()}\n{monitor.output}"
    onset_ns = heard[0]

    def since() -> list[int]:
        told = [values_of(one.status[0]) for one in verdicts.messages]
        return [int(one["alert_since_ns"]) for one in told if one["alert"] == "true"]

    flight.graph.spin_until(since, "the verdict")
    since_ns = since()[0]
    assert 0.0 < (since_ns - onset_ns) / SECOND < 5.0, "by the stamps, however busy the machine is"
    flight.until_logged("land, sent once, accepted")
    assert any(text.startswith("GPS SPOOFED? found by ") for _, text in flight.peer.texts())
    assert [one.command for one in flight.peer.commands()] == [21]
    assert flight.node.interrupt() == 0
    assert monitor.interrupt() == 0
