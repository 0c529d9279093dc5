# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Every format says the same of the same still vehicle."""

from __future__ import annotations

import gc
import random
import subprocess
import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import read_samples
from hijack_detect.cli.analyze import EXIT_NOT_JUDGED
from hijack_detect.logs.dataflash import METRES_PER_HDOP
from hijack_detect.logs.formats import Converted, as_bag, convert, is_log
from hijack_detect.logs.logged import ATTITUDE, Selection
from stress.fuzz import small_logs

pytest.importorskip("pymavlink", reason="the extra logs is not installed")
pytest.importorskip("pyulog", reason="the extra logs is not installed")

FORMATS: dict[str, tuple[Callable[[Path], Path], str]] = {
    "ulog": (small_logs.ulog, "flight.ulg"),
    "dataflash": (small_logs.dataflash, "flight.log"),
    "tlog": (small_logs.tlog, "flight.tlog"),
    "ros1": (small_logs.ros1, "flight.bag"),
    "sqlite": (small_logs.sqlite, "flight"),
    "px4": (small_logs.px4, "flight"),
}
IMUS, FIXES = small_logs.SECONDS * small_logs.IMU_HZ, small_logs.SECONDS * small_logs.GPS_HZ
WITH_UTC = ("ulog", "tlog", "ros1", "sqlite", "px4")


def imported(name: str, folder: Path) -> tuple[Converted, dict[str, list[Any]]]:
    """What was converted, and the samples of the bag by input."""
    make, file = FORMATS[name]
    done = convert(make(folder / file), folder / "out")
    samples: dict[str, list[Any]] = {}
    with BagReader(folder / "out") as reader:
        for one, sample in read_samples(reader, reader.inputs()):
            samples.setdefault(one, []).append(sample)
    return done, samples


@pytest.mark.parametrize("name", FORMATS)
def test_units_frames_and_stamps(name: str, tmp_path: Path) -> None:
    done, samples = imported(name, tmp_path)
    (gx, gy, gz), (fx, fy, fz) = small_logs.GYRO, small_logs.FORCE
    imu = samples["imu"]
    assert len(imu) == IMUS
    coarse = 5e-3 if name == "tlog" else 1e-5  # thousandths of gravity
    assert imu[0].angular_velocity == pytest.approx((gx, -gy, -gz), abs=1e-6)
    assert imu[0].specific_force == pytest.approx((fx, -fy, -fz), abs=coarse)
    assert imu[1].stamp_ns - imu[0].stamp_ns == 10**9 // small_logs.IMU_HZ
    fix = samples["fix"][0]
    assert len(samples["fix"]) == FIXES
    assert (fix.latitude_deg, fix.longitude_deg, fix.altitude_m) == pytest.approx(small_logs.PLACE)
    if name in WITH_UTC:
        assert fix.stamp_ns == (small_logs.UTC_US + 1_000_000) * 1000
    if name in ("ulog", "dataflash", "px4"):
        north, east, down = small_logs.VELOCITY_NED
        wanted = (east, north, -down)
        assert samples["velocity"][0].velocity == pytest.approx(wanted, abs=1e-5)
    if name == "tlog":
        speed = samples["velocity"][0]
        assert speed.velocity[:2] == pytest.approx((0.0, 0.05), abs=1e-9)
        assert not speed.has_vertical
    if name not in ("ros1", "sqlite"):
        assert samples["satellites"][0].count == 12
    if name in ("ulog", "dataflash", "tlog", "px4"):
        x, y, z = (one * 1e-7 for one in small_logs.FIELD_MILLIGAUSS)
        assert samples["mag"][0].field == pytest.approx((x, -y, -z), rel=1e-5)
        assert samples["pressure"][0].pressure_pa == pytest.approx(small_logs.PASCAL)
        assert done.messages[ATTITUDE] == (0 if name == "px4" else FIXES)


def test_what_was_left_out_is_said(tmp_path: Path) -> None:
    for name, said in (
        ("ulog", "no subscription found for message id 99"),
        ("dataflash", "IMU number 1: another one is taken (250)"),
        ("tlog", "velocities are horizontal"),
        ("ros1", "/a/words: std_msgs/msg/String is no input (5)"),
    ):
        folder = tmp_path / name
        folder.mkdir()
        assert any(said in line for line in imported(name, folder)[0].notes.lines())


def test_a_dataflash_with_a_banner_and_without_climb_and_time_of_arrival_is_read(
    tmp_path: Path,
) -> None:
    """As ArduPilot 3.1 wrote it to a terminal; the GPS has the receiver's time only."""
    log = small_logs.dataflash(tmp_path / "flight.log")
    text = log.read_text().replace("GPS, QBBIHBLLffff, TimeUS,I,", "GPS, BIHBLLfff, ")
    text = text.replace(",GMS,GWk,", ",TimeMS,Week,").replace(",GCrs,VZ", ",GCrs")
    down = small_logs.VELOCITY_NED[2]
    lines = [
        ", ".join(["GPS", *line.split(", ")[3:-1]]) if line.endswith(f", {down}") else line
        for line in text.splitlines()
    ]
    log.write_text("\n".join(["ArduCopter V3.1", "", *lines]))
    assert is_log(log)
    convert(log, tmp_path / "out")
    with BagReader(tmp_path / "out") as reader:
        samples = list(read_samples(reader, reader.inputs()))
    velocities = [one for name, one in samples if name == "velocity"]
    imus = {one.stamp_ns for name, one in samples if name == "imu"}
    assert len(velocities) == FIXES
    assert not any(one.has_vertical for one in velocities)  # type: ignore[union-attr]
    assert {one.stamp_ns for one in velocities} <= imus


def test_a_dataflash_of_a_slow_clock_is_corrected(tmp_path: Path) -> None:
    log = small_logs.dataflash(tmp_path / "flight.log")
    lines = log.read_text().splitlines()
    fast = [line for line in lines if line.startswith("FMT")]
    for round_ in range(8):
        for line in lines:
            kind, at, *rest = line.split(", ")
            if kind == "FMT":
                continue
            true_us = int(at) + round_ * small_logs.SECONDS * 1_000_000
            own_us = round(true_us * 12 / 13)
            if kind == "GPS":
                rest[2] = str(true_us // 1000)
            fast.append(", ".join([kind, str(own_us), *rest]))
    log.write_text("\n".join(fast) + "\n")
    done = convert(log, tmp_path / "out")
    assert any("7.7 % slow" in line for line in done.notes.lines())
    with BagReader(tmp_path / "out") as reader:
        stamps = [
            one.stamp_ns for name, one in read_samples(reader, reader.inputs()) if name == "imu"
        ]
    seconds = 8 * small_logs.SECONDS - 1 / small_logs.IMU_HZ
    assert (stamps[-1] - stamps[0]) / 1e9 == pytest.approx(seconds, rel=1e-3)


def test_accuracy_of_a_dataflash_comes_from_gpa_or_hdop(tmp_path: Path) -> None:
    log = small_logs.dataflash(tmp_path / "flight.log")
    text = (
        log.read_text().replace("QBBIHBLLffff", "QBBIHBfLLffff").replace(",NSats,", ",NSats,HDop,")
    )
    text = text.replace(" 2288, 12, ", " 2288, 12, 0.9, ")
    log.write_text(text)
    convert(log, tmp_path / "hdop")
    form = "FMT, 134, 20, GPA, QBffff, TimeUS,I,VDop,HAcc,VAcc,SAcc\n"
    log.write_text(form + text.replace("\nMAG, ", "\nGPA, 1000000, 0, 1.2, 0.7, 1.1, 0.2\nMAG, "))
    convert(log, tmp_path / "gpa")
    found = []
    for name in ("hdop", "gpa"):
        with BagReader(tmp_path / name) as reader:
            fixes = [one for of, one in read_samples(reader, reader.inputs()) if of == "fix"]
        found.append((fixes[1].accuracy_m, fixes[1].vertical_accuracy_m))  # type: ignore[union-attr]
    assert found[0] == (pytest.approx(0.9 * METRES_PER_HDOP), None)
    assert found[1] == pytest.approx((0.7, 1.1))


def test_another_imu_can_be_taken(tmp_path: Path) -> None:
    log = small_logs.dataflash(tmp_path / "flight.log")
    convert(log, tmp_path / "out", Selection(imu=1))
    with BagReader(tmp_path / "out") as reader:
        (_, first), *_ = read_samples(reader, reader.inputs())
    assert first.angular_velocity[0] == pytest.approx(small_logs.GYRO[0] + 1.0)  # type: ignore[union-attr]
    with pytest.raises(BagError, match="has no IMU number 2"):
        convert(log, tmp_path / "none", Selection(imu=2))
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("name", FORMATS)
def test_damaged_logs_are_imported_in_part_or_refused(name: str, tmp_path: Path) -> None:
    make, file = FORMATS[name]
    log = make(tmp_path / file)
    content_of = next(log.glob("*.db3")) if log.is_dir() else log
    content = content_of.read_bytes()
    rng = random.Random(3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # pymavlink leaves a file open
        for number in range(25):
            data = bytearray(content[: rng.randrange(1, len(content))] if number % 2 else content)
            for _ in range(rng.randrange(4)):
                data[rng.randrange(min(len(data), 3000))] = rng.randrange(256)
            content_of.write_bytes(data)
            with suppress(BagError):
                convert(log, tmp_path / f"out{number}")
        gc.collect()


def test_a_ulog_that_is_cut_off_in_its_definitions_does_not_go_on_for_ever(
    tmp_path: Path,
) -> None:
    """A message of an unknown kind, longer than what is left."""
    log = tmp_path / "flight.ulg"
    log.write_bytes(b"ULog\x01\x12\x35\x01" + bytes(8) + bytes((3, 0, 0)) + bytes(2))
    with pytest.raises(BagError, match="circles"):
        convert(log, tmp_path / "out")


def test_an_mcap_bag_is_no_log_and_a_log_is_a_bag_for_a_while(tmp_path: Path) -> None:
    log = small_logs.ulog(tmp_path / "flight.ulg")
    with as_bag(log) as (bag, done):
        assert done is not None
        assert bag.is_dir()
        assert not is_log(bag)
        with as_bag(bag) as (same, nothing):
            assert (same, nothing) == (bag, None)
    assert not bag.exists()
    (tmp_path / "text").write_text("no log")
    with pytest.raises(
        BagError, match=r"known are ArduPilot DataFlash, .*MAVLink telemetry log, PX4 ULog"
    ):
        convert(tmp_path / "text", tmp_path / "out")


def test_analyze_and_convert_take_logs(tmp_path: Path) -> None:
    log = small_logs.ulog(tmp_path / "flight.ulg")
    command = [sys.executable, "-m", "hijack_detect.cli.main"]
    done = subprocess.run(
        [*command, "convert", log, tmp_path / "out"], capture_output=True, text=True, check=True
    )
    assert "from PX4 ULog" in done.stdout
    assert "/imu/data_raw 250" in done.stdout
    done = subprocess.run(
        [*command, "analyze", log, "--json", "-"], capture_output=True, text=True, check=False
    )
    assert done.returncode == EXIT_NOT_JUDGED, "a position that repeats, on the ground"
    assert f'"bag": "{log}"' in done.stdout
    assert "no subscription found" in done.stderr
