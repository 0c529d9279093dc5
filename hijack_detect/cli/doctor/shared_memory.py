# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Leftovers of Fast DDS in shared memory after a process was killed.

Each segment and each port has a lock file (_el exclusive, _sl shared) that its owners keep locked
with flock. A lock that is free has no owner left: `fastdds shm clean` decides the same way.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from hijack_detect.cli.doctor.finding import Finding, Level

FOLDER = Path("/dev/shm")
LOCK = re.compile(r"(fastrtps_(?:port\d{1,5}|[0-9a-z]{16}))_(?:el|sl)")
YOUNG_S = 5.0
"""A file may be made before its owner locks it. Chosen, not swept."""
LOW_BYTES = 64 * 2**20
"""Physics: about a hundred processes of half a MB each; also the default of docker."""
MEGABYTE = 1e6


@dataclass(frozen=True)
class Leftover:
    """The files of a segment or of a port without an owner."""

    name: str
    files: tuple[Path, ...]

    @property
    def size(self) -> int:
        """Bytes that they take."""
        total = 0
        for file in self.files:
            with contextlib.suppress(OSError):
                total += file.stat().st_size
        return total


def leftovers(folder: Path = FOLDER) -> list[Leftover]:
    """Leftovers without an owner; files of other users are left out."""
    locks: dict[str, list[Path]] = {}
    if folder.is_dir():
        for file in sorted(folder.iterdir()):
            if match := LOCK.fullmatch(file.name):
                locks.setdefault(match[1], []).append(file)
    found = []
    for name, of in locks.items():
        with _held(of) as free:
            if free:
                found.append(_leftover(folder, name, of))
    return found


def clean(found: list[Leftover]) -> int:
    """Remove leftovers that are still without an owner; return their number."""
    removed = 0
    for one in found:
        locks = [file for file in one.files if LOCK.fullmatch(file.name)]
        with _held(locks) as free:
            if not free:
                continue
            for file in one.files:
                with contextlib.suppress(FileNotFoundError):
                    file.unlink()
            removed += 1
    return removed


def memory(folder: Path = FOLDER) -> Iterator[Finding]:
    """Leftovers of dead processes, and free space."""
    found = leftovers(folder)
    if found:
        megabytes = sum(one.size for one in found) / MEGABYTE
        text = f"{len(found)} leftovers of dead processes take {megabytes:.0f} MB of {folder}"
        yield Finding("shared memory", Level.WARN, text, "hijack-detect doctor --clean")
    else:
        yield Finding("shared memory", Level.OK, "no leftovers of dead processes")
    if not folder.is_dir():
        mend = "mount a tmpfs there, or export FASTDDS_BUILTIN_TRANSPORTS=UDPv4"
        yield Finding("shared memory", Level.WARN, f"there is no {folder}", mend)
        return
    state = os.statvfs(folder)
    free = state.f_bavail * state.f_frsize
    if free < LOW_BYTES:
        text = f"{free / MEGABYTE:.0f} MB free in {folder}, a process takes half of one"
        mend = "hijack-detect doctor --clean, or docker run --shm-size=512m"
        yield Finding("shared memory", Level.WARN, text, mend)
    else:
        yield Finding("shared memory", Level.OK, f"{free / MEGABYTE:.0f} MB free in {folder}")


@contextlib.contextmanager
def _held(locks: list[Path]) -> Iterator[bool]:
    """Whether all lock files could be locked, which they stay until the block is left."""
    opened: list[int] = []
    try:
        yield all(_locked(file, opened) for file in locks)
    finally:
        for descriptor in opened:
            os.close(descriptor)


def _locked(file: Path, opened: list[int]) -> bool:
    try:
        descriptor = os.open(file, os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW)
        opened.append(descriptor)
        if time.time() - os.fstat(descriptor).st_mtime < YOUNG_S:
            return False
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _leftover(folder: Path, name: str, locks: list[Path]) -> Leftover:
    beside = (folder / name, folder / f"sem.{name}_mutex")
    return Leftover(name, (*(one for one in beside if one.exists()), *locks))
