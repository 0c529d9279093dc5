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
from hijack_detect.logs.frames import FIX_3D, MILLIGAUSS_T, enu, flu, from_angles
from hijack_detect.logs.logged import ATTITUDE, Logged, Notes, Selection, fix_sample
from hijack_detect.logs.receiver_clock import ReceiverClock, receiver_clock
from hijack_detect.streams.samples import (
    NANOSECONDS,
    ImuSample,
    MagneticSample,
    PressureSample,
    SatelliteSample,
    VelocitySample,
)

MAGIC = b"\xa3\x95"
NUMBERED = re.compile(r"(IMU|GPS|GPA|MAG|BARO|BAR)(\d*)")
"""Sensors are numbered in the name of the message (IMU2), or in its field I."""

METRES_PER_HDOP = 2.1
"""Standard deviation of East and of North for an HDOP of 1, m: u-blox states 50 % within 2.5 m
(NEO-6 and M8 without corrections, about that HDOP), and of two normal axes that is 1.18 σ."""
CLAIM_NS = 2 * NANOSECONDS
"""Age at which an accuracy (GPA) expires. Chosen: ten fixes of 5 Hz; GPA comes with each GPS."""

Make = Callable[[Any, int], Iterator[Logged]]


def read(path: Path, selection: Selection, notes: Notes) -> Iterator[Logged]:
    """Read a log; see `Read`. The stamp of a GPS message is when the autopilot had it."""
    receiver = _Receiver()
    makers: dict[str, tuple[int, Make]] = {
        "IMU": (selection.imu, _imu),
        "GPS": (selection.gps, receiver.readings),
        "GPA": (selection.gps, receiver.accuracy),
        "MAG": (0, _mag),
        "BARO": (0, _pressure),
    }
    seen: set[str] = set()
    with _opened(path) as log:
        base_ns, clock = _clock(log, selection.gps)
        if not base_ns:
            notes.remarks.append(
                "the log does not know UTC: stamps count from the autopilot's start"
            )
        if clock.corrects:
            notes.remarks.append(clock.remark())
        notes.remarks.append("heights are above the sea, not above the ellipsoid")
        own_ns = 0
        for message in _messages(log, notes):
            kind, number = _sensor(message)
            if kind != "ATT" and kind not in makers:
                continue
            own_ns = _since_start_ns(message, own_ns)
            stamp_ns = base_ns + clock(own_ns)
            if kind == "ATT":
                yield from _attitude(message, stamp_ns)
            elif kind in makers and number == makers[kind][0]:
                seen.add(kind)
                yield from makers[kind][1](message, stamp_ns)
            elif kind in makers and kind != "GPA":
                notes.skipped[f"{kind} number {number}: another one is taken"] += 1
    for kind, number in (("IMU", selection.imu), ("GPS", selection.gps)):
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


def _clock(log: Any, gps: int) -> tuple[int, ReceiverClock]:
    """UTC at the autopilot's start (ns, 0 if it is not known), and the clock of the log.

    The log is read up to its end, and set back to its start.
    """
    own: list[int] = []
    receiver: list[float] = []
    base_ns, own_ns = round(getattr(log.clock, "timebase", 0.0) * NANOSECONDS), 0
    interpolated, begun = "interpolated" in type(log.clock).__name__, False
    for message in _messages(log, Notes()):
        kind, number = _sensor(message)
        if kind not in ("GPS", "IMU"):
            continue
        own_ns = _since_start_ns(message, own_ns)
        if kind != "GPS" or number != gps or message.Status < FIX_3D or not own_ns:
            continue
        if interpolated and not begun:  # its time base is that of the newest GPS message
            base_ns = round(message._timestamp * NANOSECONDS) - own_ns
        begun = True
        week_ms = getattr(message, "GMS", getattr(message, "TimeMS", None))
        if week_ms:
            own.append(own_ns)
            receiver.append(week_ms * 1e-3)
    log.rewind()
    return base_ns, receiver_clock(own, receiver)


def _messages(log: Any, notes: Notes) -> Iterator[Any]:
    while True:
        try:
            message = log.recv_msg()
        except Exception as error:
            notes.remarks.append(f"the log is damaged, its rest is left out ({error!r})")
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


def _since_start_ns(message: Any, newest_ns: int) -> int:
    """Time since the autopilot was started, nanoseconds.

    A GPS message of ArduPilot 3.1 and older has the receiver's time only: it came right after the
    message before it, which was at `newest_ns`.
    """
    if hasattr(message, "TimeUS"):
        return int(message.TimeUS) * 1000
    if not message.get_type().startswith("GPS"):
        return int(message.TimeMS) * 1_000_000
    return int(message.T) * 1_000_000 if hasattr(message, "T") else newest_ns


def _imu(message: Any, stamp_ns: int) -> Iterator[Logged]:
    angular = flu(message.GyrX, message.GyrY, message.GyrZ)
    force = flu(message.AccX, message.AccY, message.AccZ)
    yield Logged("imu", stamp_ns, ImuSample(stamp_ns, angular, force))


class _Receiver:
    """Fix, velocity and satellites of GPS messages, with the accuracy of GPA or HDop."""

    def __init__(self) -> None:
        self._claimed: tuple[int, float, float] | None = None

    def accuracy(self, message: Any, stamp_ns: int) -> Iterator[Logged]:
        """Keep the accuracies of a GPA, horizontal and vertical (m); it follows on its GPS."""
        across, up = float(message.HAcc), float(getattr(message, "VAcc", math.nan))
        if across > 0.0:
            self._claimed = stamp_ns, across, up
        yield from ()

    def readings(self, message: Any, stamp_ns: int) -> Iterator[Logged]:
        """The readings of a GPS; without VZ the vertical velocity was not logged."""
        has_fix = message.Status >= FIX_3D
        place = (message.Lat, message.Lng, message.Alt)
        across, up = float(getattr(message, "HDop", math.nan)) * METRES_PER_HDOP, math.nan
        if self._claimed is not None and 0 <= stamp_ns - self._claimed[0] <= CLAIM_NS:
            _, across, up = self._claimed
        fix = fix_sample(stamp_ns, place, across, has_fix=has_fix, vertical_accuracy_m=up)
        yield Logged("fix", stamp_ns, fix)
        if has_fix:
            course = math.radians(message.GCrs)
            north, east = message.Spd * math.cos(course), message.Spd * math.sin(course)
            velocity = enu(north, east, getattr(message, "VZ", math.nan))
            yield Logged("velocity", stamp_ns, VelocitySample(stamp_ns, velocity))
        yield Logged("satellites", stamp_ns, SatelliteSample(stamp_ns, int(message.NSats)))


def _mag(message: Any, stamp_ns: int) -> Iterator[Logged]:
    x, y, z = (one * MILLIGAUSS_T for one in (message.MagX, message.MagY, message.MagZ))
    yield Logged("mag", stamp_ns, MagneticSample(stamp_ns, flu(x, y, z)))


def _pressure(message: Any, stamp_ns: int) -> Iterator[Logged]:
    yield Logged("pressure", stamp_ns, PressureSample(stamp_ns, float(message.Press)))


def _attitude(message: Any, stamp_ns: int) -> Iterator[Logged]:
    angles = map(math.radians, (message.Roll, message.Pitch, message.Yaw))
    yield Logged(ATTITUDE, stamp_ns, from_angles(*angles))
