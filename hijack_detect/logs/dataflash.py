# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""ArduPilot DataFlash, binary or text (pymavlink)."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from hijack_detect.bags.errors import BagError
from hijack_detect.logs.frames import enu, flu, from_angles
from hijack_detect.logs.logged import ATTITUDE, Logged, Notes, Wanted, fix_sample
from hijack_detect.logs.units import FIX_3D, MILLIGAUSS_T
from hijack_detect.streams.samples import (
    NANOSECONDS,
    ImuSample,
    MagneticSample,
    PressureSample,
    SatelliteSample,
    VelocitySample,
)

MAGIC = b"\xa3\x95"
NUMBERED = re.compile(r"(IMU|GPS|MAG|BARO|BAR)(\d*)")
"""Sensors are numbered in the name of the message (IMU2), or in its field I."""

Make = Callable[[Any, int], Iterator[Logged]]


def read(path: Path, wanted: Wanted, notes: Notes) -> Iterator[Logged]:
    """Read a log; see `Read`. The stamp of a GPS message is when the autopilot had it."""
    makers: dict[str, tuple[int, Make]] = {
        "IMU": (wanted.imu, _imu),
        "GPS": (wanted.gps, _gps),
        "MAG": (0, _mag),
        "BARO": (0, _pressure),
    }
    seen: set[str] = set()
    with _opened(path) as log:
        base_ns = round(getattr(log.clock, "timebase", 0.0) * NANOSECONDS)
        if not base_ns:
            notes.said.append("the log does not know UTC: stamps count from the autopilot's start")
        notes.said.append("heights are above the sea, not above the ellipsoid")
        for message in _messages(log, notes):
            kind, number = _sensor(message)
            if kind == "ATT":
                yield from _attitude(message, base_ns + _since_start_ns(message))
            elif kind in makers and number == makers[kind][0]:
                seen.add(kind)
                yield from makers[kind][1](message, base_ns + _since_start_ns(message))
            elif kind in makers:
                notes.skipped[f"{kind} number {number}: another one is taken"] += 1
    for kind, number in (("IMU", wanted.imu), ("GPS", wanted.gps)):
        if kind not in seen:
            raise BagError(f"{path}: has no {kind} number {number}")


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Any]:
    from pymavlink import DFReader  # noqa: PLC0415  an extra

    with path.open("rb") as file:
        binary = file.read(len(MAGIC)) == MAGIC
    kind = DFReader.DFReader_binary if binary else DFReader.DFReader_text
    log = kind(str(path), False)
    try:
        yield log
    finally:
        log.data_map.close()
        log.filehandle.close()


def _messages(log: Any, notes: Notes) -> Iterator[Any]:
    while True:
        try:
            message = log.recv_msg()
        except Exception as error:
            notes.said.append(f"the log is damaged, its rest is left out ({error!r})")
            return
        if message is None:
            return
        yield message


def _sensor(message: Any) -> tuple[str, int]:
    """Kind and number of the sensor that a message is of; its type and 0 if it is of none."""
    kind = str(message.get_type())
    match = NUMBERED.fullmatch(kind)
    if match is None:
        return kind, 0
    name = "BARO" if match[1] == "BAR" else match[1]
    if match[2]:
        return name, int(match[2]) - 1
    return name, int(getattr(message, "I", 0))


def _since_start_ns(message: Any) -> int:
    """Time since the autopilot was started, nanoseconds."""
    if hasattr(message, "TimeUS"):
        return int(message.TimeUS) * 1000
    milliseconds = message.T if message.get_type().startswith("GPS") else message.TimeMS
    return int(milliseconds) * 1_000_000


def _imu(message: Any, stamp_ns: int) -> Iterator[Logged]:
    angular = flu(message.GyrX, message.GyrY, message.GyrZ)
    force = flu(message.AccX, message.AccY, message.AccZ)
    yield Logged("imu", stamp_ns, ImuSample(stamp_ns, angular, force))


def _gps(message: Any, stamp_ns: int) -> Iterator[Logged]:
    has_fix = message.Status >= FIX_3D
    place = (message.Lat, message.Lng, message.Alt)
    yield Logged("fix", stamp_ns, fix_sample(stamp_ns, place, math.nan, has_fix=has_fix))
    if has_fix:
        course = math.radians(message.GCrs)
        north, east = message.Spd * math.cos(course), message.Spd * math.sin(course)
        yield Logged("velocity", stamp_ns, VelocitySample(stamp_ns, enu(north, east, message.VZ)))
    yield Logged("satellites", stamp_ns, SatelliteSample(stamp_ns, int(message.NSats)))


def _mag(message: Any, stamp_ns: int) -> Iterator[Logged]:
    x, y, z = (one * MILLIGAUSS_T for one in (message.MagX, message.MagY, message.MagZ))
    yield Logged("mag", stamp_ns, MagneticSample(stamp_ns, flu(x, y, z)))


def _pressure(message: Any, stamp_ns: int) -> Iterator[Logged]:
    yield Logged("pressure", stamp_ns, PressureSample(stamp_ns, float(message.Press)))


def _attitude(message: Any, stamp_ns: int) -> Iterator[Logged]:
    angles = map(math.radians, (message.Roll, message.Pitch, message.Yaw))
    yield Logged(ATTITUDE, stamp_ns, from_angles(*angles))
