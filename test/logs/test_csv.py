# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Tables of a flight in many units say what its bag says; and what is wrong with one is told."""

from __future__ import annotations

import csv
import dataclasses
import math
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import pytest
import yaml
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from ros import ROOT

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import read_samples
from hijack_detect.cli.main import main
from hijack_detect.logs import csv_units
from hijack_detect.logs.csv_map import load_map
from hijack_detect.logs.formats import Converted, convert
from hijack_detect.logs.logged import ATTITUDE
from hijack_detect.streams.samples import Sample
from stress.fuzz import small_logs

Samples = dict[str, list[Any]]
SMALL = """\
time: {column: t, unit: s, since: utc}
inputs:
  imu:
    gyro: {columns: [gx, gy, gz], unit: rad/s}
    accel: {columns: [ax, ay, az], unit: m/s2}
    frame: FLU
  fix:
    latitude: {column: lat, unit: deg}
    longitude: {column: lon, unit: deg}
    altitude: {column: alt, unit: m}
"""
NAMES = "t,gx,gy,gz,ax,ay,az,lat,lon,alt"
GOOD = "1,0,0,0,0,0,9.8,48,11,500"


def samples(bag: Path, upto_s: float = math.inf) -> Samples:
    found: Samples = {}
    with BagReader(bag) as reader:
        for name, sample in read_samples(reader, reader.inputs()):
            if (sample.stamp_ns - reader.start_ns) / 1e9 <= upto_s:
                found.setdefault(name, []).append(sample)
    return found


@pytest.fixture(scope="module")
def flown() -> Samples:
    """Half a minute, and an accuracy that some fixes have."""
    found = samples(ROOT / "bags/curved_8", 30.0)
    for at in range(0, len(found["fix"]), 2):
        found["fix"][at] = dataclasses.replace(found["fix"][at], accuracy_m=1.25)
    found["satellites"].pop()  # a number is read with the fix that follows
    return found


def small(folder: Path, *lines: str, text: str = SMALL) -> tuple[Path, Path]:
    """A table of a few lines, and its map."""
    table, columns = folder / "flight.csv", folder / "map.yaml"
    table.write_text("\n".join((NAMES, *lines)) + "\n")
    columns.write_text(text)
    return table, columns


def imported(folder: Path, *lines: str, text: str = SMALL) -> Converted:
    table, columns = small(folder, *lines, text=text)
    return convert(table, folder / "out", None, load_map(columns))


def refused(folder: Path, *lines: str, text: str = SMALL) -> str:
    with pytest.raises(BagError) as error:
        imported(folder, *lines, text=text)
    return str(error.value)


SI = {
    "time": ("ns", 1), "gyro": "rad/s", "accel": "m/s2", "field": "T", "pressure": "Pa",
    "speed": "m/s", "height": "m", "place": "deg", "frame": "FLU", "world": "ENU",
}  # fmt: skip
TELEMETRY = {
    "time": ("us", 1000), "gyro": "deg/s", "accel": "g", "field": "mgauss", "pressure": "hPa",
    "speed": "cm/s", "height": "mm", "place": "deg", "frame": "FRD", "world": "NED",
}  # fmt: skip
COMMA = {
    "time": ("iso", 1), "gyro": "mrad/s", "accel": "mg", "field": "uT", "pressure": "mbar",
    "speed": "km/h", "height": "ft", "place": "rad", "frame": "FRD", "world": "polar",
    "delimiter": ";", "decimal": ",",
}  # fmt: skip


def time_text(stamp_ns: int, unit: str, divisor: int) -> str:
    if unit != "iso":
        whole, rest = divmod(stamp_ns, divisor)
        return f"{whole}.{rest:0{len(str(divisor)) - 1}d}" if divisor > 1 else str(whole)
    at = datetime.fromtimestamp(stamp_ns // 10**9, timezone.utc)
    return f"{at:%Y-%m-%dT%H:%M:%S}.{stamp_ns % 10**9:09d}Z"


def as_table(flown: Samples, units: dict[str, Any], folder: Path) -> tuple[Path, Path]:
    """A table with a row for each sample, and its map."""
    body = (1, -1, -1) if units["frame"] == "FRD" else (1, 1, 1)
    decimal, delimiter = units.get("decimal", "."), units.get("delimiter", ",")

    def written(values: Any, scale: float) -> list[str]:
        return ["" if one is None else repr(one / scale).replace(".", decimal) for one in values]

    def turned(vector: Any) -> list[float]:
        return [one * sign for one, sign in zip(vector, body, strict=True)]

    def moved(velocity: Any) -> list[str]:
        east, north, up = velocity
        scale = csv_units.SPEED[units["speed"]]
        if units["world"] == "polar":
            course = repr(math.degrees(math.atan2(east, north)) % 360.0).replace(".", decimal)
            speed, climb = written((math.hypot(east, north), up), scale)
            return [speed, course, climb]
        return written((east, north, up) if units["world"] == "ENU" else (north, east, -up), scale)

    rows: list[tuple[int, dict[str, str]]] = []
    for one in flown["imu"]:
        gyro = written(turned(one.angular_velocity), csv_units.RATE[units["gyro"]])
        force = written(turned(one.specific_force), csv_units.FORCE[units["accel"]])
        rows.append((one.stamp_ns, dict(zip(NAMES.split(",")[1:7], gyro + force, strict=True))))
    for one in flown["fix"]:
        place = (one.latitude_deg, one.longitude_deg)
        lat, lon = written(place, csv_units.PLACE[units["place"]])
        alt, acc = written((one.altitude_m, one.accuracy_m), csv_units.LENGTH[units["height"]])
        fix = {"lat": lat, "lon": lon, "alt": alt, "acc": acc, "type": "3"}
        rows.append((one.stamp_ns, fix))
    for one in flown["velocity"]:
        rows.append((one.stamp_ns, dict(zip(("v1", "v2", "v3"), moved(one.velocity), strict=True))))
    for one in flown["satellites"]:
        rows.append((one.stamp_ns, {"sats": str(one.count)}))
    for one in flown["mag"]:
        field = written(turned(one.field), csv_units.FIELD[units["field"]])
        rows.append((one.stamp_ns, dict(zip(("mx", "my", "mz"), field, strict=True))))
    for one in flown["pressure"]:
        pascal = written((one.pressure_pa,), csv_units.PRESSURE[units["pressure"]])
        rows.append((one.stamp_ns, {"p": pascal[0]}))
    names = [*NAMES.split(","), "acc", "type", "v1", "v2", "v3", "sats", "mx", "my", "mz", "p"]
    table = folder / "flight.csv"
    with table.open("w", newline="") as file:
        file.write("# a comment before the header\n")
        writer = csv.DictWriter(file, names, delimiter=delimiter, restval="")
        writer.writeheader()
        for stamp_ns, row in sorted(rows, key=lambda one: one[0]):
            writer.writerow({"t": time_text(stamp_ns, *units["time"]), **row})
    speed = {"unit": units["speed"]}
    polar = {
        "speed": {"column": "v1", **speed},
        "course": {"column": "v2", "unit": "deg"},
        "climb": {"column": "v3", **speed},
    }
    axes = {"axes": {"columns": ["v1", "v2", "v3"], **speed}, "frame": units["world"]}
    height = {"unit": units["height"]}
    columns = {
        "delimiter": delimiter,
        "decimal": decimal,
        "time": {"column": "t", "unit": units["time"][0], "since": "utc"},
        "inputs": {
            "imu": {
                "gyro": {"columns": ["gx", "gy", "gz"], "unit": units["gyro"]},
                "accel": {"columns": ["ax", "ay", "az"], "unit": units["accel"]},
                "frame": units["frame"],
            },
            "fix": {
                "latitude": {"column": "lat", "unit": units["place"]},
                "longitude": {"column": "lon", "unit": units["place"]},
                "altitude": {"column": "alt", **height},
                "accuracy": {"column": "acc", **height},
                "has_fix": {"column": "type", "at_least": 3},
            },
            "velocity": polar if units["world"] == "polar" else axes,
            "satellites": {"column": "sats"},
            "mag": {
                "field": {"columns": ["mx", "my", "mz"], "unit": units["field"]},
                "frame": units["frame"],
            },
            "pressure": {"pressure": {"column": "p", "unit": units["pressure"]}},
        },
    }
    path = folder / "map.yaml"
    path.write_text(yaml.safe_dump(columns))
    return table, path


def numbers(sample: Sample) -> list[float]:
    found: list[float] = []
    for name in sample.__slots__:  # type: ignore[union-attr]
        value = getattr(sample, name)
        if name != "stamp_ns":
            found += value if isinstance(value, tuple) else [-1.0 if value is None else value]
    return found


@pytest.mark.parametrize("units", [SI, TELEMETRY, COMMA], ids=["si", "telemetry", "comma"])
def test_the_same_samples_in_any_units(flown: Samples, units: Any, tmp_path: Path) -> None:
    table, columns = as_table(flown, units, tmp_path)
    convert(table, tmp_path / "out", None, load_map(columns))
    found = samples(tmp_path / "out")
    assert {name: len(of) for name, of in found.items()} == {
        name: len(of) for name, of in flown.items()
    }
    for name, of in flown.items():
        for one, theirs in zip(found[name], of, strict=True):
            assert one.stamp_ns == theirs.stamp_ns
            assert numbers(one) == pytest.approx(numbers(theirs), rel=1e-12, abs=1e-12)
            if units is SI and name != "satellites":
                assert one == theirs


def test_the_same_alerts_as_the_bag(tmp_path: Path) -> None:
    flight = samples(ROOT / "bags/curved_8", 60.0)
    table, columns = as_table(flight, TELEMETRY, tmp_path)
    scenario = tmp_path / "jump.yaml"
    scenario.write_text(
        "segments:\n  - {start: 40.0, model: {type: jump, distance_m: 60.0, bearing_deg: 90.0}}\n"
    )
    alerts = []
    runner = CliRunner()
    for bag, more in ((ROOT / "bags/curved_8", []), (table, ["--columns", str(columns)])):
        out = tmp_path / f"{bag.name}.json"
        attack = ["--scenario", str(scenario), "--json", str(out)]
        done = runner.invoke(main, ["analyze", str(bag), *attack, *more])
        assert done.exit_code == 10, done.output
        first = yaml.safe_load(out.read_text())["alerts"][0]
        alerts.append({key: first[key] for key in first if "stamp" in key or key == "causes"})
    assert alerts[0] == alerts[1]


def test_one_file_for_each_sensor_and_several_rates(tmp_path: Path) -> None:
    text = SMALL.replace("  imu:\n", "  imu:\n    file: imu.csv\n").replace(
        "  fix:\n", "  fix:\n    file: gps.csv\n    time: {column: ms, unit: ms, since: utc}\n"
    )
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs/imu.csv").write_text("t,gx,gy,gz,ax,ay,az\n1,0,0,0,0,0,9.8\n3,0,0,0,0,0,9\n")
    (tmp_path / "logs/gps.csv").write_text("ms,lat,lon,alt\n2000,48,11,500\n")
    (tmp_path / "map.yaml").write_text(text)
    columns = load_map(tmp_path / "map.yaml")
    convert(tmp_path / "logs", tmp_path / "out", None, columns)
    with BagReader(tmp_path / "out") as reader:
        order = [(name, one.stamp_ns) for name, one in read_samples(reader, reader.inputs())]
    assert order == [("imu", 10**9), ("fix", 2 * 10**9), ("imu", 3 * 10**9)]
    (tmp_path / "logs/gps.csv").unlink()
    with pytest.raises(BagError, match=r"gps\.csv: is not there; inputs\.fix of the map names it"):
        convert(tmp_path / "logs", tmp_path / "out2", None, columns)


def test_a_slow_sensor_in_the_rows_of_a_fast_one(tmp_path: Path) -> None:
    rows = [f"{1 + at / 10},0,0,0,0,0,{9 + at / 100},{48 + at // 5},11,500" for at in range(20)]
    done = imported(tmp_path, *rows)
    assert done.messages["/gps/fix"] == 20
    (tmp_path / "changed").mkdir()
    text = f"{SMALL}    when_changed: true\n"
    done = imported(tmp_path / "changed", *rows, text=text)
    assert (done.messages["/gps/fix"], done.messages["/imu/data_raw"]) == (4, 20)
    assert "flight.csv: fix: rows that repeat the one before (16)" in done.notes.lines()
    own = text.replace("  fix:\n", "  fix:\n    time: {column: alt, unit: s, since: utc}\n")
    rows = [f"{1 + at / 10},0,0,0,0,0,9.8,48,11,{500 + at // 10}" for at in range(20)]
    (tmp_path / "own").mkdir()
    assert imported(tmp_path / "own", *rows, text=own).messages["/gps/fix"] == 2


@pytest.mark.parametrize(
    ("kind", "at_least", "fixes"),
    [("3,2,0", 3, [True, False, False]), ("true,False,yes", 1, [True, False, True])],
)
def test_without_a_fix_there_is_no_place(
    kind: str, at_least: int, fixes: list[bool], tmp_path: Path
) -> None:
    table, columns = small(
        tmp_path,
        text=f"{SMALL}    has_fix: {{column: fix, at_least: {at_least}}}\n",
    )
    rows = [f"{at},0,0,0,0,0,9.8,{48 if at == 1 else ''},11,500,{one}" for at, one in
            enumerate(kind.split(","), start=1)]  # fmt: skip
    if fixes[2]:
        rows[2] = rows[2].replace(",,", ",48,")
    table.write_text("\n".join((f"{NAMES},fix", *rows, "9,,,,,,,,,,")))
    convert(table, tmp_path / "out", None, load_map(columns))
    assert [one.has_fix for one in samples(tmp_path / "out")["fix"]] == fixes


def test_bad_rows_are_skipped_and_counted(tmp_path: Path) -> None:
    bad = ("2,nan,0,0,0,0,9.8,48,11,500", "x,0,0,0,0,0,9.8,48,11,500", "4,0,0,0,0,0,9.8,480,11,1")
    done = imported(tmp_path, GOOD, "", *bad, "# said", "3,0,0,0,0,0,9.8,,,", "2,0,0,0,0,0,9,,,")
    assert (done.messages["/imu/data_raw"], done.messages["/gps/fix"]) == (4, 2)
    said = done.notes.lines()
    assert any("imu: column gx: bad rows, first line 4, column gx: 'nan'" in one for one in said)
    assert any("fix: column t: bad rows, first line 5, column t: 'x' is no" in one for one in said)
    assert any("latitude would be 480 deg, beyond -90 to 90" in one for one in said)
    assert any("goes backwards 2 times, first in line 8, by 1 s" in one for one in said)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["1,a,0,0,0,0,9.8,48,11,500"], "reading of imu: all are bad: line 2, column gx: 'a' is"),
        (["1,0,0,0,0,0,9.8,,,"], "no row gives a reading of fix: its columns are empty"),
        (["1,0,0,0,0,0,9800,48,11,500"], "accel would be 9800 m/s2, beyond -1000 to 1000: are uni"),
        (["1764000000000,0,0,0,0,0,9.8,48,11,500"], "is no time that a stamp can have: is its uni"),
        (['1,0,0,0,0,0,9,"4,8",11,500'], "'4,8' is no number: is the decimal a comma?"),
        ([], "its columns are empty in every row"),
    ],
)
def test_when_all_is_bad_the_first_is_named(lines: list[str], said: str, tmp_path: Path) -> None:
    message = refused(tmp_path, *lines)
    assert message.startswith(str(tmp_path / "flight.csv"))
    assert said in message
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("unit: rad/s", "unit: rpm", "inputs.imu.gyro: unit 'rpm' is not known; known are rad/s"),
        ("[gx, gy, gz]", "[gx, gy]", "inputs.imu.gyro.columns: List should have at least 3 items"),
        ("column: alt", "column: y_es", "inputs.fix: has no column 'y_es'; it has t, gx"),
        ("column: alt", "column: yes", "YAML reads this word as true or false: put it in quotes"),
        ("column: alt", "column: 12", "inputs.fix: has no column 12"),
        ("  fix:", "  fixx:", "inputs.fixx: is no key of a map here"),
        ("frame: FLU", "frame: flu", "inputs.imu.frame: Input should be 'FLU' or 'FRD'"),
        ("time: {column: t, unit: s, since: utc}\n", "", "inputs.imu has no time"),
        ("time:", "delimiter: ','\ndecimal: ','\ntime:", "are the same character"),
        ("time:", "header: false\ntime:", "has names, and there is no header"),
        ("time: {", "time: {{", "is no YAML text: line 2"),
    ],
)
def test_what_is_wrong_with_a_map_is_named(old: str, new: str, said: str, tmp_path: Path) -> None:
    assert said in refused(tmp_path, GOOD, text=SMALL.replace(old, new, 1))


def test_columns_by_number_without_a_header(tmp_path: Path) -> None:
    text = SMALL
    for number, name in enumerate(NAMES.split(","), start=1):
        for old in (f"column: {name},", f"[{name},", f" {name},", f" {name}]"):
            text = text.replace(old, old.replace(name, str(number)))
    (tmp_path / "map.yaml").write_text(f"header: false\n{text}")
    (tmp_path / "flight.csv").write_text(f"{GOOD}\n")
    done = convert(tmp_path / "flight.csv", tmp_path / "out", None, load_map(tmp_path / "map.yaml"))
    assert done.messages["/gps/fix"] == 1


def test_encodings_and_names_that_are_there_twice(tmp_path: Path) -> None:
    table, columns = small(tmp_path)
    table.write_text(f"{NAMES},°\n{GOOD},1\n", encoding="latin-1")
    with pytest.raises(BagError, match=r"is no utf-8 text; give its encoding"):
        convert(table, tmp_path / "out", None, load_map(columns))
    columns.write_text(f"encoding: latin-1\n{SMALL}")
    convert(table, tmp_path / "out", None, load_map(columns))
    table.write_text(f"{NAMES},alt\n{GOOD},1\n", encoding="utf-8-sig")
    columns.write_text(SMALL)
    with pytest.raises(BagError, match=r"several columns are called 'alt': give a number \(10, 11"):
        convert(table, tmp_path / "out2", None, load_map(columns))


def test_without_a_map_the_columns_are_told_and_the_template_fits(tmp_path: Path) -> None:
    runner = CliRunner()
    table, columns = small(tmp_path, GOOD)
    for command in (["analyze", str(table)], ["convert", str(table), str(tmp_path / "out")]):
        done = runner.invoke(main, command)
        assert done.exit_code == 2
        assert f"columns {NAMES.replace(',', ', ')}" in done.stderr
        assert f"hijack-detect convert {table} --template > map.yaml" in done.stderr
    table.write_text("timestamp_us;gyro_x;gyro_y;gyro_z;acc_x;acc_y;acc_z;Lat;Lon;Alt\n"
                     "5,5;0,1;0;0;0;0;-9,8;48,5;11;500\n")  # fmt: skip
    done = runner.invoke(main, ["convert", str(table), "--template"])
    assert "#   gyro_x                   0,1" in done.stdout
    assert 'time: {column: "timestamp_us", unit: us, since: boot}' in done.stdout
    assert '"?"' not in done.stdout.split("# velocity")[0].split("inputs:")[1]
    columns.write_text(done.stdout)
    small_logs.table(tmp_path / "short.csv")
    short = runner.invoke(main, ["convert", str(tmp_path / "short.csv"), "--template"]).stdout
    assert 'gyro: {columns: ["gx", "gy", "gz"]' in short
    assert 'accel: {columns: ["ax", "ay", "az"]' in short
    done = runner.invoke(main, ["convert", str(table), str(tmp_path / "bag"), "--columns",
                                str(columns)])  # fmt: skip
    assert done.exit_code == 0, done.output
    found = samples(tmp_path / "bag")
    assert found["imu"][0].specific_force == (0.0, -0.0, 9.8)
    assert found["fix"][0].latitude_deg == 48.5
    done = runner.invoke(main, ["convert", str(tmp_path / "none.csv"), "out", "--columns",
                                str(columns)])  # fmt: skip
    assert "does not exist" in done.stderr


def test_the_map_of_the_page_is_one(tmp_path: Path) -> None:
    page = (ROOT / "docs/analyze-a-log.md").read_text()
    (tmp_path / "map.yaml").write_text(page.split("```yaml\n")[1].split("```")[0])
    given = load_map(tmp_path / "map.yaml").inputs.given()
    assert list(given) == [*("imu", "fix", "velocity", "satellites", "mag", "pressure"), "attitude"]


def test_a_folder_of_ulog2csv_is_known(tmp_path: Path) -> None:
    from pyulog.ulog2csv import convert_ulog2csv  # noqa: PLC0415

    log = small_logs.ulog(tmp_path / "flight.ulg")
    tables = tmp_path / "tables"
    tables.mkdir()
    convert_ulog2csv(str(log), None, str(tables), ",", None, None)
    with pytest.raises(BagError, match=r"one of the files of ulog2csv: name their folder"):
        convert(next(tables.glob("*gps*")), tmp_path / "none")
    done, of_log = convert(tables, tmp_path / "out"), convert(log, tmp_path / "of_log")
    assert done.format == "CSV of ulog2csv"
    assert done.messages == of_log.messages
    assert done.messages[ATTITUDE]
    ours, theirs = samples(tmp_path / "out"), samples(tmp_path / "of_log")
    for name, of in theirs.items():
        for one, other in zip(ours[name], of, strict=True):
            assert numbers(one) == pytest.approx(numbers(other), rel=1e-6, abs=1e-12)


def test_the_attitude_of_a_table(tmp_path: Path) -> None:
    for number, words in enumerate((
        "quaternion: [gx, gy, gz, alt], order: xyzw, frame: FLU to ENU",
        "roll: {column: gx, unit: deg}, pitch: {column: gy, unit: deg}, "
        "yaw: {column: gz, unit: rad}",
    )):  # fmt: skip
        folder = tmp_path / str(number)
        folder.mkdir()
        done = imported(folder, GOOD, text=f"{SMALL}  attitude: {{{words}}}\n")
        assert done.messages[ATTITUDE] == 1
        with BagReader(folder / "out") as reader:
            (raw,) = reader.messages([ATTITUDE])
            q = reader.deserialize(raw).quaternion
        half = math.sqrt(0.5)
        wanted = ((0, 0, 0, 1), (0, 0, half, half))[number]
        assert tuple(map(abs, (q.x, q.y, q.z, q.w))) == pytest.approx(wanted, abs=1e-9)


TABLES = (csv_units.RATE, csv_units.FORCE, csv_units.FIELD, csv_units.PRESSURE, csv_units.SPEED)
KNOWN: dict[str, tuple[Any, float]] = {
    "deg/s": (csv_units.RATE, math.pi / 180), "g": (csv_units.FORCE, 9.80665),
    "gauss": (csv_units.FIELD, 1e-4), "uT": (csv_units.FIELD, 1e-6),
    "mgauss": (csv_units.FIELD, 1e-7), "hPa": (csv_units.PRESSURE, 100.0),
    "mbar": (csv_units.PRESSURE, 100.0), "knots": (csv_units.SPEED, 0.514444444444),
    "km/h": (csv_units.SPEED, 0.277777777778), "ft": (csv_units.LENGTH, 0.3048),
}  # fmt: skip


@pytest.mark.parametrize("unit", KNOWN)
def test_scales_are_those_of_the_books(unit: str) -> None:
    table, scale = KNOWN[unit]
    assert table[unit] == pytest.approx(scale, rel=1e-11)


@given(st.integers(0, csv_units.LAST_NS - 1), st.sampled_from(sorted(csv_units.TIME)))
def test_times_are_exact_to_the_nanosecond(stamp_ns: int, unit: str) -> None:
    power = csv_units.TIME[unit]
    whole, rest = divmod(stamp_ns, 10**power)
    text = f"{whole}.{rest:0{power}d}" if power else str(whole)
    assert csv_units.nanoseconds(text, unit) == stamp_ns
    assert csv_units.nanoseconds(time_text(stamp_ns, "iso", 1), csv_units.ISO) == stamp_ns


@given(st.text(max_size=30), st.sampled_from([*csv_units.TIME, csv_units.ISO]))
def test_any_text_is_a_time_or_refused(text: str, unit: str) -> None:
    try:
        assert 0 <= csv_units.nanoseconds(text, unit) < csv_units.LAST_NS
    except ValueError as error:
        assert str(error).startswith("is no ")


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("1970-01-01T00:00:01Z", 1.0),
        ("1970-01-01 00:00:01.5", 1.5),
        ("1970-01-01T01:00:01,25+01:00", 1.25),
        ("1970-01-02", 86400.0),
    ],
)
def test_times_of_iso_8601(text: str, seconds: float) -> None:
    assert csv_units.nanoseconds(text, "iso") == seconds * 1e9
