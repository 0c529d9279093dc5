# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A disk that is full, read-only or damaged is told once, and recording goes on afterwards."""

from __future__ import annotations

import resource
import sqlite3
import subprocess
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Protocol

import pytest
from recorded import START_NS, Flown, fix

from hijack_detect.bags.reader import BagReader
from hijack_detect.recording import journal_keeper, problems, schema, snapshots

# A bag that the disk did not take is closed when it is collected.
pytestmark = pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")

RETRIED = (journal_keeper, problems, snapshots)


class Disk(Protocol):
    """A folder whose disk can be full."""

    folder: Path

    def fill(self) -> None: ...
    def free(self) -> None: ...


class SmallDisk:
    """A file system of 2 MB."""

    def __init__(self, folder: Path, *options: str) -> None:
        self.folder = folder
        text = ",".join(("size=2m", *options))
        done = self._run("mount", "-t", "tmpfs", "-o", text, "tmpfs", str(folder))
        if done.returncode:
            pytest.skip(f"no file system can be mounted here: {done.stderr.strip()}")

    def fill(self) -> None:
        with (self.folder / "filler").open("ab", buffering=0) as file:
            try:
                while file.write(bytes(4096)):
                    pass
            except OSError:
                return

    def free(self) -> None:
        (self.folder / "filler").unlink()

    def remount(self, options: str) -> None:
        assert not self._run("mount", "-o", f"remount,{options}", str(self.folder)).returncode

    def close(self) -> None:
        self._run("umount", "-l", str(self.folder))

    def _run(self, *command: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(command, capture_output=True, text=True, check=False)


class LimitedFiles:
    """Files of this process may have 4 kB and no more: as root, too, everything larger fails."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill(self) -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, self._before[1]))

    def free(self) -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, self._before)

    close = free


@pytest.fixture(params=[SmallDisk, LimitedFiles])
def disk(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Disk]:
    made = request.param(tmp_path)
    yield made
    made.close()


@pytest.fixture
def read_only(tmp_path: Path) -> Iterator[SmallDisk]:
    """A file system that cannot be written; permission bits would not stop root."""
    made = SmallDisk(tmp_path, "ro")
    yield made
    made.close()


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in RETRIED:
        monkeypatch.setattr(module, "RETRY_S", 0.05)


def errors(flown: Flown) -> list[str]:
    return [text for level, text in flown.told if level == "error"]


def select(folder: Path, statement: str) -> list[tuple[object, ...]]:
    with closing(sqlite3.connect(folder / schema.FILE)) as database:
        return database.execute(statement).fetchall()


def test_a_full_disk_is_told_once_and_nothing_is_lost_when_there_is_room_again(disk: Disk) -> None:
    flown = Flown(disk.folder / "kept", before_s=5, after_s=2)
    flown.fly(10)
    flown.tick_until(lambda: not flown.recorder.journal.waiting)
    disk.fill()
    for _ in range(60):
        flown.fly(5)
        flown.recorder.tick()
    flown.fly(3, alert=True)
    flown.fly(3)
    flown.tick_until(lambda: len(flown.recorder.report().text.split("; ")) >= 3)
    report = flown.recorder.report()
    assert report.level == "error"
    assert schema.FILE in report.text
    assert "snapshots/alert_" in report.text
    assert "make room" in report.text or "whether it is full" in report.text
    again = time.monotonic() + 0.3
    flown.tick_until(lambda: time.monotonic() > again and flown.recorder.journal.problem)
    assert len(errors(flown)) == 2

    disk.free()
    flown.tick_until(lambda: flown.recorder.report().level == "info" and flown.announced)
    flown.tick_until(lambda: not flown.announced[-1].name.endswith("part1"))
    flown.recorder.close()
    with BagReader(flown.announced[-1]) as reader:
        assert reader.duration_s == pytest.approx(7.0, abs=0.3)
    stamps = select(disk.folder / "kept", "SELECT stamp_ns FROM fixes ORDER BY id")
    assert len(stamps) == len(set(stamps)) == 316 * 5
    kinds = [kind for (kind,) in select(disk.folder / "kept", "SELECT kind FROM events")]
    assert sorted(kinds) == ["problem", "problem", "recovered", "recovered", "start", "stop"]


def test_a_read_only_folder_is_reported_until_it_is_not(read_only: SmallDisk) -> None:
    flown = Flown(read_only.folder / "kept")
    flown.fly(5)
    flown.fly(5, alert=True)
    flown.tick_until(lambda: flown.recorder.report().level == "error")
    (text,) = errors(flown)
    assert text.endswith("make the folder writable, or choose another 'folder'")
    read_only.remount("rw")
    flown.tick_until(lambda: flown.announced)
    flown.recorder.close()
    assert select(read_only.folder / "kept", "SELECT count(*) FROM fixes") == [(50,)]
    assert flown.announced[-1].is_dir()


def test_a_folder_that_cannot_be_made_ends_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    flown = Flown(tmp_path / "file/kept")
    flown.fly(1)
    assert "Not a directory" in flown.recorder.report().text
    flown.recorder.close()


def test_two_recorders_do_not_share_a_folder(tmp_path: Path) -> None:
    first, second = Flown(tmp_path), Flown(tmp_path)
    assert first.recorder.report().level == "info"
    assert "give each one a 'folder' of its own" in second.recorder.report().text
    second.fly(1)
    first.recorder.close()
    second.tick_until(lambda: second.recorder.report().level == "info")
    second.recorder.close()
    assert select(tmp_path, "SELECT count(*) FROM fixes") == [(5,)]


def test_rows_that_find_no_room_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal_keeper, "MAX_BULK", 20)
    (tmp_path / "file").touch()
    flown = Flown(tmp_path / "file/kept")
    for index in range(25):
        flown.receive("fix", fix(START_NS + index))
    assert flown.recorder.report().values["dropped fixes"] == "5"
    (tmp_path / "file").unlink()
    flown.tick_until(lambda: not flown.recorder.journal.waiting)
    flown.recorder.close()
    found = select(tmp_path / "file/kept", "SELECT min(stamp_ns), count(*) FROM fixes")
    assert found == [(START_NS + 5, 20)]


def test_a_file_that_is_no_journal_is_moved_aside(tmp_path: Path) -> None:
    (tmp_path / schema.FILE).write_bytes(b"an old diary" * 500)
    flown = Flown(tmp_path)
    (text,) = errors(flown)
    assert "is damaged or not a database; moved aside as journal.sqlite3.damaged-" in text
    flown.fly(1)
    flown.recorder.close()
    (aside,) = tmp_path.glob("journal.sqlite3.damaged-*")
    assert aside.read_bytes() == b"an old diary" * 500
    assert select(tmp_path, "SELECT count(*) FROM fixes") == [(5,)]


def test_damage_in_the_middle_is_found_and_moved_aside(tmp_path: Path) -> None:
    flown = Flown(tmp_path)
    flown.fly(300)
    flown.recorder.close()
    file = tmp_path / schema.FILE
    content = bytearray(file.read_bytes())
    content[4096:] = b"\xa5" * (len(content) - 4096)
    file.write_bytes(content)
    flown = Flown(tmp_path)
    flown.fly(1)
    flown.tick_until(lambda: flown.recorder.report().level == "info")
    flown.recorder.close()
    assert len(list(tmp_path.glob("journal.sqlite3.damaged-*"))) == 1
    assert select(tmp_path, "SELECT count(*) FROM fixes") == [(5,)]


def test_a_newer_journal_is_left_alone_and_the_black_box_goes_on(tmp_path: Path) -> None:
    Flown(tmp_path).recorder.close()
    select(tmp_path, f"PRAGMA user_version = {schema.VERSION + 1}")
    flown = Flown(tmp_path, before_s=5, after_s=2)
    flown.fly(5)
    flown.fly(3, alert=True)
    flown.tick_until(lambda: flown.announced)
    assert "was written by a newer version" in flown.recorder.report().text
    flown.recorder.close()
    assert select(tmp_path, "SELECT count(*) FROM fixes") == [(0,)]


def test_a_deleted_folder_is_made_again(tmp_path: Path) -> None:
    flown = Flown(tmp_path / "kept")
    flown.fly(1)
    flown.tick_until(lambda: not flown.recorder.journal.waiting)
    (tmp_path / "kept").rename(tmp_path / "away")
    flown.fly(1)
    flown.tick_until(lambda: not flown.recorder.journal.waiting)
    flown.recorder.close()
    assert "was deleted or replaced" in errors(flown)[0]
    assert select(tmp_path / "kept", "SELECT count(*) FROM fixes") == [(5,)]
