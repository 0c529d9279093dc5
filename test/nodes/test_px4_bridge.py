# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node px4_bridge between a PX4 and the monitor, with real px4_msgs over DDS."""

from __future__ import annotations

import itertools
import math
import time
from collections import Counter
from pathlib import Path
from typing import Any

import px4_vehicle
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import QuaternionStamped, TwistStamped
from live import SECOND, assert_same, offline, stamp_ns, values_of
from px4_vehicle import Vehicle
from px4_workspace import workspace
from rclpy.serialization import serialize_message
from ros import ROOT, Graph, Listener
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, NavSatFix
from std_msgs.msg import UInt32
from test_security import allowed, held

from hijack_detect.bags.reader import BagReader
from hijack_detect.evaluation.monitor.graph import DETECTORS, Monitor
from hijack_detect.evaluation.monitor.offline import (
    FlightNotes,
    OfflineRun,
    run_samples,
    spoofed_samples,
)
from hijack_detect.evaluation.monitor.policies import policy_parameters
from hijack_detect.nodes.messages import verdict_message
from hijack_detect.nodes.running import EXIT_BAD_INPUT
from hijack_detect.spoofing.scenario import load_scenario
from hijack_detect.streams.samples import Sample

BAG = ROOT / "bags/curved_8"
SCENARIO = ROOT / "config/scenarios/turn_away.yaml"
AHEAD = 3
"""So many fixes the vehicle is ahead of the monitor: best effort keeps little on its way."""
ALIGNED_NS = SECOND
BOOT_US = 37_500_000
NEAR_NS = SECOND // 2
Flight = list[tuple[str, Sample]]
OUTPUTS = {
    "imu": (Imu, "imu/data_raw"),
    "fix": (NavSatFix, "gps/fix"),
    "velocity": (TwistStamped, "gps/vel"),
    "satellites": (UInt32, "gps/satellites"),
    "mag": (MagneticField, "mag"),
    "pressure": (FluidPressure, "pressure"),
}


def said(told: Listener, space: str, topic: str) -> tuple[str, dict[str, str]]:
    """The newest that a bridge says of a topic on /diagnostics: sentence and values."""
    name = f"{space}/px4_bridge: {space}/fmu/out/{topic}"
    found = [one for array in told.messages for one in array.status if one.name == name]
    return (found[-1].message, values_of(found[-1])) if found else ("", {})


class Ride:
    """One PX4 in a namespace, its bridge, the monitor behind it, and what that says."""

    def __init__(self, graph: Graph, space: str, flight: Flight, boot_us: int | None) -> None:
        self.space, self.flight = space, flight
        self.from_ns = 0 if boot_us is None else flight[0][1].stamp_ns - boot_us * 1000
        self.sent = px4_vehicle.messages(flight, self.from_ns)
        self.vehicle = Vehicle(graph, space)
        replay = (ROOT / "config/replay.yaml").read_text()
        file = Path(graph.home.name, f"{space.strip('/')}.yaml")
        file.write_text(replay.replace("      /", f"      {space}/"))
        files = ["--params-file", str(ROOT / "config/default.yaml"), "--params-file", str(file)]
        place = ("-r", f"__ns:={space}")
        self.nodes = [
            graph.start("px4_bridge", *place),
            graph.start("all", *place, *files, "-p", "monitor:publish_rate:=0.0"),
        ]
        self.fixes = graph.listen(NavSatFix, f"{space}/gps/fix")
        self.courses = graph.listen(QuaternionStamped, f"{space}/gps/course")
        self.verdicts = {
            name: graph.listen(DiagnosticArray, f"{space}/{name}/verdict")
            for name in (*DETECTORS, "fusion")
        }

    def ready(self, graph: Graph, told: Listener) -> bool:
        """Whether all know each other."""
        inputs = [f"{self.space}/{topic}" for _, topic in OUTPUTS.values()]
        return (
            self.vehicle.met()
            and all(map(graph.node.count_subscribers, inputs))
            and all(one.get("publishers") == "1" for one in self.said(told))
        )

    def said(self, told: Listener) -> list[dict[str, str]]:
        """What the bridge says of each topic."""
        topics = (topic for topic, _ in px4_vehicle.TOPICS.values())
        return [said(told, self.space, topic)[1] for topic in topics]

    def received(self, told: Listener) -> dict[str, int]:
        """How many messages of each topic the bridge has."""
        counts = (int(one.get("received", 0)) for one in self.said(told))
        return dict(zip(px4_vehicle.TOPICS, counts, strict=True))

    def behind(self, fixes: int) -> int:
        """How many of the fixes that were sent the monitor has not used; it gets none at first."""
        aligning = 5 if self.from_ns else 0
        return fixes - aligning - len(self.courses.messages)

    def shift_ns(self) -> int:
        """How far all stamps are moved."""
        times = [us * 1000 for name, us, _ in self.sent if name == "fix"]
        stamps = [stamp_ns(one) for one in self.fixes.messages]
        used = times[len(times) - len(stamps) :]
        moved = {ours - theirs for ours, theirs in zip(stamps, used, strict=True)}
        assert len(moved) == 1, "nothing was lost, and the spacing of the stamps is PX4's"
        return moved.pop() - self.from_ns

    def expected(self, shift_ns: int) -> OfflineRun:
        """What the monitor says offline of what it has to hear."""
        first_ns = self.flight[0][1].stamp_ns + (ALIGNED_NS if self.from_ns else 0)
        kept = [one for one in self.flight if one[1].stamp_ns >= first_ns]
        samples = px4_vehicle.heard(kept, shift_ns)
        run = OfflineRun(samples[0][1].stamp_ns)
        return run_samples(samples, Monitor(policy_parameters("default")), run)


@pytest.mark.slow
def test_a_flight_over_px4_msgs_gives_the_same_verdicts(graph: Graph) -> None:
    """Two vehicles at once: one whose agent synchronises, and one whose times count from boot."""
    graph.environment = workspace()
    with BagReader(BAG) as reader:
        notes = FlightNotes(reader.start_ns)
        flight = [*spoofed_samples(reader, load_scenario(SCENARIO), notes)]
    rides = [Ride(graph, "/uav1", flight, None), Ride(graph, "/uav2", flight, BOOT_US)]
    told = graph.listen(DiagnosticArray, "/diagnostics")
    graph.spin_until(lambda: all(ride.ready(graph, told) for ride in rides), "all nodes", 60.0)

    fixes = 0

    def followed() -> bool:
        return all(ride.behind(fixes) <= AHEAD for ride in rides)

    for (name, _, synchronised), (_, _, since_boot) in zip(*(r.sent for r in rides), strict=True):
        rides[0].vehicle.send(name, synchronised)
        rides[1].vehicle.send(name, since_boot)
        if name == "fix":
            fixes += 1
            graph.spin_until(followed, "the monitor to follow")
    sent = Counter(name for name, _, _ in rides[0].sent)
    graph.spin_until_quiet()

    direct = first_alert(offline(BAG, "default", SCENARIO))
    for ride in rides:
        shift_ns = ride.shift_ns()
        assert (shift_ns == 0) == (ride.from_ns == 0)
        run = ride.expected(shift_ns)
        for name in DETECTORS:
            heard = ride.verdicts[name].messages
            wanted = [verdict_message(one) for one in run.verdicts[name]]
            assert abs(len(heard) - len(wanted)) <= 1, "the last fix of a flight waits for the next"
            assert_same(name, heard[: len(wanted)], wanted[: len(heard)])
        alert = next(
            one for one in ride.verdicts["fusion"].messages if values_of(one)["alert"] == "true"
        )
        assert stamp_ns(alert) == first_alert(run)
        assert abs(stamp_ns(alert) - shift_ns - direct) < NEAR_NS
        graph.spin_until(lambda ride=ride: ride.received(told) == sent, "a report of all")
        rights = {right for _, right in allowed("px4_bridge", ride.space)}
        assert held(graph, "px4_bridge", ride.space) == rights
        assert all(node.interrupt() == 0 for node in ride.nodes)
    assert "UTC, synchronised by the agent" in rides[0].nodes[0].output
    assert "count from its start" in rides[1].nodes[0].output


def first_alert(run: OfflineRun) -> int:
    return next(one.stamp_ns for one in run.results if one.alert)


class Bridge:
    """A bridge alone, and all that it publishes."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.heard = {name: graph.listen(*output) for name, output in OUTPUTS.items()}
        self.told = graph.listen(DiagnosticArray, "/diagnostics")
        self.node = graph.start("px4_bridge")

    def next(self, name: str) -> Any:
        """Wait for the next message of an output, and take it."""
        messages = self.heard[name].messages
        self.graph.spin_until(lambda: messages, f"a message for {name}")
        return messages.pop(0)

    def until_said(self, topic: str, **values: str) -> str:
        """Wait until /diagnostics has some values of a topic; what is said beside them."""

        def found() -> bool:
            return values.items() <= said(self.told, "", topic)[1].items()

        self.graph.spin_until(found, f"{values} of {topic}")
        return said(self.told, "", topic)[0]


UTC_US = 1_750_000_000_123_456


def combined(time_us: int, x: float = 0.5) -> Any:
    message = px4_vehicle.kind("imu")(timestamp=time_us)
    message.gyro_rad[:] = (x, 0.25, -0.125)
    message.accelerometer_m_s2[:] = (1.0, 2.0, -9.5)
    return message


def position(time_us: int, **fields: Any) -> Any:
    given = {"fix_type": 3, "vel_ned_valid": True, "satellites_used": 17, "eph": 2.0, **fields}
    return px4_vehicle.kind("fix")(
        timestamp=time_us,
        latitude_deg=48.1234567,
        longitude_deg=-11.7654321,
        altitude_ellipsoid_m=520.125,
        altitude_msl_m=472.0,
        vel_n_m_s=3.0,
        vel_e_m_s=4.0,
        vel_d_m_s=-0.5,
        **given,
    )


def xyz(vector: Any) -> tuple[float, float, float]:
    return (vector.x, vector.y, vector.z)


def test_values_versions_and_bad_messages(graph: Graph) -> None:
    graph.environment = workspace()
    bridge = Bridge(graph)
    first = Vehicle(graph, versions={"imu": "", "fix": "_v1"})
    graph.spin_until(first.met, "its subscriptions, of the version too")

    first.send("imu", combined(UTC_US))
    imu = bridge.next("imu")
    assert stamp_ns(imu) == UTC_US * 1000
    assert xyz(imu.angular_velocity) == (0.5, -0.25, 0.125)
    assert xyz(imu.linear_acceleration) == (1.0, -2.0, 9.5)
    assert imu.orientation_covariance[0] == -1.0

    first.send("fix", position(UTC_US + 1))
    fix, velocity = bridge.next("fix"), bridge.next("velocity")
    assert stamp_ns(fix) == stamp_ns(velocity) == (UTC_US + 1) * 1000
    assert (fix.status.status, fix.position_covariance_type) == (0, 1)
    assert (fix.latitude, fix.longitude, fix.altitude) == (48.1234567, -11.7654321, 520.125)
    assert list(fix.position_covariance[::4]) == [4.0, 4.0, 9.0]
    assert xyz(velocity.twist.linear) == (4.0, 3.0, 0.5)
    assert bridge.next("satellites").data == 17
    first.send("fix", position(UTC_US + 2, fix_type=2))
    assert bridge.next("fix").status.status == -1
    first.send("fix", position(UTC_US + 3, vel_ned_valid=False, satellites_used=255))
    assert stamp_ns(bridge.next("fix")) == (UTC_US + 3) * 1000
    assert bridge.next("satellites").data == 17 and not bridge.heard["velocity"].messages

    whole = serialize_message(combined(UTC_US))
    bad: list[Any] = [combined(0), combined(UTC_US, math.nan), combined(UTC_US, 1e6)]
    for message in (*bad, whole[:9], whole[:-8]):
        first.send("imu", message)
    counts = {"left out, bad message": "3", "left out, other px4_msgs": "2"}
    bridge.until_said("sensor_combined", received="6", **counts)
    log = bridge.node.output
    assert "/fmu/out/sensor_combined: message left out: timestamp is 0" in log
    assert " bytes, px4_msgs/msg/SensorCombined here has 52: px4_msgs is of another version" in log
    assert log.count("left out: ") == 3, "told once of each topic and reason"
    bridge.until_said("vehicle_gps_position", **{"left out, bad message": "1"})
    first.send("imu", combined(UTC_US + 4))
    assert stamp_ns(bridge.next("imu")) == (UTC_US + 4) * 1000

    bridge.node.wait_for("no /fmu/out/vehicle_magnetometer: add it to dds_topics.yaml; not needed")
    assert "no /fmu/out/sensor_combined" not in bridge.node.output
    assert "/fmu/out/vehicle_gps_position is /fmu/out/vehicle_gps_position_v1 here" in (
        bridge.node.output
    )
    assert "nobody publishes it" in bridge.until_said("vehicle_air_data", publishers="0")
    second = Vehicle(graph, versions={"mag": "", "pressure": ""})
    graph.spin_until(second.met, "its subscriptions")
    mag = px4_vehicle.kind("mag")(timestamp=UTC_US + 3000, timestamp_sample=UTC_US)
    mag.magnetometer_ga[:] = (0.25, -0.125, 0.5)
    second.send("mag", mag)
    field = bridge.next("mag")
    assert stamp_ns(field) == UTC_US * 1000, "when it was sampled"
    assert xyz(field.magnetic_field) == pytest.approx((0.25e-4, 0.125e-4, -0.5e-4), rel=1e-12)
    second.send("pressure", px4_vehicle.pressure(UTC_US, 95_000.5))
    assert bridge.next("pressure").fluid_pressure == 95_000.5
    assert bridge.until_said("vehicle_air_data", publishers="1", received="1")

    for start_us in (20_000_000, 5_000_000):
        steps = (0, 400_000, 1_000_000, 1_004_000, 1_009_000)
        for step_us in steps:
            first.send("imu", combined(start_us + step_us))
        stamps = [stamp_ns(bridge.next("imu")) for _ in steps[2:]]
        assert [after - before for before, after in itertools.pairwise(stamps)] == [4e6, 5e6]
        assert 0 <= time.time_ns() - stamps[0] < 10 * SECOND
    log = bridge.node.output
    assert "PX4's clock changes from UTC of the agent to start of PX4" in log
    assert "PX4's clock goes back by 16.0 s: it was restarted" in log
    assert bridge.node.interrupt() == 0
    assert "Traceback" not in log and "internal error" not in log


def test_without_px4_msgs_it_ends_with_two_and_says_how_to_get_it(graph: Graph) -> None:
    node = graph.start("px4_bridge")
    assert node.wait() == EXIT_BAD_INPUT
    assert len(node.output.splitlines()) == 1
    assert "git clone -b release/1.16 https://github.com/PX4/px4_msgs" in node.output
