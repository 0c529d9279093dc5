# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The shells complete the command, quickly; the names that they offer are those that there are."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click import Command, Context
from click.testing import CliRunner
from command import hijack_detect
from ros import ROOT

from hijack_detect.cli import completion
from hijack_detect.cli.completion import SHELLS
from hijack_detect.cli.main import COMMANDS, main
from hijack_detect.cli.parameter_files import OTHER_NODES
from hijack_detect.monitor.policies import POLICIES
from hijack_detect.recording.schema import TABLES
from hijack_detect.simulation.plan import ROUTES

PROGRAM = Path(sys.prefix, "bin/hijack-detect")
SOON_S = 0.6
"""Twice what it takes beside three other processes on two cores."""


def offered(line: str) -> list[str]:
    """What is offered at the end of a line, by click's protocol."""
    words = line.split(" ")
    asked = {
        "_HIJACK_DETECT_COMPLETE": "bash_complete",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
    }
    environment = {key: value for key, value in os.environ.items() if key != "AMENT_PREFIX_PATH"}
    done = subprocess.run(
        [PROGRAM], env={**environment, **asked}, capture_output=True, text=True, check=True
    )
    assert done.stderr == ""
    return [one.partition(",")[2] for one in done.stdout.splitlines()]


@pytest.mark.parametrize(
    ("line", "some"),
    [
        ("hijack-detect a", {"analyze"}),
        ("hijack-detect analyze flight --scenario t", {"turn_away", "turn_away_track"}),
        ("hijack-detect inject in out --scenario ju", {"jump"}),
        ("hijack-detect demo --scenario n", {"none"}),
        ("hijack-detect analyze --policy ", {"default", "paper"}),
        ("hijack-detect params --node r", {"recorder"}),
        ("hijack-detect journal v", {"verdicts", "velocities"}),
        ("hijack-detect journal folder verdicts --detector d", {"date", "drag"}),
        ("hijack-detect journal folder verdicts --state a", {"alarm"}),
        ("hijack-detect completion f", {"fish"}),
        ("hijack-detect --v", {"--version"}),
    ],
)
def test_values_are_offered(line: str, some: set[str]) -> None:
    assert set(offered(line)) - {line.rpartition(" ")[2]} == some


def test_offers_come_soon() -> None:
    taken = []
    for _ in range(3):
        begin = time.monotonic()
        assert "--scenario" in offered("hijack-detect analyze --s")
        taken.append(time.monotonic() - begin)
    assert min(taken) < SOON_S


def test_names_are_those_that_there_are() -> None:
    assert tuple(POLICIES) == completion.POLICY_NAMES
    assert tuple(OTHER_NODES) == completion.OTHER_NODES
    assert set(completion.TABLE_NAMES) == set(TABLES)
    assert completion.ROUTES == ROUTES


def test_every_command_can_be_loaded_and_is_listed() -> None:
    listed = CliRunner().invoke(main, ["--help"]).output
    for name, (_, text) in COMMANDS.items():
        command = main.get_command(Context(main), name)
        assert isinstance(command, Command)
        assert command.name == name
        assert f"  {name} " in listed
        assert text in listed
    assert main.get_command(Context(main), "nothing") is None


@pytest.mark.parametrize("shell", SHELLS)
def test_shells_take_the_script(shell: str) -> None:
    program = shutil.which(shell)
    script = CliRunner().invoke(main, ["completion", shell])
    assert script.exit_code == 0, script.output
    assert "_HIJACK_DETECT_COMPLETE" in script.output
    if program is None:
        pytest.skip(f"{shell} is not installed")
    done = subprocess.run(
        [program, "-n"], input=script.output, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_bash_completes() -> None:
    path = {"PATH": f"{PROGRAM.parent}:{os.environ['PATH']}"}
    script = (
        "source <(hijack-detect completion bash); complete -p hijack-detect; "
        "COMP_WORDS=(hijack-detect con); COMP_CWORD=1; "
        '_hijack_detect_completion hijack-detect con hijack-detect; echo "offers ${COMPREPLY[*]}"'
    )
    done = subprocess.run(
        ["bash", "-c", script],
        env={**os.environ, **path},
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
    )
    assert "-F _hijack_detect_completion hijack-detect" in done.stdout, done.stderr
    assert "offers convert" in done.stdout


def test_an_unknown_shell_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHELL", "/bin/dash")
    done = CliRunner().invoke(main, ["completion"])
    assert done.exit_code == 2
    assert "name the shell: bash, zsh, fish" in done.stderr
    monkeypatch.setenv("SHELL", "/usr/bin/zsh")
    assert CliRunner().invoke(main, ["completion"]).output.startswith("#compdef hijack-detect")


def test_unknown_commands_are_refused() -> None:
    done = hijack_detect("analyse")
    assert done.returncode == 2
    assert "No such command 'analyse'" in done.stderr
