# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Snapshots on disk: written beside, flushed, then renamed, so that a name means a whole bag."""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Iterable
from contextlib import suppress
from itertools import count
from pathlib import Path

from hijack_detect.bags.writer import BagWriter
from hijack_detect.recording.parameters import MEGABYTE, RecorderParameters
from hijack_detect.recording.snapshot import Snapshot, Written

SNAPSHOTS = "snapshots"
"""Name of the folder beside the journal."""
_WRITING = ".writing"
_PART = re.compile(r"(?P<name>alert_.+)\.part(?P<number>\d+)")
_YIELD_EVERY = 50
"""Messages written between two moments at which other threads go first."""
_YIELD_S = 0.001


class SnapshotFolder:
    """Writes snapshots, keeps so many of them, and removes what killed runs left."""

    def __init__(self, path: Path, parameters: RecorderParameters) -> None:
        """Name the folder; nothing is made yet."""
        self.path = path
        self._max_count = parameters.max_snapshots
        self._max_bytes = parameters.snapshots_max_mb * MEGABYTE

    def unused(self, name: str) -> str:
        """Return the name, or with a number behind it if there is a snapshot of that name."""
        taken = {_snapshot_of(path) for path in self._bags()}
        return next(
            one
            for number in count(1)
            if (one := name if number == 1 else f"{name}_{number}") not in taken
        )

    def write(self, snapshot: Snapshot) -> Written:
        """Write a snapshot; when this returns it survives a loss of power.

        Raises:
            OSError: It cannot be written.
            BagError: The same, as told by the writer of bags.
        """
        final = self.path / snapshot.directory
        writing = self.path / _WRITING
        shutil.rmtree(writing, ignore_errors=True)
        writing.mkdir(parents=True)
        try:
            bag = writing / snapshot.directory
            with BagWriter(bag) as writer:
                for index, one in enumerate(snapshot.messages):
                    if index % _YIELD_EVERY == 0:
                        time.sleep(_YIELD_S)
                    writer.write_raw(one.topic, one.msgtype, one.log_ns, one.data)
            size = _size(bag)
            _flush(bag)
            bag.rename(final)
            _flush_one(self.path)
        finally:
            shutil.rmtree(writing, ignore_errors=True)
        return Written(snapshot, size, self._excess(keep=snapshot.name))

    def remove(self, directories: Iterable[str]) -> None:
        """Remove bag directories; one that is not there, or that the disk keeps, is left."""
        for name in directories:
            # Renamed first: a removal that is killed half-way must not leave a damaged bag.
            leaving = self.path / f"{_WRITING}-{name}"
            with suppress(OSError):
                (self.path / name).rename(leaving)
                shutil.rmtree(leaving, ignore_errors=True)

    def clean(self) -> None:
        """Make the folder, and remove the bags that a killed run left half written.

        Raises:
            OSError: The folder cannot be written.
        """
        self.path.mkdir(parents=True, exist_ok=True)
        for path in self.path.glob(f"{_WRITING}*"):
            shutil.rmtree(path, ignore_errors=True)

    def superseded(self) -> list[str]:
        """Names of the parts beside which there is a later part or the whole."""
        newest: dict[str, tuple[float, str]] = {}
        old = []
        for path in self._bags():
            part = _PART.fullmatch(path.name)
            rank = float(part["number"]) if part else float("inf")
            before = newest.get(_snapshot_of(path))
            if before is None or before[0] < rank:
                newest[_snapshot_of(path)] = (rank, path.name)
                old += [before[1]] if before else []
            else:
                old.append(path.name)
        return old

    def _excess(self, keep: str) -> tuple[str, ...]:
        """Names of the oldest bags beyond the bounds, never those of the snapshot `keep`.

        Old is what was written long ago: the stamps of a replayed flight may be of any year.
        """
        try:
            bags = [(path, _size(path), path.stat().st_mtime_ns) for path in self._bags()]
        except OSError:  # somebody else removes one; the next snapshot looks again
            return ()
        size = sum(of_one for _, of_one, _ in bags)
        others = sorted(
            (age, path.name, of) for path, of, age in bags if _snapshot_of(path) != keep
        )
        excess = []
        for index, (_, name, of_one) in enumerate(others):
            if len(others) - index < self._max_count and size <= self._max_bytes:
                break
            size -= of_one
            excess.append(name)
        return tuple(excess)

    def _bags(self) -> list[Path]:
        try:
            return [path for path in self.path.glob("alert_*") if path.is_dir()]
        except OSError:
            return []


def _snapshot_of(path: Path) -> str:
    part = _PART.fullmatch(path.name)
    return part["name"] if part else path.name


def _size(directory: Path) -> int:
    return sum(path.stat().st_size for path in directory.iterdir())


def _flush(directory: Path) -> None:
    for path in (*directory.iterdir(), directory):
        _flush_one(path)


def _flush_one(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
