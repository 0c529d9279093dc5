# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Small logs of every format, of one still vehicle that looks North."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

SECONDS = 5
IMU_HZ, GPS_HZ = 50, 5
UTC_US = 1_700_000_000_000_000
GYRO, FORCE = (0.01, 0.02, 0.03), (0.1, -0.2, -9.8)
"""FRD: at rest the specific force points up, which is negative."""
PLACE = (48.0, 11.0, 500.0)
VELOCITY_NED = (1.0, 2.0, -0.5)
FIELD_MILLIGAUSS = (200.0, 10.0, 430.0)
PASCAL = 95_000.0
PX4 = {
    f"px4_msgs/msg/{path.stem}": path.read_text()
    for path in sorted((Path(__file__).parents[1] / "px4_msgs").glob("*.msg"))
}
"""Definitions of px4_msgs as of PX4 1.15, by type."""


def ticks(hz: int) -> range:
    """Microseconds since the start, from one second on."""
    return range(1_000_000, (SECONDS + 1) * 1_000_000, 1_000_000 // hz)


def ulog(path: Path) -> Path:
    """A PX4 ULog, with a message of an undeclared id."""

    def message(kind: bytes, content: bytes) -> bytes:
        return struct.pack("<Hc", len(content), kind) + content

    formats = {
        "sensor_combined": "uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;",
        "vehicle_gps_position": "uint64_t timestamp;uint64_t time_utc_usec;double latitude_deg;"
        "double longitude_deg;double altitude_ellipsoid_m;float eph;float vel_n_m_s;"
        "float vel_e_m_s;float vel_d_m_s;uint8_t fix_type;bool vel_ned_valid;"
        "uint8_t satellites_used;",
        "vehicle_magnetometer": "uint64_t timestamp;float[3] magnetometer_ga;",
        "vehicle_air_data": "uint64_t timestamp;float baro_pressure_pa;",
        "vehicle_attitude": "uint64_t timestamp;float[4] q;",
    }
    data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)
    data += message(b"B", bytes(40))
    for name, fields in formats.items():
        data += message(b"F", f"{name}:{fields}".encode())
    for number, name in enumerate(formats):
        data += message(b"A", struct.pack("<BH", 0, number) + name.encode())
    for at in ticks(IMU_HZ):
        data += message(b"D", struct.pack("<HQ6f", 0, at, *GYRO, *FORCE))
    for at in ticks(GPS_HZ):
        gps = (at, UTC_US + at, *PLACE, 1.5, *VELOCITY_NED, 3, True, 12)
        data += message(b"D", struct.pack("<HQQ3d4fB?B", 1, *gps))
        field = (one * 1e-3 for one in FIELD_MILLIGAUSS)
        data += message(b"D", struct.pack("<HQ3f", 2, at, *field))
        data += message(b"D", struct.pack("<HQf", 3, at, PASCAL))
        data += message(b"D", struct.pack("<HQ4f", 4, at, 1.0, 0.0, 0.0, 0.0))
    data += message(b"D", struct.pack("<HQ", 99, 0))
    path.write_bytes(data)
    return path


def dataflash(path: Path) -> Path:
    """An ArduPilot log as text, with two IMUs."""
    lines = [
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
        "FMT, 129, 40, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ",
        "FMT, 130, 50, GPS, QBBIHBLLffff, TimeUS,I,Status,GMS,GWk,NSats,Lat,Lng,Alt,Spd,GCrs,VZ",
        "FMT, 131, 30, MAG, QBhhh, TimeUS,I,MagX,MagY,MagZ",
        "FMT, 132, 20, BARO, QBf, TimeUS,I,Press",
        "FMT, 133, 20, ATT, Qccc, TimeUS,Roll,Pitch,Yaw",
    ]
    north, east, down = VELOCITY_NED
    course = np.degrees(np.arctan2(east, north))
    for at in ticks(IMU_HZ):
        for number, more in ((0, 0.0), (1, 1.0)):
            gyro = ", ".join(f"{one + more}" for one in GYRO)
            lines.append(f"IMU, {at}, {number}, {gyro}, {', '.join(map(str, FORCE))}")
        if at % (1_000_000 // GPS_HZ):
            continue
        speed = np.hypot(north, east)
        place = ", ".join(map(str, PLACE))
        lines.append(f"GPS, {at}, 0, 3, {at // 1000}, 2288, 12, {place}, {speed}, {course}, {down}")
        lines.append(f"MAG, {at}, 0, {', '.join(f'{one:.0f}' for one in FIELD_MILLIGAUSS)}")
        lines.append(f"BARO, {at}, 0, {PASCAL}")
        lines.append(f"ATT, {at}, 0.0, 0.0, 0.0")
    path.write_text("\n".join(lines) + "\n")
    return path


def tlog(path: Path) -> Path:
    """A telemetry log of an ArduPilot, with heartbeats of a ground station in between."""
    from pymavlink.dialects.v20 import ardupilotmega as mavlink  # noqa: PLC0415  slow to load

    autopilot, station = (mavlink.MAVLink(None, srcSystem=system) for system in (1, 255))
    data = b""

    def add(at: int, sender: Any, message: Any) -> None:
        nonlocal data
        data += struct.pack(">Q", UTC_US + at) + message.pack(sender)

    gravity = 9.80665e-3
    for at in ticks(IMU_HZ):
        force = (round(one / gravity) for one in FORCE)
        gyro = (round(one * 1e3) for one in GYRO)
        field = (round(one) for one in FIELD_MILLIGAUSS)
        add(at, autopilot, mavlink.MAVLink_raw_imu_message(at, *force, *gyro, *field))
        if at % (1_000_000 // GPS_HZ):
            continue
        latitude, longitude, height = PLACE
        place = (round(latitude * 1e7), round(longitude * 1e7), round(height * 1e3))
        add(at, autopilot, mavlink.MAVLink_gps_raw_int_message(at, 3, *place, 120, 65535, 5, 0, 12))
        press = mavlink.MAVLink_scaled_pressure_message(at // 1000, PASCAL / 100.0, 0.0, 2000)
        add(at, autopilot, press)
        add(at, autopilot, mavlink.MAVLink_attitude_message(at // 1000, *[0.0] * 6))
        add(at, station, mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))
    path.write_bytes(data)
    return path


def ros1(path: Path) -> Path:
    """A ROS 1 bag with a mavros-like Imu and NavSatFix, and a topic that is no input."""
    store = get_typestore(Stores.ROS1_NOETIC)
    with Ros1Writer(path) as writer:
        _standard(writer, store, store.serialize_ros1, ros1=True)
    return path


def sqlite(path: Path) -> Path:
    """A rosbag2 in sqlite3 with the same."""
    store = get_typestore(Stores.ROS2_JAZZY)
    with Ros2Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        _standard(writer, store, store.serialize_cdr, ros1=False)
    return path


def _standard(writer: Any, store: Any, serialize: Any, *, ros1: bool) -> None:
    types = store.types

    def header(at: int) -> Any:
        stamp = types["builtin_interfaces/msg/Time"](*divmod(UTC_US + at, 1_000_000))
        stamp.nanosec *= 1000
        sequence = {"seq": 0} if ros1 else {}
        return types["std_msgs/msg/Header"](stamp=stamp, frame_id="", **sequence)

    vector, zeros = types["geometry_msgs/msg/Vector3"], np.zeros(9)
    x, y, z = GYRO
    fx, fy, fz = FORCE
    made: dict[str, tuple[str, int, Any]] = {
        "/a/imu": (
            "sensor_msgs/msg/Imu",
            IMU_HZ,
            lambda at: types["sensor_msgs/msg/Imu"](
                header(at),
                types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
                zeros,
                vector(x, -y, -z),
                zeros,
                vector(fx, -fy, -fz),
                zeros,
            ),
        ),
        "/a/fix": (
            "sensor_msgs/msg/NavSatFix",
            GPS_HZ,
            lambda at: types["sensor_msgs/msg/NavSatFix"](
                header(at), types["sensor_msgs/msg/NavSatStatus"](0, 1), *PLACE, zeros, 0
            ),
        ),
        "/a/words": ("std_msgs/msg/String", 1, lambda at: types["std_msgs/msg/String"]("hello")),
    }
    for topic, (kind, hz, make) in made.items():
        connection = writer.add_connection(topic, kind, typestore=store)
        for at in ticks(hz):
            writer.write(connection, (UTC_US + at) * 1000, serialize(make(at), kind))


COLUMNS = """\
time: {column: t, unit: us, since: utc}
inputs:
  imu:
    gyro: {columns: [gx, gy, gz], unit: rad/s}
    accel: {columns: [ax, ay, az], unit: m/s2}
    frame: FRD
  fix:
    latitude: {column: lat, unit: deg}
    longitude: {column: lon, unit: deg}
    altitude: {column: alt, unit: m}
    has_fix: {column: type, at_least: 3}
  velocity:
    axes: {columns: [vn, ve, vd], unit: m/s}
    frame: NED
  satellites: {column: sats}
"""
"""Meaning of the columns of `table`."""


def table(path: Path) -> Path:
    """A CSV, the GPS of which has its columns in every tenth row."""
    lines = ["t,gx,gy,gz,ax,ay,az,lat,lon,alt,type,vn,ve,vd,sats"]
    for at in ticks(IMU_HZ):
        gps: tuple[float, ...] = (*PLACE, 3, *VELOCITY_NED, 12)
        shown = map(str, gps) if at % (1_000_000 // GPS_HZ) == 0 else [""] * len(gps)
        lines.append(",".join((str(UTC_US + at), *map(str, (*GYRO, *FORCE)), *shown)))
    path.write_text("\n".join(lines) + "\n")
    return path


def px4(path: Path) -> Path:
    """A rosbag2 in sqlite3 with messages of px4_msgs, whose definitions are in the bag."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for kind, text in PX4.items():
        store.register(get_types_from_msg(text, kind))
    with Ros2Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:

        def put(topic: str, kind: str, hz: int, **fields: Any) -> None:
            msgtype = f"px4_msgs/msg/{kind}"
            outlet = writer.add_connection(f"/fmu/out/{topic}", msgtype, typestore=store)
            for at in ticks(hz):
                message = _zeros(store, msgtype)
                for name, value in {"timestamp": UTC_US + at, **fields}.items():
                    setattr(message, name, value)
                writer.write(
                    outlet, message.timestamp * 1000, store.serialize_cdr(message, msgtype)
                )

        gyro, force = (np.array(one, np.float32) for one in (GYRO, FORCE))
        put("sensor_combined", "SensorCombined", IMU_HZ, gyro_rad=gyro, accelerometer_m_s2=force)
        names = ("latitude_deg", "longitude_deg", "altitude_ellipsoid_m")
        velocity = zip(("vel_n_m_s", "vel_e_m_s", "vel_d_m_s"), VELOCITY_NED, strict=True)
        more = {"fix_type": 3, "eph": 1.5, "vel_ned_valid": True, "satellites_used": 12}
        place = dict(zip(names, PLACE, strict=True))
        put("vehicle_gps_position", "SensorGps", GPS_HZ, **place, **dict(velocity), **more)
        field = np.array(FIELD_MILLIGAUSS, np.float32) * np.float32(1e-3)
        put("vehicle_magnetometer", "VehicleMagnetometer", GPS_HZ, magnetometer_ga=field)
        put("vehicle_air_data", "VehicleAirData", GPS_HZ, baro_pressure_pa=PASCAL)
    return path


def _zeros(store: Any, msgtype: str) -> Any:
    """A message of numbers and arrays of numbers, all of them zero."""
    values = {
        name: np.zeros(of[1], np.float32) if node == Nodetype.ARRAY else 0
        for name, (node, of) in store.fielddefs[msgtype][1]
    }
    return store.types[msgtype](**values)
