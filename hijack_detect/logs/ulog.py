# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""PX4 ULog (pyulog)."""

from __future__ import annotations

import contextlib
import heapq
import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hijack_detect.bags.errors import BagError
from hijack_detect.logs import px4
from hijack_detect.logs.frames import GAUSS_T, attitude, flu
from hijack_detect.logs.logged import ATTITUDE, Logged, Notes, Selection
from hijack_detect.logs.receiver_clock import ReceiverClock, receiver_clock
from hijack_detect.streams.samples import (
    ImuSample,
    MagneticSample,
    PressureSample,
)

TOPICS = (
    "sensor_combined",
    "vehicle_imu",
    "vehicle_gps_position",
    "sensor_gps",
    "vehicle_magnetometer",
    "vehicle_air_data",
    "vehicle_attitude",
)
READS_A_BYTE = 4
"""Bound of reads for each byte. Chosen: twice the two that a search after damage needs."""

Columns = Mapping[str, Any]
"""Values of one topic by field, each of shape (n,)."""


def read(path: Path, selection: Selection, notes: Notes) -> Iterator[Logged]:
    """Read a log; see `Read`. The stamp of a GPS message is when the driver had it."""
    topics = _topics(path, notes)
    gps = _gps(path, topics, selection.gps)
    utc_us = gps.get("time_utc_usec", ())
    known = next((at for at, utc in enumerate(utc_us) if utc), None)
    offset_us = 0 if known is None else int(utc_us[known]) - int(gps["timestamp"][known])
    if known is None:
        notes.remarks.append("the log does not know UTC: stamps count from the autopilot's start")

    clock = _clock(gps)
    if clock.corrects:
        notes.remarks.append(clock.remark())

    def stamp(microseconds: Any) -> int:
        return clock(int(microseconds) * 1000) + offset_us * 1000

    streams = [_imu(path, topics, selection.imu, stamp), _fixes(gps, stamp, notes)]
    for topic, rows in (
        ("vehicle_magnetometer", _mag),
        ("vehicle_air_data", _pressure),
        ("vehicle_attitude", _attitude),
    ):
        if (columns := topics.get((topic, 0))) is not None:
            streams.append(rows(columns, stamp))
        else:
            notes.remarks.append(f"the log has no {topic}")
    yield from heapq.merge(*streams, key=lambda one: one.stamp_ns)


class _Forward(io.FileIO):
    """A file that is not read in circles, as pyulog 1.3 does where a log was cut off."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._left = READS_A_BYTE * path.stat().st_size + 100

    def read(self, size: int | None = -1, /) -> bytes:
        """Read, unless the file was read for too often."""
        self._left -= 1
        if self._left < 0:
            raise OSError("the log leads its reader in circles")
        return super().read(-1 if size is None else size)


def _topics(path: Path, notes: Notes) -> dict[tuple[str, int], Columns]:
    from pyulog import ULog  # noqa: PLC0415  an extra

    warnings = io.StringIO()
    with _Forward(path) as file, contextlib.redirect_stdout(warnings):  # where pyulog warns
        log = ULog(file, list(TOPICS))
    notes.skipped.update(line.strip() for line in warnings.getvalue().splitlines() if line.strip())
    if log.file_corruption:
        notes.remarks.append("the log is damaged: what could be read was taken")
    if log.dropouts:
        lost_s = sum(one.duration for one in log.dropouts) / 1000.0
        notes.remarks.append(f"the logger dropped {len(log.dropouts)} times, {lost_s:.1f} s in all")
    return {(one.name, one.multi_id): one.data for one in log.data_list}


def _gps(path: Path, topics: Mapping[tuple[str, int], Columns], number: int) -> Columns:
    names = ("vehicle_gps_position", "sensor_gps") if number == 0 else ("sensor_gps",)
    for name in names:
        if (name, number) in topics:
            return topics[name, number]
    have = ", ".join(f"{name} {of}" for name, of in sorted(topics)) or "nothing of use"
    raise BagError(f"{path}: has no GPS number {number}; it has {have}")


def _imu(
    path: Path, topics: Mapping[tuple[str, int], Columns], number: int, stamp: Any
) -> Iterator[Logged]:
    """The selected IMU as number 0, else one IMU's increments over their time."""
    one = topics.get(("sensor_combined", 0)) if number == 0 else None
    if one is not None:
        gyro, force = _vectors(one, "gyro_rad"), _vectors(one, "accelerometer_m_s2")
    else:
        one = topics.get(("vehicle_imu", number))
        if one is None:
            raise BagError(f"{path}: has no IMU number {number} (sensor_combined, vehicle_imu)")
        gyro = _vectors(one, "delta_angle") / (1e-6 * one["delta_angle_dt"][:, None])
        force = _vectors(one, "delta_velocity") / (1e-6 * one["delta_velocity_dt"][:, None])
    return (
        Logged("imu", stamp(at), ImuSample(stamp(at), flu(*angular), flu(*felt)))
        for at, angular, felt in zip(one["timestamp"], gyro, force, strict=True)
    )


def _clock(gps: Columns) -> ReceiverClock:
    """The clock of a log, from the receiver's time in it."""
    utc_us = np.asarray(gps.get("time_utc_usec", ()), dtype=np.int64)
    known = np.flatnonzero(utc_us)
    own_ns = gps["timestamp"][known].astype(np.int64) * 1000
    return receiver_clock(own_ns.tolist(), (1e-6 * (utc_us[known] - utc_us[known][:1])).tolist())


def _fixes(columns: Columns, stamp: Any, notes: Notes) -> Iterator[Logged]:
    in_degrees, above_sea = px4.IN_DEGREES in columns, False
    for at, microseconds in enumerate(columns["timestamp"]):
        row = {name: values[at] for name, values in columns.items()}
        if not above_sea and px4.height_m(row.__getitem__, in_degrees=in_degrees)[1]:
            above_sea = True
            notes.remarks.append(px4.ABOVE_SEA)
        yield from px4.gps(stamp(microseconds), row.__getitem__, in_degrees=in_degrees)


def _mag(columns: Columns, stamp: Any) -> Iterator[Logged]:
    fields = _vectors(columns, "magnetometer_ga") * GAUSS_T
    return (
        Logged("mag", stamp(at), MagneticSample(stamp(at), flu(*field)))
        for at, field in zip(columns["timestamp"], fields, strict=True)
    )


def _pressure(columns: Columns, stamp: Any) -> Iterator[Logged]:
    return (
        Logged("pressure", stamp(at), PressureSample(stamp(at), float(pascal)))
        for at, pascal in zip(columns["timestamp"], columns["baro_pressure_pa"], strict=True)
    )


def _attitude(columns: Columns, stamp: Any) -> Iterator[Logged]:
    rows = zip(columns["timestamp"], *(columns[f"q[{index}]"] for index in range(4)), strict=True)
    for at, w, x, y, z in rows:
        rotation = attitude((float(x), float(y), float(z), float(w)))
        yield Logged(ATTITUDE, stamp(at), rotation)


def _vectors(columns: Columns, name: str) -> Any:
    """Three fields as an array of shape (n, 3)."""
    return np.stack([columns[f"{name}[{axis}]"] for axis in range(3)], axis=1).astype(float)
