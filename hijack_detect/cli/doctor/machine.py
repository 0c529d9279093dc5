# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The machine: clock, processors, disk, sockets."""

from __future__ import annotations

import ctypes
import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

from hijack_detect.cli.doctor.finding import Finding, Level

RELEASED_S = 1_764_000_000
"""No clock of a machine that runs this is before November 2025."""
UNSYNCHRONISED = 0x40
"""Standard: STA_UNSYNC of adjtimex(2)."""
COARSE_S = 1e-4
"""Seconds. Chosen, not swept: a tenth of the interval of an IMU at 1 kHz."""
GIGABYTE = 1e9
"""Least free space: the default size of journal and snapshots together."""
SMALL_BUFFER = 212_992
"""Bytes; the default of Linux, which holds half a second of an IMU at 1 kHz."""
BUFFER = Path("/proc/sys/net/core/rmem_max")
GOVERNORS = Path("/sys/devices/system/cpu")


class _Timex(ctypes.Structure):
    """The beginning of struct timex, and room for the rest."""

    _fields_ = (
        ("modes", ctypes.c_uint),
        *((name, ctypes.c_long) for name in ("offset", "freq", "maxerror", "esterror")),
        ("status", ctypes.c_int),
        ("rest", ctypes.c_byte * 512),
    )


def clock() -> Iterator[Finding]:
    """Check that the clock can be right, is kept right, and is fine enough."""
    now_s = time.time()
    if now_s < RELEASED_S:
        text = time.strftime("is at %Y-%m-%d, before this program was made", time.gmtime(now_s))
        mend = "sudo timedatectl set-ntp true, or fit a clock with a battery"
        yield Finding("clock", Level.FAIL, text, mend)
    resolution_s = time.clock_getres(time.CLOCK_REALTIME)
    if resolution_s > COARSE_S:
        text = f"its steps are {resolution_s:g} s: stamps of messages are that coarse"
        yield Finding("clock", Level.WARN, text, "cat /sys/devices/system/clocksource/*/available*")
    state = _Timex()
    if ctypes.CDLL(None, use_errno=True).adjtimex(ctypes.byref(state)) < 0:
        yield Finding("clock", Level.INFO, "the kernel does not report whether it is synchronised")
    elif state.status & UNSYNCHRONISED:
        text = "is not synchronised: stamps of two machines differ, and it may be set in flight"
        mend = "sudo timedatectl set-ntp true (or chrony); in a container see to the host"
        yield Finding("clock", Level.WARN, text, mend)
    else:
        yield Finding("clock", Level.OK, f"synchronised, within {state.maxerror / 1e6:.3f} s")


def processors(governors: Path = GOVERNORS) -> Iterator[Finding]:
    """Check number and load of the cores, and whether they save power."""
    cores, load = len(os.sched_getaffinity(0)), os.getloadavg()[0]
    text = f"{cores} cores, load {load:.1f}"
    if load > cores:
        mend = "see with top what runs; alerts come later on a machine that is too busy"
        yield Finding("processors", Level.WARN, text, mend)
    else:
        yield Finding("processors", Level.OK, text)
    saving = [
        file.parent.parent.name
        for file in sorted(governors.glob("cpu[0-9]*/cpufreq/scaling_governor"))
        if file.read_text().strip() == "powersave"
        and "pstate" not in _text(file.with_name("scaling_driver"))
    ]
    if saving:
        text = f"{len(saving)} run at their lowest frequency (governor powersave)"
        yield Finding("processors", Level.WARN, text, "sudo cpupower frequency-set -g schedutil")


def disk(folder: Path) -> Iterator[Finding]:
    """Check that the recorder can write into its folder, and has room."""
    place = folder.expanduser()
    while not place.exists() and place != place.parent:
        place = place.parent
    free = shutil.disk_usage(place).free
    if not place.is_dir() or not os.access(place, os.W_OK):
        mend = "give the recorder another folder: -p folder:=PATH"
        yield Finding("recorder", Level.WARN, f"{place} cannot be written", mend)
    elif free < GIGABYTE:
        text = f"{free / 1e6:.0f} MB free in {place}, journal and snapshots may take 1000"
        yield Finding("recorder", Level.WARN, text, "make room, or set journal_max_mb")
    else:
        yield Finding("recorder", Level.OK, f"{free / GIGABYTE:.0f} GB free in {folder}")


def sockets(limit: Path = BUFFER) -> Iterator[Finding]:
    """Check that the buffer of UDP is no smaller than the default of Linux."""
    if limit.is_file() and (size := int(limit.read_text())) < SMALL_BUFFER:
        text = f"net.core.rmem_max is {size}: bursts of an IMU over UDP may be lost"
        yield Finding("UDP", Level.WARN, text, f"sudo sysctl -w net.core.rmem_max={SMALL_BUFFER}")


def _text(file: Path) -> str:
    return file.read_text() if file.is_file() else ""
