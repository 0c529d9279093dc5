# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `journal`, as it is typed."""

from __future__ import annotations

import csv
import io
import json
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from command import hijack_detect
from recorded import SECOND, START_NS, Flown

from hijack_detect.cli.main import main
from hijack_detect.recording import schema
from hijack_detect.recording.journal_reader import nanoseconds, utc

ALERT_NS = START_NS + 20 * SECOND + SECOND // 5
CURVE = "2025-11-24T16:00:20.200Z"
"""The time of the alert."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recorder's folder after 40 s of flight with an alert at 20.2 s."""
    path = tmp_path_factory.mktemp("kept")
    flown = Flown(path, before_s=10, after_s=5)
    flown.fly(20)
    flown.fly(20, alert=True)
    flown.tick_until(lambda: flown.announced)
    flown.recorder.close()
    return path


def journal(*arguments: object) -> Result:
    """Run the command in this process."""
    return CliRunner().invoke(main, ["journal", *map(str, arguments)])


def exported(*arguments: object) -> list[dict[str, str]]:
    done = journal(*arguments, "--csv", "-")
    assert done.exit_code == 0, done.output
    return list(csv.DictReader(io.StringIO(done.stdout)))


def refused(*arguments: object) -> str:
    """The one line that it ends with."""
    done = journal(*arguments)
    assert done.exit_code == 2, done.output
    assert done.stdout == ""
    lines = [line for line in done.stderr.splitlines() if line.startswith("Error: ")]
    assert len(lines) == 1
    return lines[0]


def test_the_overview_says_what_there_is(folder: Path) -> None:
    done = hijack_detect("journal", folder)
    assert (done.returncode, done.stderr) == (0, "")
    for text in ("MB", "fixes", "200", "sessions", "/recorder", "alerts", "ALERT", "snapshots"):
        assert text in done.stdout
    assert "snapshots/alert_20251124T160020.200Z" in done.stdout
    assert CURVE in done.stdout


@pytest.mark.parametrize("table", schema.TABLES)
def test_every_table_is_shown_and_exported(folder: Path, table: str) -> None:
    shown = journal(folder, table)
    assert shown.exit_code == 0, shown.output
    assert table in shown.stdout
    rows = exported(folder / schema.FILE, table)
    assert rows
    assert list(rows[0]) == ["time", "id", *schema.TABLES[table]]
    found = json.loads(journal(folder, table, "--json", "-").stdout)
    assert [str(one["id"]) for one in found] == [one["id"] for one in rows]


def test_filters_choose_rows(folder: Path) -> None:
    assert len(exported(folder, "fixes")) == 200
    assert len(exported(folder, "fixes", "--since", CURVE)) == 100
    assert len(exported(folder, "fixes", "--until", str(ALERT_NS / SECOND))) == 100
    assert [one["id"] for one in exported(folder, "fixes", "--last", 2)] == ["199", "200"]
    assert [one["id"] for one in exported(folder, "fixes", "--limit", 2)] == ["1", "2"]
    assert len(exported(folder, "verdicts", "--detector", "date", "--state", "normal")) == 200
    assert exported(folder, "verdicts", "--detector", "nobody") == []
    (alert,) = exported(folder, "alerts", "--state", "alarm")
    assert (alert["time"], alert["stamp_ns"], alert["causes"]) == (CURVE, str(ALERT_NS), "date")


def test_json_has_numbers_as_numbers(folder: Path, tmp_path: Path) -> None:
    done = journal(folder, "verdicts", "--last", 1, "--json", tmp_path / "out.json")
    assert done.stdout == ""
    assert "1 verdicts" in done.stderr
    (row,) = json.loads((tmp_path / "out.json").read_text())
    assert row["numbers"] == {"delta_ax": 0.5}
    assert (row["score"], row["threshold"]) == (0.25, 1.0)
    assert json.loads(journal(folder, "verdicts", "--state", "stale", "--json", "-").stdout) == []


def test_the_terminal_shows_the_last_rows_and_says_so(folder: Path) -> None:
    assert "fixes, 50 of 200" in journal(folder, "fixes").stdout
    assert "fixes, 3 of 200" in journal(folder, "fixes", "--limit", 3).stdout
    assert "no fixes that fit" in journal(folder, "fixes", "--until", "1970-01-02").stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("{}/nowhere",), "nowhere: does not exist; name the journal or its folder"),
        (("{}", "flights"), "there is no table 'flights'"),
        (("{}", "fixes", "--since", "noon"), "'noon' is no time; give seconds, or ISO as"),
        (("{}", "fixes", "--since", "1e30"), "'1e30' is no time in seconds"),
        (("{}", "fixes", "--state", "normal"), "fixes have no state; alerts and verdicts have one"),
        (("{}", "alerts", "--detector", "date"), "alerts have no detector; verdicts have one"),
        (("{}", "--csv", "-"), "name a TABLE"),
        (("{}", "fixes", "--csv", "-", "--json", "-"), "give one"),
        (("{}", "fixes", "--limit", "1", "--last", "1"), "give one"),
        (("{}", "fixes", "--csv", "{}/no/such/folder"), "cannot be written: No such file"),
        (("{}", "fixes", "fixes"), "give at most a journal and a table"),
    ],
)
def test_what_cannot_be_done_is_one_line(
    folder: Path, arguments: tuple[str, ...], said: str
) -> None:
    assert said in refused(*(one.format(folder) for one in arguments))


def test_files_that_are_no_journal_are_one_line(folder: Path, tmp_path: Path) -> None:
    text = tmp_path / "text"
    text.write_text("no database, but long enough to look like one" * 20)
    assert "cannot be read as a journal (file is not a database)" in refused(text, "fixes")
    other = tmp_path / "other.sqlite3"
    with closing(sqlite3.connect(other)) as database:
        database.execute("CREATE TABLE fixes (id)")
    assert "is not a journal of the recorder" in refused(other, "fixes")
    newer = Path(shutil.copy(folder / schema.FILE, tmp_path))
    with closing(sqlite3.connect(newer)) as database:
        database.execute("PRAGMA user_version = 99")
    assert "newer version (schema 99, this one knows 1); update" in refused(newer, "fixes")


def test_damage_in_the_middle_is_one_line(folder: Path, tmp_path: Path) -> None:
    damaged = Path(shutil.copy(folder / schema.FILE, tmp_path))
    content = bytearray(damaged.read_bytes())
    content[3 * 4096 :] = b"\xa5" * (len(content) - 3 * 4096)
    damaged.write_bytes(content)
    assert "cannot be read" in refused(damaged, "fixes")


@pytest.fixture
def read_only(tmp_path: Path) -> Iterator[Path]:
    """A file system that cannot be written; permission bits would not stop root."""
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "tmpfs", tmp_path], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip("no file system can be mounted here")
    yield tmp_path
    subprocess.run(["umount", "-l", tmp_path], check=False)


@pytest.mark.parametrize("killed", [False, True])
def test_a_copy_on_a_read_only_disk_opens(folder: Path, read_only: Path, killed: bool) -> None:
    """Also that of a killed recorder, whose newest rows are in the log."""
    shutil.copy(folder / schema.FILE, read_only)
    if killed:
        with closing(sqlite3.connect(read_only / schema.FILE)) as database:
            database.execute("UPDATE satellites SET count = 3")
            database.commit()
            for suffix in ("", "-wal"):
                shutil.copy(f"{read_only / schema.FILE}{suffix}", f"{read_only}/copy{suffix}")
        (read_only / "copy").rename(read_only / schema.FILE)
        (read_only / "copy-wal").rename(read_only / f"{schema.FILE}-wal")
    subprocess.run(["mount", "-o", "remount,ro", read_only], check=True)
    assert {one["count"] for one in exported(read_only, "satellites")} == {"3" if killed else "9"}


def test_it_reads_beside_a_recorder_that_writes(tmp_path: Path) -> None:
    flown = Flown(tmp_path)
    flown.fly(20)
    flown.tick_until(lambda: not flown.recorder.journal.waiting)
    assert len(exported(tmp_path, "fixes")) == 100
    flown.fly(20)
    flown.tick_until(lambda: not flown.recorder.journal.waiting)
    assert len(exported(tmp_path, "fixes")) == 200
    flown.recorder.close()
    assert not [text for level, text in flown.told if level == "error"]


@pytest.mark.slow
def test_a_day_is_exported_without_growing_memory(tmp_path: Path) -> None:
    Flown(tmp_path).recorder.close()
    with closing(sqlite3.connect(tmp_path / schema.FILE)) as database:
        database.execute(
            "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 432000) "
            "INSERT INTO fixes SELECT i, 1, i, i * 200000000, 48.0, 11.0, 500.0, 0, 1.0, 1.0, 1.0 "
            "FROM n"
        )
        database.commit()
    program = (
        "import resource, sys\n"
        "from hijack_detect.cli.main import main\n"
        "main(['journal', *sys.argv[1:]], standalone_mode=False)\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)\n"
    )
    memory = []
    for limit in (1000, 432_000):
        out = tmp_path / f"{limit}.csv"
        command = [sys.executable, "-c", program, tmp_path, "fixes", "--limit", limit, "--csv", out]
        done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=True)
        memory.append(int(done.stdout.split()[-1]) * 1024)
        with out.open() as file:
            assert sum(1 for _ in file) == limit + 1
    assert memory[1] - memory[0] < 20_000_000


@pytest.mark.parametrize(
    ("text", "ns"),
    [
        ("1764000020.2", ALERT_NS),
        (CURVE, ALERT_NS),
        ("2025-11-24T16:00:20.200", ALERT_NS),
        ("2025-11-24T17:00:20.200+01:00", ALERT_NS),
        ("2025-11-24", ALERT_NS - ALERT_NS % (86_400 * SECOND)),
        ("-1", -SECOND),
    ],
)
def test_times_are_read(text: str, ns: int) -> None:
    assert nanoseconds(text) == ns


def test_times_are_shown_to_the_millisecond() -> None:
    assert utc(ALERT_NS + 999_999) == CURVE
    assert utc(0) == "1970-01-01T00:00:00.000Z"
    assert utc(None) == ""
