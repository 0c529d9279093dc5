# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Writes snapshots in a thread of its own: messages that arrive meanwhile do not wait."""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor

from hijack_detect.recording.advice import told
from hijack_detect.recording.snapshot import Failed, Snapshot, Written
from hijack_detect.recording.snapshot_folder import SnapshotFolder

RETRY_S = 5.0
MAX_WAITING = 3
"""Snapshots kept in memory while the disk takes none."""


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
        """Begin the next one; return what was written or failed since the last call, if any."""
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
            return Failed(snapshot, told(self._folder.path / snapshot.directory, error))

    def _take(self, writing: Future[Written | Failed], wall_s: float) -> Written | Failed:
        done = writing.result()
        self._writing = None
        if isinstance(done, Failed):
            self._not_before_s = wall_s + RETRY_S
            if all(one.name != done.snapshot.name for one in self._waiting):
                self._waiting.appendleft(done.snapshot)
        return done
