# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""MAVLink telemetry logs of ground stations (pymavlink)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hijack_detect.bags.errors import BagError
from hijack_detect.logs import mavlink
from hijack_detect.logs.frames import from_angles
from hijack_detect.logs.logged import ATTITUDE, Logged, Notes, Selection

IMUS = (("HIGHRES_IMU", "RAW_IMU", "SCALED_IMU"), ("SCALED_IMU2",), ("SCALED_IMU3",))
"""Messages of each IMU; the first that comes is the one that is taken."""
GPSS = ("GPS_RAW_INT", "GPS2_RAW")
APART_US = 10_000_000
"""A message whose own time is further from its arrival has another clock. Chosen: far above the
delay of a radio, far below a time since 1970."""


class _Clock:
    """Stamps from the times in messages, which count from the start of the autopilot."""

    def __init__(self) -> None:
        self._offset_us: int | None = None

    def stamp_ns(self, message: Any) -> int:
        """Stamp of a message: its own time, or its arrival if the two are APART_US apart."""
        arrived_us = round(message._timestamp * 1e6)
        own_us = mavlink.own_time_us(message)
        if self._offset_us is None:
            self._offset_us = arrived_us - own_us
        stamp_us = own_us + self._offset_us
        return (stamp_us if abs(stamp_us - arrived_us) <= APART_US else arrived_us) * 1000


def read(path: Path, selection: Selection, notes: Notes) -> Iterator[Logged]:
    """Read a log; see `Read`. Stamps are those of the autopilot, set by the ground station's clock.

    Velocities have no vertical component, see `logs.mavlink`. SYSTEM_TIME is no witness of the
    clock's rate: an autopilot sets its UTC once and lets it run on its own clock.
    """
    from pymavlink import mavutil  # noqa: PLC0415  an extra

    if selection.imu >= len(IMUS) or selection.gps >= len(GPSS):
        raise BagError(f"{path}: telemetry has {len(IMUS)} IMUs and {len(GPSS)} GPS at most")
    notes.remarks.append(mavlink.NO_CLIMB)
    clock, system, taken = _Clock(), None, ""
    kinds, gps = IMUS[selection.imu], GPSS[selection.gps]
    log = mavutil.mavlogfile(str(path), robust_parsing=True)
    try:
        while (message := log.recv_msg()) is not None:
            kind = message.get_type()
            if kind == "BAD_DATA":
                notes.skipped["bytes that are no message"] += 1
                continue
            if kind in kinds and not taken:
                taken, system = kind, message.get_srcSystem()
                notes.remarks.append(f"the IMU is {kind} of system {system}")
            if not taken or message.get_srcSystem() != system:
                continue
            if kind == taken:
                yield from mavlink.imu(message, clock.stamp_ns(message))
            elif kind == gps:
                yield from mavlink.gps(message, clock.stamp_ns(message))
            elif kind == "SCALED_PRESSURE" and taken != "HIGHRES_IMU":
                yield from mavlink.pressure(message, clock.stamp_ns(message))
            elif kind == "ATTITUDE":
                rotation = from_angles(message.roll, message.pitch, message.yaw)
                yield Logged(ATTITUDE, clock.stamp_ns(message), rotation)
    finally:
        log.close()
    if not taken:
        raise BagError(f"{path}: has no IMU number {selection.imu} ({', '.join(kinds)})")
