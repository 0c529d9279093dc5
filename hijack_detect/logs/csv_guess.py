# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The map of CSV files whose columns are known: those that pyulog's `ulog2csv` writes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hijack_detect.logs.csv_map import ColumnMap
from hijack_detect.logs.csv_table import Form, named_columns
from hijack_detect.logs.px4 import IN_DEGREES
from hijack_detect.logs.units import FIX_3D

IMU = "sensor_combined"
GPS = ("vehicle_gps_position", "sensor_gps")
TIMED = "timestamp"


def known_map(folder: Path) -> ColumnMap | None:
    """The map of a folder that `ulog2csv` has written, None if it is another.

    Raises:
        BagError: A file of it cannot be read.
    """
    imu = _file(folder, IMU)
    gps = next((found for name in GPS if (found := _file(folder, name))), None)
    if imu is None or gps is None:
        return None
    names = named_columns(gps, Form())[0]
    if not {TIMED, "fix_type", "eph"} <= set(names):
        return None
    inputs: dict[str, Any] = {
        "imu": {
            "file": imu.name,
            "gyro": {"columns": _three("gyro_rad[{}]"), "unit": "rad/s"},
            "accel": {"columns": _three("accelerometer_m_s2[{}]"), "unit": "m/s2"},
            "frame": "FRD",
        },
        "fix": {"file": gps.name, **_place(names), "has_fix": _FIX},
        "velocity": {
            "file": gps.name,
            "axes": {"columns": [f"vel_{axis}_m_s" for axis in "ned"], "unit": "m/s"},
            "frame": "NED",
        },
        "satellites": {"file": gps.name, "column": "satellites_used"},
    }
    field = {"columns": _three("magnetometer_ga[{}]"), "unit": "gauss"}
    turn = {"quaternion": [f"q[{number}]" for number in range(4)]}
    more: dict[str, tuple[str, dict[str, Any]]] = {
        "mag": ("vehicle_magnetometer", {"field": field, "frame": "FRD"}),
        "pressure": (
            "vehicle_air_data",
            {"pressure": {"column": "baro_pressure_pa", "unit": "Pa"}},
        ),
        "attitude": ("vehicle_attitude", turn),
    }
    for name, (topic, given) in more.items():
        if (file := _file(folder, topic)) is not None:
            inputs[name] = {"file": file.name, **given}
    return ColumnMap.model_validate({"time": {"column": TIMED, "unit": "us"}, "inputs": inputs})


_FIX = {"column": "fix_type", "at_least": float(FIX_3D)}


def _file(folder: Path, topic: str) -> Path | None:
    """The table of the first instance of a topic: LOG_TOPIC_0.csv; None if it is not one."""
    found = sorted(folder.glob(f"*_{topic}_0.csv"))
    return found[0] if len(found) == 1 else None


def _three(name: str) -> list[str]:
    return [name.format(axis) for axis in range(3)]


def _place(names: list[str]) -> dict[str, Any]:
    accuracy = {"column": "eph", "unit": "m"}
    if IN_DEGREES in names:
        columns, units = (IN_DEGREES, "longitude_deg", "altitude_ellipsoid_m"), ("deg", "m")
    else:
        columns, units = ("lat", "lon", "alt_ellipsoid"), ("1e-7 deg", "mm")
    return {
        "latitude": {"column": columns[0], "unit": units[0]},
        "longitude": {"column": columns[1], "unit": units[0]},
        "altitude": {"column": columns[2], "unit": units[1]},
        "accuracy": accuracy,
    }
