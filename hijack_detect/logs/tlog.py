# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""MAVLink telemetry logs of ground stations (pymavlink)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hijack_detect.bags.errors import BagError
from hijack_detect.logs.frames import flu, from_angles
from hijack_detect.logs.logged import ATTITUDE, Logged, Notes, Wanted, fix_sample
from hijack_detect.logs.units import (
    FIX_3D,
    GAUSS_T,
    HECTOPASCAL_PA,
    MILLI,
    MILLIGAUSS_T,
    MILLIGRAVITY,
)
from hijack_detect.streams.samples import (
    ImuSample,
    MagneticSample,
    PressureSample,
    SatelliteSample,
)

IMUS = (("HIGHRES_IMU", "RAW_IMU", "SCALED_IMU"), ("SCALED_IMU2",), ("SCALED_IMU3",))
"""Messages of each IMU; the first that comes is the one that is taken."""
GPSS = ("GPS_RAW_INT", "GPS2_RAW")
APART_US = 10_000_000
"""A message whose own time is further from when it was heard has another clock."""


class _Clock:
    """Stamps from the times in messages, which count from the start of the autopilot."""

    def __init__(self) -> None:
        self._offset_us: int | None = None

    def stamp_ns(self, message: Any) -> int:
        """Stamp of a message; when it was heard, if its own time makes no sense."""
        heard_us = round(message._timestamp * 1e6)
        own = getattr(message, "time_usec", None)
        own_us = int(message.time_boot_ms) * 1000 if own is None else int(own)
        if self._offset_us is None:
            self._offset_us = heard_us - own_us
        stamp_us = own_us + self._offset_us
        return (stamp_us if abs(stamp_us - heard_us) <= APART_US else heard_us) * 1000


def read(path: Path, wanted: Wanted, notes: Notes) -> Iterator[Logged]:
    """Read a log; see `Read`. Stamps are those of the autopilot, set by the ground station's clock.

    Telemetry has no vertical velocity of the receiver, so there are no velocities.
    """
    from pymavlink import mavutil  # noqa: PLC0415  an extra

    if wanted.imu >= len(IMUS) or wanted.gps >= len(GPSS):
        raise BagError(f"{path}: telemetry has {len(IMUS)} IMUs and {len(GPSS)} GPS at most")
    notes.said.append("telemetry has no vertical velocity of the GPS: velocities are left out")
    clock, system, taken = _Clock(), None, ""
    kinds, gps = IMUS[wanted.imu], GPSS[wanted.gps]
    log = mavutil.mavlogfile(str(path), robust_parsing=True)
    try:
        while (message := log.recv_msg()) is not None:
            kind = message.get_type()
            if kind == "BAD_DATA":
                notes.skipped["bytes that are no message"] += 1
                continue
            if kind in kinds and not taken:
                taken, system = kind, message.get_srcSystem()
                notes.said.append(f"the IMU is {kind} of system {system}")
            if not taken or message.get_srcSystem() != system:
                continue
            if kind == taken:
                yield from _imu(message, clock.stamp_ns(message))
            elif kind == gps:
                yield from _gps(message, clock.stamp_ns(message))
            elif kind == "SCALED_PRESSURE" and taken != "HIGHRES_IMU":
                yield _pressure(message.press_abs, clock.stamp_ns(message))
            elif kind == "ATTITUDE":
                rotation = from_angles(message.roll, message.pitch, message.yaw)
                yield Logged(ATTITUDE, clock.stamp_ns(message), rotation)
    finally:
        log.close()
    if not taken:
        raise BagError(f"{path}: has no IMU number {wanted.imu} ({', '.join(kinds)})")


def _imu(message: Any, stamp_ns: int) -> Iterator[Logged]:
    si = message.get_type() == "HIGHRES_IMU"
    force_scale, gyro_scale, field_scale = (
        (1.0, 1.0, GAUSS_T) if si else (MILLIGRAVITY, MILLI, MILLIGAUSS_T)
    )
    gyro = flu(*(getattr(message, f"{axis}gyro") * gyro_scale for axis in "xyz"))
    force = flu(*(getattr(message, f"{axis}acc") * force_scale for axis in "xyz"))
    yield Logged("imu", stamp_ns, ImuSample(stamp_ns, gyro, force))
    field = flu(*(getattr(message, f"{axis}mag") * field_scale for axis in "xyz"))
    if any(field):
        yield Logged("mag", stamp_ns, MagneticSample(stamp_ns, field))
    if si:
        yield _pressure(message.abs_pressure, stamp_ns)


def _gps(message: Any, stamp_ns: int) -> Iterator[Logged]:
    place = (message.lat * 1e-7, message.lon * 1e-7, message.alt * 1e-3)
    accuracy_m = getattr(message, "h_acc", 0) * 1e-3 or math.nan
    has_fix = bool(message.fix_type >= FIX_3D)
    yield Logged("fix", stamp_ns, fix_sample(stamp_ns, place, accuracy_m, has_fix=has_fix))
    count = int(message.satellites_visible)
    yield Logged("satellites", stamp_ns, SatelliteSample(stamp_ns, count))


def _pressure(hectopascal: float, stamp_ns: int) -> Logged:
    pascal = float(hectopascal) * HECTOPASCAL_PA
    return Logged("pressure", stamp_ns, PressureSample(stamp_ns, pascal))
