# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The recorder without ROS: messages in, files and a report out."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from hijack_detect.contract import Level, Log
from hijack_detect.monitor.verdict_messages import FusionStatus, fusion_from
from hijack_detect.parameters import ParameterError
from hijack_detect.recording import rows, schema
from hijack_detect.recording.black_box import FUSION, BlackBox, Source
from hijack_detect.recording.folder_lock import FolderLock
from hijack_detect.recording.journal import Session
from hijack_detect.recording.journal_keeper import JournalKeeper
from hijack_detect.recording.parameters import MEGABYTE, RecorderParameters
from hijack_detect.recording.problems import Problems, problem_text
from hijack_detect.recording.snapshots import (
    SNAPSHOTS,
    Failed,
    SnapshotFolder,
    SnapshotWriter,
    Written,
)
from hijack_detect.streams.messages import BadMessage

WRITTEN = [table for table in schema.TABLES if table != "sessions"]


@dataclass(frozen=True)
class Report:
    """A level, a sentence, and figures by name."""

    level: Level
    text: str
    values: dict[str, str]


@dataclass(frozen=True)
class SnapshotCounts:
    """Snapshots made, and lost because too many were waiting for the disk."""

    made: int
    lost: int


def report(
    parameters: RecorderParameters,
    journal: JournalKeeper,
    box: BlackBox,
    snapshots: SnapshotCounts,
    problems: Problems,
    refused: Mapping[str, int],
) -> Report:
    """Sum up a recorder; `refused` counts messages left out, by topic."""
    ring = box.ring
    values = {f"written {table}": str(journal.written[table]) for table in WRITTEN}
    values |= {f"dropped {table}": str(n) for table, n in journal.dropped.items()}
    values |= {f"left out {topic}": str(n) for topic, n in refused.items()}
    values |= {
        "rows waiting": str(journal.waiting),
        "journal bytes": str(journal.size),
        "journal bound": str(parameters.journal_max_mb * MEGABYTE),
        "ring seconds": f"{ring.seconds:.1f}",
        "ring bytes": str(box.size),
        "ring bound": str(parameters.ring_max_mb * MEGABYTE),
        "snapshots made": str(snapshots.made),
        "snapshots lost": str(snapshots.lost),
        "last problem": problems.last,
    }
    if problems.current:
        return Report("error", problems.text, values)
    if ring.short:
        text = (
            f"the ring holds {ring.seconds:.0f} s of the {parameters.before_s:g} s before an "
            "alert; raise ring_max_mb or lower before_s"
        )
        return Report("warning", text, values)
    text = "collecting what follows an alert" if box.collecting else "recording"
    return Report("info", f"{text} in {journal.path.parent}", values)


HOUR_NS = 3600 * 10**9


class Recorder:
    """Journal and black box together. A problem is logged and reported, and ends nothing."""

    def __init__(
        self,
        parameters: RecorderParameters,
        node: str,
        version: str,
        log: Log = lambda *_: None,
        announce: Callable[[Path], None] = lambda _: None,
    ) -> None:
        """Begin a session.

        Args:
            parameters: Where and how much.
            node: Full name of the node, kept with the session.
            version: Version of the package, kept with the session.
            log: Writes a log line.
            announce: Takes the path of each snapshot that is on disk.

        Raises:
            ParameterError: The folder begins with ~, and nobody knows where that is.
        """
        try:
            self.folder = Path(parameters.folder).expanduser().absolute()
        except RuntimeError as error:
            raise ParameterError(f"parameter 'folder' is {parameters.folder}: {error}") from error
        self._parameters, self._announce = parameters, announce
        self._lock = FolderLock(self.folder)
        started_ns = time.time_ns()
        self.journal = JournalKeeper(
            self.folder / schema.FILE,
            parameters.journal_max_mb * MEGABYTE,
            round(parameters.journal_max_age_h * HOUR_NS),
            Session(started_ns, node, version),
        )
        self._snapshots = SnapshotFolder(self.folder / SNAPSHOTS, parameters)
        self._writer = SnapshotWriter(self._snapshots)
        self.box = BlackBox(parameters, self._snapshots.unused)
        self._problems = Problems(log, self._event)
        self._last: FusionStatus | None = None
        self._parts: dict[str, str] = {}
        self._made = 0
        self._cleaned = False
        self.refused: Counter[str] = Counter()
        self._event("start", f"{node} {version}")
        self.tick()

    def receive(self, source: Source, data: bytes) -> None:
        """Take one message.

        Raises:
            BadMessage: Its content cannot be used; the black box keeps it nevertheless.
        """
        wall_s, wall_ns = time.monotonic(), time.time_ns()
        stamp_ns = self.box.push(
            source.name,
            source.topic,
            source.msgtype,
            data,
            stamped=source.stamped,
            wall_s=wall_s,
        )
        if source.decode is None:
            return
        message = source.decode(data)
        if source.name == FUSION:
            self._take_fusion(fusion_from(message), stamp_ns, wall_s, wall_ns)
            return
        if source.name == "fix":
            row = rows.fix_row(wall_ns, message)
        elif source.name == "velocity":
            row = rows.velocity_row(wall_ns, message)
        elif source.name == "satellites":
            row = rows.satellites_row(wall_ns, message, self.box.now_ns)
        else:
            row = rows.verdict_row(wall_ns, message)
        self.journal.add(row, wall_s)

    def refuse(self, source: Source, error: Exception) -> None:
        """Count a message that `hear` rejected; the first of each topic is logged."""
        why = str(error) if isinstance(error, BadMessage) else f"internal error: {error!r}"
        if not self.refused[source.topic]:
            self._problems.log("warning", f"{source.topic}: message left out: {why}")
        self.refused[source.topic] += 1

    def tick(self) -> None:
        """Write what is due; to be called ten times a second."""
        wall_s, wall_ns = time.monotonic(), time.time_ns()
        if not self._own_folder():
            return
        self.journal.tick(wall_s, wall_ns)
        self._remove_superseded(wall_s, wall_ns)
        self._note_journal()
        for snapshot in self.box.due(wall_s, busy=self._writer.busy):
            self._writer.add(snapshot)
        done = self._writer.poll(wall_s)
        if done is not None:
            self._take(done)

    def close(self) -> None:
        """Finish the snapshot that is being collected, commit everything, end the session."""
        self.box.finish()
        wall_s = time.monotonic()
        if self._own_folder():
            for snapshot in self.box.due(wall_s):
                self._writer.add(snapshot)
            for done in self._writer.finish(wall_s):
                self._take(done)
            self._event("stop", "stopped in order")
            self.journal.close(time.monotonic(), time.time_ns())
        self._lock.release()

    def report(self) -> Report:
        """How it is doing."""
        counts = SnapshotCounts(self._made, self._writer.lost)
        return report(
            self._parameters, self.journal, self.box, counts, self._problems, self.refused
        )

    def _take_fusion(
        self, status: FusionStatus, stamp_ns: int | None, wall_s: float, wall_ns: int
    ) -> None:
        before, self._last = self._last, status
        if before is not None and (before.alert, before.state) == (status.alert, status.state):
            return
        self.journal.add(rows.alert_row(wall_ns, status), wall_s)
        if before is not None and before.alert == status.alert:
            return
        if status.alert:
            self.box.alert(stamp_ns)
        if (status.alert or before is not None) and self._lock.held:
            self.journal.commit(wall_s, wall_ns)
            self.tick()

    def _own_folder(self) -> bool:
        """Whether the folder is locked by us; tries to lock it if it is not."""
        if self._lock.held:
            return True
        if not self._problems.may_retry("folder"):
            return False
        try:
            self._lock.acquire()
            self._snapshots.clean()
        except OSError as error:
            self._lock.release()
            self._problems.set("folder", problem_text(self.folder, error))
            return False
        self._problems.clear("folder")
        self._problems.log("info", f"records into {self.folder}")
        return True

    def _remove_superseded(self, wall_s: float, wall_ns: int) -> None:
        """Remove, once, the parts that a killed run had replaced, unless it announced only them."""
        if self._cleaned or self.journal.problem:
            return
        listed = self.journal.snapshot_paths(wall_s, wall_ns)
        if listed is not None:
            self._cleaned = True
            old = self._snapshots.superseded()
            self._snapshots.remove(one for one in old if f"{SNAPSHOTS}/{one}" not in listed)

    def _take(self, done: Written | Failed) -> None:
        """Announce a snapshot once the journal has it; then what it replaces may go."""
        snapshot = done.snapshot
        if isinstance(done, Failed):
            self._problems.set("snapshot", done.text)
            return
        path = self._snapshots.path / snapshot.directory
        self._problems.clear("snapshot")
        wall_s, wall_ns = time.monotonic(), time.time_ns()
        self._made += snapshot.complete
        self.journal.add(rows.snapshot_row(wall_ns, done), wall_s)
        kept = self.journal.commit(wall_s, wall_ns)
        self._note_journal()
        seconds = (snapshot.messages[-1].log_ns - snapshot.messages[0].log_ns) / 10**9
        what = "snapshot" if snapshot.complete else "what was before the alert"
        self._problems.log("info", f"{what} ({seconds:.1f} s) is in {path}")
        self._announce(path)
        before = self._parts.pop(snapshot.name, None)
        if not snapshot.complete:
            self._parts[snapshot.name] = snapshot.directory
        if kept and before is not None:
            self._snapshots.remove([before])
        if done.excess:
            # The bound holds also while there is no journal to mark them in.
            marked = [f"{SNAPSHOTS}/{name}" for name in done.excess]
            self.journal.mark_removed(marked, wall_s, wall_ns)
            self._snapshots.remove(done.excess)

    def _note_journal(self) -> None:
        for note in self.journal.notes:
            self._problems.note(note)
        self.journal.notes.clear()
        if self.journal.problem:
            self._problems.set("journal", self.journal.problem)
        else:
            self._problems.clear("journal")

    def _event(self, kind: str, text: str) -> None:
        self.journal.add(rows.event_row(time.time_ns(), kind, text), time.monotonic())
