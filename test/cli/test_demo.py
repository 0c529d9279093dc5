# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect` as its user runs it, with all nodes as processes."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import psutil
import pytest
from ros import ROOT

from hijack_detect import __version__
from hijack_detect.bags.reader import BagReader
from hijack_detect.nodes import MONITOR

PROGRAM = Path(sys.executable).with_name("hijack-detect")
BAG = ROOT / "bags/curved_8"
TIMEOUT_S = 90.0
STOP_S = 8.0


class Command:
    """A running `hijack-detect`, in a ROS domain of its own."""

    def __init__(self, domain: int, folder: Path, *arguments: str) -> None:
        self.domain = domain
        self.logs = folder / "logs"
        self._process = subprocess.Popen(
            [str(PROGRAM), *arguments],
            cwd=ROOT,
            env={**os.environ, "ROS_DOMAIN_ID": str(domain), "COLUMNS": "100"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def end(self, timeout_s: float = TIMEOUT_S) -> tuple[int, str]:
        """Wait for its end; return exit code and output."""
        printed, _ = self._process.communicate(timeout=timeout_s)
        return self._process.returncode, printed

    def interrupt(self) -> None:
        """Press Ctrl-C: only this process hears it, the nodes have sessions of their own."""
        self._process.send_signal(signal.SIGINT)

    def until(self, condition: Callable[[], object], what: str) -> None:
        deadline = time.monotonic() + TIMEOUT_S
        while not condition():
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(0.02)
            assert self._process.poll() is None, f"it ended before {what}"
            assert time.monotonic() < deadline, f"no {what}"

    def log(self, node: str) -> str:
        path = self.logs / f"{node}.log"
        return path.read_text() if path.exists() else ""

    def close(self) -> None:
        for process in (*others_in(self.domain), self._process):
            with suppress(psutil.NoSuchProcess, ProcessLookupError):
                process.kill()
        self._process.wait()


def others_in(domain: int) -> list[psutil.Process]:
    """Every process of a ROS domain but this one."""
    found = []
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            same = process.environ().get("ROS_DOMAIN_ID") == str(domain)
            if same and process.pid != os.getpid() and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
    return found


Start = Callable[..., Command]


@pytest.fixture
def start(domain: int, tmp_path: Path) -> Iterator[Start]:
    running: list[Command] = []

    def begin(*arguments: str) -> Command:
        running.append(Command(domain, tmp_path, *arguments))
        return running[-1]

    yield begin
    for one in running:
        one.close()


def refusal(start: Start, *arguments: str) -> str:
    """What is printed by a command that refuses its input."""
    code, printed = start(*arguments).end()
    assert code == 2, printed
    assert "Traceback" not in printed
    return printed.strip()


@pytest.mark.slow
@pytest.mark.parametrize("policy", ["--default", "--paper"])
def test_the_demonstration_shows_the_attack_and_its_alert(start: Start, policy: str) -> None:
    demo = start("demo", "--rate", "8", policy)
    code, printed = demo.end()
    assert code == 0, printed
    rows = {event: row for row in printed.splitlines() for event in EVENTS if event in row}
    assert list(rows) == list(dict.fromkeys(rows)), printed
    assert set(rows) == set(EVENTS), printed
    onset, alert = (float(seconds_of(rows[event])) for event in ("attack begins", "hijack_alert"))
    assert onset == 60.0
    assert 60.0 < alert < 70.0
    assert re.search(r"Detected \d\.\d s after the onset, .* \d+\.\d m", printed), printed
    assert "Cause: " in printed
    assert f"{len(MONITOR) + 1} processes over DDS" in printed
    assert others_in(demo.domain) == []


EVENTS = ("attack begins", "attack ends", "correlation: first alarm", "date: first alarm",
          "hijack_alert")  # fmt: skip


def seconds_of(row: str) -> str:
    """The first column of a row of the timeline."""
    found = re.search(r"\d+\.\d", row)
    assert found is not None, row
    return found[0]


@pytest.mark.slow
def test_simulate_a_flight_and_replay_it_without_attack(start: Start, tmp_path: Path) -> None:
    bag = tmp_path / "flight"
    made = ("simulate", str(bag), "--duration", "60", "--seed", "4", "--without", "mag")
    code, printed = start(*made).end()
    assert code == 0, printed
    assert f"{bag}: 60 s, route curved" in printed
    with BagReader(bag) as reader:
        assert reader.duration_s == pytest.approx(60.0, abs=0.1)
        assert "/mag" not in reader.topics
    assert str(bag) in refusal(start, *made)

    demo = start(
        "demo", "--bag", str(bag), "--scenario", "none", "--rate", "10", "--logs", str(tmp_path)
    )
    code, printed = demo.end()
    assert code == 0, printed
    assert "No alert, and no attack." in printed
    assert "attack begins" not in printed
    assert {path.stem for path in tmp_path.glob("*.log")} == {*MONITOR, "bag_replay"}
    assert others_in(demo.domain) == []


def test_what_cannot_be_used_is_refused_in_a_line(start: Start, tmp_path: Path) -> None:
    missing = str(tmp_path / "missing")
    told = refusal(start, "demo", "--bag", missing)
    assert told == f"Error: {missing}: does not exist; check the path"
    (tmp_path / "empty").mkdir()
    assert str(tmp_path / "empty") in refusal(start, "demo", "--bag", str(tmp_path / "empty"))
    outside = refusal(start, "demo", "--onset", "105")
    assert re.fullmatch(r"Error: .*turn_away_track\.yaml: .* outside the flight, .*", outside)
    unknown = refusal(start, "demo", "--scenario", "no_such_scenario")
    assert unknown.startswith("Error: no_such_scenario: cannot be read")


@pytest.mark.parametrize("node", ["attitude_estimator", "bag_replay"])
def test_ctrl_c_leaves_nothing_behind(start: Start, tmp_path: Path, node: str) -> None:
    logs = tmp_path / "logs"
    demo = start("demo", "--rate", "1", "--logs", str(logs))
    # The first node has only just been started; the replay says what it publishes when all run.
    if node == "bag_replay":
        demo.until(lambda: "publishes" in demo.log(node), "the replay")
    else:
        demo.until((logs / f"{node}.log").exists, node)
    began = time.monotonic()
    demo.interrupt()
    code, printed = demo.end(STOP_S)
    assert time.monotonic() - began < STOP_S
    assert code != 0
    assert "Traceback" not in printed, printed
    assert others_in(demo.domain) == []


@pytest.mark.parametrize("policy", ["default", "paper"])
def test_params_prints_the_committed_file(start: Start, policy: str) -> None:
    code, printed = start("params", "--policy", policy).end()
    assert code == 0
    assert printed == (ROOT / f"config/{policy}.yaml").read_text()


def test_version_help_and_usage(start: Start) -> None:
    code, said = start("--version").end()
    assert (code, said.startswith(f"hijack-detect, version {__version__} (Python ")) == (0, True)
    for arguments in (["--help"], ["-h"]):
        code, printed = start(*arguments).end()
        assert code == 0
        assert all(name in printed for name in ("demo", "simulate", "params"))
    code, printed = start("demo", "--help").end()
    assert code == 0
    assert all(option in printed for option in ("--bag", "--scenario", "--onset", "--rate"))
    assert "'all'" in refusal(start, "params", "--policy", "all")
    both = ("params", "--policy", "paper", "--node", "recorder")
    assert "not both" in refusal(start, *both)
    assert "--rate" in refusal(start, "demo", "--rate", "0")
    assert "OUT" in refusal(start, "simulate")
    assert "duration" in refusal(start, "simulate", "nowhere", "--duration", "-1")
    assert not Path(ROOT, "nowhere").exists()
