# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A column map to fill in, with what the names of a table's columns suggest."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hijack_detect.bags.errors import BagError
from hijack_detect.logs.csv_map import ColumnMap
from hijack_detect.logs.csv_table import Form, decimal_comma, guessed_form, named_columns
from hijack_detect.logs.frames import FIX_3D
from hijack_detect.logs.px4 import IN_DEGREES

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
            "gyro": {"columns": _indexed("gyro_rad[{}]"), "unit": "rad/s"},
            "accel": {"columns": _indexed("accelerometer_m_s2[{}]"), "unit": "m/s2"},
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
    field = {"columns": _indexed("magnetometer_ga[{}]"), "unit": "gauss"}
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


def _indexed(name: str) -> list[str]:
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


UNKNOWN = "?"
WIDTH = 24
SINCE_1970 = ((1e18, "ns"), (1e15, "us"), (1e12, "ms"), (1e9, "s"))
"""From this number on a time counts from 1970, in this unit."""
MICROSECONDS = 1e7
"""From this number on a time since the start is in microseconds. Chosen: 116 days in seconds, ten
seconds in microseconds."""
TEMPLATE = """\
# Which columns of {file} are what.
# Check every line: the columns were guessed from their names, {unknown} was not found. Take out
# the inputs that the table does not have; imu and fix are needed. All keys and units:
# docs/analyze-a-log.md
#
# Columns, and their values in the first row:
{listed}

delimiter: {delimiter}
decimal: "{decimal}"            # or ","
comment: "#"            # lines that begin so are left out
encoding: {encoding}         # or latin-1, utf-16
time: {time}  # s, ms, us, ns or iso; since boot or utc
inputs:
  imu:
    gyro: {gyro}  # deg/s, rad/s, mrad/s
    accel: {accel}  # m/s2, g, mg; at rest it points up
    frame: FRD          # x forward, y right, z down; or FLU: y left, z up
  fix:
    latitude: {latitude}  # deg, 1e-7 deg, rad
    longitude: {longitude}
    altitude: {altitude}  # m, cm, mm, ft
    # accuracy: {{column: eph, unit: m}}
    # has_fix: {{column: fix_type, at_least: 3}}
    # when_changed: true  # the fix is repeated in every row of a faster sensor
  # velocity:            # of the receiver
  #   axes: {velocity}
  #   frame: NED         # or ENU; or in place of both: speed, course and climb
  # satellites: {satellites}
  # mag:
  #   field: {mag}  # T, uT, nT, gauss, mgauss
  #   frame: FRD
  # pressure:
  #   pressure: {pressure}  # Pa, hPa, mbar, kPa
"""


def template(path: Path) -> str:
    """The text of a map for a table; taking the comments off is left to a person.

    Raises:
        BagError: It is no table.
    """
    form = None if path.is_dir() else guessed_form(path)
    if form is None:
        raise BagError(
            f"{path}: does not look like a CSV with a header (three columns or more, separated by "
            "comma, semicolon or tab)"
        )
    names, values = named_columns(path, form)
    shown = zip(names, values, strict=True)
    return TEMPLATE.format(
        file=path.name,
        unknown=UNKNOWN,
        listed="\n".join(f"#   {name:<{WIDTH}} {value.strip()}" for name, value in shown),
        delimiter=json.dumps(form.delimiter),
        decimal="," if decimal_comma(form, values) else ".",
        encoding=form.encoding,
        time=_time(names, values),
        gyro=_three(names, r"gyr|omega|angular|rate|^g(?=[xyz])", "rad/s"),
        accel=_three(names, r"acc|force|^a(?=[xyz])", "m/s2"),
        latitude=_one(names, r"lat(?!e)", "deg"),
        longitude=_one(names, r"lon|lng", "deg"),
        altitude=_one(names, r"alt|height", "m"),
        velocity=_three(names, r"vel|speed|^v", "m/s", (r"n(orth)?", r"e(ast)?", r"d(own)?")),
        satellites=f"{{column: {json.dumps(_found(names, r'sat'))}}}",
        mag=_three(names, r"mag|^m(?=[xyz])", "gauss"),
        pressure=_one(names, r"press|baro", "Pa"),
    )


def advice(path: Path) -> str:
    """The remedy for a table without a column map."""
    if known_map(path.parent) is not None:
        return f"{path}: is one of the files of ulog2csv: name their folder, {path.parent}"
    form = guessed_form(path)
    names = [] if form is None else named_columns(path, form)[0]
    return (
        f"{path}: is a table with the columns {', '.join(names)}. "
        "What they are, a map has to say:\n"
        f"  hijack-detect convert {path} --template > map.yaml    and fill it in, then\n"
        f"  hijack-detect analyze {path} --columns map.yaml"
    )


def _time(names: Sequence[str], values: Sequence[str]) -> str:
    name = _found(names, r"^t$|time|stamp|utc|date")
    text = values[names.index(name)].strip() if name in names else ""
    unit, since = "s", "boot"
    try:
        number = float(text.replace(",", "."))
    except ValueError:
        unit, since = ("iso", "utc") if re.match(r"\d{4}-\d\d-\d\d", text) else (unit, since)
    else:
        ending = re.search(r"(us|usec|ms|ns)$", name.lower().rstrip("])"))
        unit = "us" if number >= MICROSECONDS else unit
        unit = "us" if ending and ending[1] == "usec" else ending[1] if ending else unit
        for least, of in SINCE_1970:
            if number >= least:
                unit, since = of, "utc"
                break
    return f"{{column: {json.dumps(name)}, unit: {unit}, since: {since}}}"


def _one(names: Sequence[str], word: str, unit: str) -> str:
    return f"{{column: {json.dumps(_found(names, word))}, unit: {unit}}}"


def _three(
    names: Sequence[str], word: str, unit: str, axes: Sequence[str] = (r"[x0]", r"[y1]", r"[z2]")
) -> str:
    found = [_found(names, word, axis) for axis in axes]
    return f"{{columns: {json.dumps(found)}, unit: {unit}}}"


def _found(names: Sequence[str], word: str, axis: str = "") -> str:
    """The first column with a word in its name, and an axis beside it; UNKNOWN without one."""
    for name in names:
        text = name.lower()
        part = re.search(word, text)
        letters = rf"(^|[^a-z]|{word}){axis}([^a-z]|$)"
        if part and (not axis or re.search(letters, text)):
            return name
    return UNKNOWN
