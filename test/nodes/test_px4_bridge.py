# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The node px4_bridge alone: values, versions, clocks, bad messages, and no px4_msgs."""

from __future__ import annotations

import itertools
import math
import os
import shutil
import time
from pathlib import Path
from typing import Any

import px4_vehicle
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from live import SECOND, stamp_ns
from px4_vehicle import OUTPUTS, Vehicle, said
from px4_workspace import workspace
from rclpy.serialization import serialize_message
from ros import ROOT, Graph

from hijack_detect.nodes.running import EXIT_BAD_INPUT

UTC_US = 1_750_000_000_123_456


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
    graph.spin_until(lambda: first.heard(bridge.told), "its subscriptions, of the version too")

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
    assert list(fix.position_covariance[::4]) == [4.0, 4.0, 0.0]  # no epv
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
    bridge.until_said("sensor_combined", **{"left out, other px4_msgs": "2"})
    log = bridge.node.output
    assert "/fmu/out/sensor_combined: message left out: timestamp is 0" in log
    assert " bytes, px4_msgs/msg/SensorCombined here has 52: px4_msgs is of another version" in log
    assert log.count("left out: ") == 3, "told once of each topic and reason"
    first.send("imu", combined(UTC_US + 4))
    assert stamp_ns(bridge.next("imu")) == (UTC_US + 4) * 1000

    bridge.node.wait_for("no /fmu/out/vehicle_magnetometer: add it to dds_topics.yaml; not needed")
    assert "no /fmu/out/sensor_combined" not in bridge.node.output
    assert "/fmu/out/vehicle_gps_position is /fmu/out/vehicle_gps_position_v1 here" in (
        bridge.node.output
    )
    assert "nobody publishes it" in bridge.until_said("vehicle_air_data", publishers="0")
    served = px4_vehicle.subscribers(bridge.told, "")
    assert set(served.values()) == {1} and "/gps/fix" in served, "this test alone subscribes"
    second = Vehicle(graph, versions={"mag": "", "pressure": ""})
    graph.spin_until(lambda: second.heard(bridge.told), "its subscriptions")
    mag = px4_vehicle.kind("mag")(timestamp=UTC_US + 3000, timestamp_sample=UTC_US)
    mag.magnetometer_ga[:] = (0.25, -0.125, 0.5)
    second.send("mag", mag)
    field = bridge.next("mag")
    assert stamp_ns(field) == UTC_US * 1000, "when it was sampled"
    assert xyz(field.magnetic_field) == pytest.approx((0.25e-4, 0.125e-4, -0.5e-4), rel=1e-12)
    second.send("pressure", px4_vehicle.pressure(UTC_US, 95_000.5))
    assert bridge.next("pressure").fluid_pressure == 95_000.5
    assert bridge.until_said("vehicle_air_data", publishers="1")

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


def test_px4_msgs_that_cannot_be_loaded_is_told(graph: Graph, tmp_path: Path) -> None:
    """As one that was built for another ROS."""
    prefix = Path(workspace()["AMENT_PREFIX_PATH"].split(os.pathsep)[0])
    shutil.copytree(prefix / "lib", tmp_path / "lib")
    for library in (tmp_path / "lib").glob("lib*.so"):
        library.unlink()
    packages = next((tmp_path / "lib").glob("python3*/site-packages"))
    graph.environment = {"PYTHONPATH": f"{ROOT}{os.pathsep}{packages}"}
    node = graph.start("px4_bridge")
    assert node.wait() == EXIT_BAD_INPUT
    (line,) = node.output.splitlines()
    assert "px4_bridge cannot load px4_msgs/msg/SensorCombined (" in line
    assert "build px4_msgs again" in line
