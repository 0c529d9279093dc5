# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Bags with px4_msgs in mcap, and with the topics of mavros in every storage."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import read_samples
from hijack_detect.cli.main import main
from hijack_detect.logs.formats import Converted, convert, is_log
from hijack_detect.logs.logged import ATTITUDE, Selection
from stress.fuzz.small_logs import FORCE, GYRO, PLACE, UTC_US, VELOCITY_NED

RATES = "uint64 timestamp\nfloat32[3] gyro_rad\nfloat32[3] accelerometer_m_s2\n"
INCREMENTS = (
    "uint64 timestamp\nuint64 timestamp_sample\nfloat32[3] delta_angle\nfloat32[3] delta_velocity\n"
    "uint32 delta_angle_dt\nuint32 delta_velocity_dt\n"
)
GPS = (
    "uint64 timestamp\nfloat64 latitude_deg\nfloat64 longitude_deg\nfloat64 altitude_ellipsoid_m\n"
    "uint8 fix_type\nfloat32 eph\nfloat32 vel_n_m_s\nfloat32 vel_e_m_s\nfloat32 vel_d_m_s\n"
    "bool vel_ned_valid\nuint8 satellites_used\n"
)
STEPS = range(1_000_000, 3_000_000, 100_000)
Message = tuple[str, str, tuple[Any, ...]]
"""Topic, type of px4_msgs, and fields behind the time."""


def f32(*values: float) -> Any:
    return np.array(values, np.float32)


def px4(path: Path, definitions: dict[str, str], messages: list[Message], storage: Any) -> Path:
    """A bag with the same messages ten times a second, and their definitions."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for kind, text in definitions.items():
        store.register(get_types_from_msg(text, f"px4_msgs/msg/{kind}"))
    with Ros2Writer(path, version=9, storage_plugin=storage) as writer:
        outlets = {
            topic: writer.add_connection(topic, f"px4_msgs/msg/{kind}", typestore=store)
            for topic, kind, _ in messages
        }
        for at in STEPS:
            for topic, kind, fields in messages:
                name = f"px4_msgs/msg/{kind}"
                data = store.serialize_cdr(store.types[name](UTC_US + at, *fields), name)
                writer.write(outlets[topic], (UTC_US + at) * 1000, data)
    return path


def imported(log: Path, wanted: Selection | None = None) -> tuple[Converted, dict[str, list[Any]]]:
    out = log.with_name("out")
    done, found = convert(log, out, wanted), {}
    with BagReader(out) as reader:
        for name, sample in read_samples(reader, reader.inputs()):
            found.setdefault(name, []).append(sample)
    return done, found


@pytest.mark.parametrize("version", ["", "_v1"])
@pytest.mark.parametrize("imu", ["SensorCombined", "VehicleImu"])
@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_px4_msgs(storage: Any, imu: str, version: str, tmp_path: Path) -> None:
    """PX4 1.14 to 1.16 send the first three of these by default."""
    increments = (0, f32(*(0.004 * one for one in GYRO)), f32(*(0.005 * one for one in FORCE)))
    motion: Message = ("/fmu/out/sensor_combined", imu, (f32(*GYRO), f32(*FORCE)))
    if imu == "VehicleImu":
        motion = ("/fmu/out/vehicle_imu", imu, (*increments, 4000, 5000))
    definitions = {
        imu: INCREMENTS if imu == "VehicleImu" else RATES,
        "SensorGps": GPS,
        "VehicleAttitude": "uint64 timestamp\nfloat32[4] q\n",
        "VehicleMagnetometer": "uint64 timestamp\nfloat32[3] magnetometer_ga\n",
        "VehicleAirData": "uint64 timestamp\nfloat32 baro_pressure_pa\n",
        "VehicleStatus": "uint64 timestamp\nuint8 nav_state\n",
    }
    bag = px4(
        tmp_path / "flight",
        definitions,
        [
            motion,
            (
                "/fmu/out/vehicle_gps_position",
                "SensorGps",
                (*PLACE, 3, 1.5, *VELOCITY_NED, True, 9),
            ),
            (f"/fmu/out/vehicle_attitude{version}", "VehicleAttitude", (f32(1, 0, 0, 0),)),
            ("/fmu/out/vehicle_magnetometer", "VehicleMagnetometer", (f32(0.2, 0.1, 0.4),)),
            ("/fmu/out/vehicle_air_data", "VehicleAirData", (95_000.0,)),
            (f"/fmu/out/vehicle_status{version}", "VehicleStatus", (3,)),
        ],
        storage,
    )
    done, found = imported(bag)
    (gx, gy, gz), (fx, fy, fz) = GYRO, FORCE
    first = found["imu"][0]
    assert first.stamp_ns == (UTC_US + 1_000_000) * 1000
    assert first.angular_velocity == pytest.approx((gx, -gy, -gz), rel=1e-5)
    assert first.specific_force == pytest.approx((fx, -fy, -fz), rel=1e-5)
    fix = found["fix"][0]
    assert (fix.latitude_deg, fix.longitude_deg, fix.altitude_m) == PLACE
    assert found["velocity"][0].velocity == (2.0, 1.0, 0.5)
    assert found["mag"][0].field == pytest.approx((2e-5, -1e-5, -4e-5))
    assert found["pressure"][0].pressure_pa == 95_000.0
    assert found["satellites"][0].count == 9
    assert done.messages[ATTITUDE] == len(STEPS)
    assert any(f"/fmu/out/vehicle_status{version}" in one for one in done.notes.skipped)


def test_a_bare_mcap_file_with_px4_msgs_is_analysed(tmp_path: Path) -> None:
    messages: list[Message] = [
        ("/fmu/out/sensor_combined", "SensorCombined", (f32(*GYRO), f32(*FORCE))),
        ("/fmu/out/vehicle_gps_position", "SensorGps", (*PLACE, 3, 1.5, *VELOCITY_NED, True, 9)),
    ]
    definitions = {"SensorCombined": RATES, "SensorGps": GPS}
    bag = px4(tmp_path / "flight", definitions, messages, StoragePlugin.MCAP)
    file = next(bag.glob("*.mcap"))
    done = CliRunner().invoke(main, ["analyze", str(file), "--json", "-"])
    assert done.exit_code in (0, 3, 10), done.output
    assert "imu is /fmu/out/sensor_combined" in done.stderr
    only = px4(tmp_path / "only", {"SensorGps": GPS}, messages[1:], StoragePlugin.MCAP)
    done = CliRunner().invoke(main, ["analyze", str(only)])
    assert done.exit_code == 2
    assert "has no imu number 0; it has /fmu/out/vehicle_gps_position" in done.stderr


def standard(store: Any, spaces: dict[str, float], *, ros1: bool) -> Iterator[Message]:
    """What mavros publishes in some namespaces, at a latitude each: also what it estimates."""
    types = store.types
    vector, zeros = types["geometry_msgs/msg/Vector3"], np.zeros(9)
    for at in STEPS:
        stamp = types["builtin_interfaces/msg/Time"](*divmod(UTC_US + at, 1_000_000))
        stamp.nanosec *= 1000
        header = types["std_msgs/msg/Header"](
            stamp=stamp, frame_id="", **({"seq": 0} if ros1 else {})
        )
        turn = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
        status = types["sensor_msgs/msg/NavSatStatus"](0, 1)
        for space, latitude in spaces.items():
            for name, rate in (("data", 9.0), ("data_raw", 0.5)):
                imu = (header, turn, zeros, vector(rate, 0, 0), zeros, vector(0, 0, 9.8), zeros)
                yield f"{space}/mavros/imu/{name}", "sensor_msgs/msg/Imu", imu
            for name, more in (("global", 1.0), ("raw/fix", 0.0)):
                place = (header, status, latitude + more, 11.0, 500.0, zeros, 0)
                yield f"{space}/mavros/global_position/{name}", "sensor_msgs/msg/NavSatFix", place
            for topic, east in (("global_position/raw/gps_vel", 1.0), ("a/velocity", 5.0)):
                twist = types["geometry_msgs/msg/Twist"](vector(east, 0, 0), vector(0, 0, 0))
                kind = "geometry_msgs/msg/TwistStamped"
                yield f"{space}/mavros/{topic}", kind, (header, twist)
            count = f"{space}/mavros/global_position/raw/satellites"
            yield count, "std_msgs/msg/UInt32", (11,)
            yield f"{space}/mavros/a_number", "std_msgs/msg/UInt32", (99,)


def mavros(path: Path, storage: Any, spaces: dict[str, float]) -> Path:
    """A bag of some vehicles with mavros; `storage` None for ROS 1."""
    ros1 = storage is None
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)
    writer: Any = Ros1Writer(path) if ros1 else Ros2Writer(path, version=9, storage_plugin=storage)
    outlets: dict[str, Any] = {}
    with writer:
        for number, (topic, kind, fields) in enumerate(standard(store, spaces, ros1=ros1)):
            if topic not in outlets:
                outlets[topic] = writer.add_connection(topic, kind, typestore=store)
            message = store.types[kind](*fields)
            data = (store.serialize_ros1 if ros1 else store.serialize_cdr)(message, kind)
            writer.write(outlets[topic], UTC_US * 1000 + number, data)
    return path


@pytest.mark.parametrize("space", ["", "/uav1"])
@pytest.mark.parametrize("storage", [None, StoragePlugin.SQLITE3, StoragePlugin.MCAP])
def test_mavros_measurements_are_taken_and_not_its_estimates(
    storage: Any, space: str, tmp_path: Path
) -> None:
    bag = mavros(tmp_path / ("flight" if storage else "flight.bag"), storage, {space: 48.0})
    if storage is StoragePlugin.MCAP:
        assert not is_log(bag)
        found: dict[str, list[Any]] = {}
        with BagReader(bag) as reader:
            for name, sample in read_samples(reader, reader.inputs()):
                found.setdefault(name, []).append(sample)
    else:
        _, found = imported(bag)
    assert found["imu"][0].angular_velocity[0] == 0.5
    assert found["fix"][0].latitude_deg == 48.0
    assert found["velocity"][0].velocity[0] == 1.0
    assert {one.count for one in found["satellites"]} == {11}


@pytest.mark.parametrize("storage", [None, StoragePlugin.SQLITE3, StoragePlugin.MCAP])
def test_of_several_vehicles_one_is_named(storage: Any, tmp_path: Path) -> None:
    spaces = {"/uav1": 48.0, "/uav12": 12.0, "/uav2": 50.0}
    bag = mavros(tmp_path / ("flight" if storage else "flight.bag"), storage, spaces)
    for name, latitude in (("/uav2", 50.0), ("uav1/", 48.0)):
        _, found = imported(bag, Selection(namespace=name))
        assert {one.latitude_deg for one in found["fix"]} == {latitude}
        (tmp_path / "out").rename(tmp_path / f"out{latitude}")
    with pytest.raises(
        BagError, match=r"has no imu number 0 in the namespace /uav3; it has .*/uav1"
    ):
        imported(bag, Selection(namespace="/uav3"))
    done = CliRunner().invoke(main, ["analyze", str(bag), "--json", str(tmp_path / "a.json")])
    if storage is StoragePlugin.MCAP:
        assert done.exit_code == 2
        assert "`hijack-detect analyze BAG --namespace /uav1`" in done.stderr
    else:
        assert "/uav2/mavros/global_position/raw/fix is left out" in done.stderr
