# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Snapshots: the messages around an alert, their folder, and the thread that writes them."""

from __future__ import annotations

import os
import re
import shutil
import time
from collections import deque
from collections.abc import Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from hijack_detect.bags.reader import RawMessage
from hijack_detect.bags.writer import BagWriter
from hijack_detect.recording.parameters import MEGABYTE, RecorderParameters
from hijack_detect.recording.problems import problem_text


@dataclass(frozen=True)
class Snapshot:
    """Messages around an alert that are to be written as a bag.

    Attributes:
        name: Name of the snapshot, the same for its parts and for the whole.
        part: 0 for the whole; parts are numbered from 1, and each holds the one before.
        alerts_ns: Stamps of the alerts in it, nanoseconds.
        messages: In order of log time.
    """

    name: str
    part: int
    alerts_ns: tuple[int, ...]
    messages: Sequence[RawMessage]

    @property
    def complete(self) -> bool:
        """Whether it holds the time after the alert."""
        return self.part == 0

    @property
    def directory(self) -> str:
        """Name of the bag directory."""
        return self.name if self.complete else f"{self.name}.part{self.part}"


@dataclass(frozen=True)
class Written:
    """A snapshot on disk, complete and flushed.

    `size` is in bytes.
    """

    snapshot: Snapshot
    size: int
    excess: tuple[str, ...]
    """Bag directories that should go, so that the bounds hold; the oldest first."""


@dataclass(frozen=True)
class Failed:
    """A snapshot that could not be written; `text` has the reason and the remedy."""

    snapshot: Snapshot
    text: str


SNAPSHOTS = "snapshots"
"""Name of the folder beside the journal."""
_WRITING = ".writing"
_PART = re.compile(r"(?P<name>alert_.+)\.part(?P<number>\d+)")
_YIELD_EVERY = 50
"""Messages written between two pauses of `_YIELD_S`, in which other threads run. Chosen, not
swept."""
_YIELD_S = 0.001


class SnapshotFolder:
    """The folder of snapshots: writes them, bounds them, removes the leavings of killed runs."""

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
            BagError: The same, from the writer of bags.
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

        Age is that of the file: the stamps of a replayed flight may be of any year.
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


RETRY_S = 5.0
"""Period of retries. Chosen, not swept."""
MAX_WAITING = 3
"""Snapshots kept in memory while the disk takes none. Chosen, not swept; each has up to
ring_max_mb."""


class SnapshotWriter:
    """A queue of snapshots, written one after the other; what fails is tried again.

    Attributes:
        lost: Snapshots given up, because too many were waiting for the disk.
    """

    def __init__(self, folder: SnapshotFolder) -> None:
        self._folder = folder
        self._waiting: deque[Snapshot] = deque()
        self._writing: Future[Written | Failed] | None = None
        self._threads = ThreadPoolExecutor(max_workers=1, thread_name_prefix="snapshots")
        self._not_before_s = 0.0
        self.lost = 0

    @property
    def busy(self) -> bool:
        """Whether something is being written or waits to be."""
        return self._writing is not None or bool(self._waiting)

    def add(self, snapshot: Snapshot) -> None:
        """Take a snapshot; a part that still waits is replaced by a later one of its snapshot."""
        self._waiting = deque(one for one in self._waiting if one.name != snapshot.name)
        self._waiting.append(snapshot)
        while len(self._waiting) > MAX_WAITING:
            self._waiting.popleft()
            self.lost += 1

    def poll(self, wall_s: float) -> Written | Failed | None:
        """Begin the next one; return one that was written or failed since the last call, if any."""
        done = None
        if self._writing is not None and self._writing.done():
            done = self._take(self._writing, wall_s)
        if self._writing is None and self._waiting and wall_s >= self._not_before_s:
            self._writing = self._threads.submit(self._write, self._waiting.popleft())
        return done

    def finish(self, wall_s: float) -> list[Written | Failed]:
        """Write all that waits, each tried once, and end the thread."""
        done: list[Written | Failed] = []
        self._not_before_s = wall_s
        for _ in range(MAX_WAITING + 1):
            if (one := self.poll(wall_s)) is not None:
                done.append(one)
            if self._writing is None:
                break
            done.append(self._take(self._writing, wall_s))
            self._not_before_s = wall_s
        self._threads.shutdown()
        return done

    def _write(self, snapshot: Snapshot) -> Written | Failed:
        """Runs in the thread."""
        try:
            return self._folder.write(snapshot)
        except Exception as error:  # whatever a disk and a writer of bags can raise
            return Failed(snapshot, problem_text(self._folder.path / snapshot.directory, error))

    def _take(self, writing: Future[Written | Failed], wall_s: float) -> Written | Failed:
        done = writing.result()
        self._writing = None
        if isinstance(done, Failed):
            self._not_before_s = wall_s + RETRY_S
            if all(one.name != done.snapshot.name for one in self._waiting):
                self._waiting.appendleft(done.snapshot)
        return done
