# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""`hijack-detect analyze` as its user runs it."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import psutil
import pytest
from ros import ROOT
from small_bags import START_NS, STEP_NS, flight, raw, write

from hijack_detect.analysis.analysis import Analysis, Outcome
from hijack_detect.streams.samples import ImuSample

PROGRAM = Path(sys.executable).with_name("hijack-detect")
CURVED = ROOT / "bags/curved_8"
STRAIGHT = ROOT / "bags/straight_3"
TIMEOUT_S = 90.0


def analyze(*arguments: object, code: int | None) -> tuple[str, str]:
    """Run it and return what it prints to stdout and stderr; None stands for both 0 and 10."""
    done = subprocess.run(
        [str(PROGRAM), "analyze", *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, "COLUMNS": "100"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    said = done.stderr + done.stdout
    assert done.returncode in ((0, 10) if code is None else (code,)), said
    assert "Traceback" not in done.stderr
    return done.stdout, done.stderr


def refusal(*arguments: object) -> str:
    printed, told = analyze(*arguments, code=2)
    assert printed == ""
    return told.strip()


@pytest.mark.parametrize("policy", ["default", "paper"])
def test_an_alert_is_exit_code_10_and_json_is_alone_on_stdout(policy: str) -> None:
    arguments = ("--scenario", "turn_away_track", "--policy", policy, "--json", "-")
    printed, told = analyze(CURVED, *arguments, code=10)
    found = Analysis.model_validate_json(printed)
    assert printed == found.model_dump_json(indent=2) + "\n"
    assert told == ""
    assert found.outcome is Outcome.DETECTED
    assert found.policy == policy
    assert found.bag == str(CURVED)


def test_without_json_it_says_the_verdict_and_shows_the_detectors() -> None:
    printed, told = analyze(STRAIGHT, code=0)
    assert printed.startswith("No ")
    assert "in the air a pull of" in printed
    assert "correlation" in printed
    assert "largest margin" in printed
    assert "straight_3" in printed
    assert told == ""


def test_parameters_from_a_file_replace_the_policy(tmp_path: Path) -> None:
    params = tmp_path / "any.yaml"
    params.write_text("/**/fusion:\n  ros__parameters:\n    policy: any\n")
    out = tmp_path / "analysis.json"
    arguments = ("--params", params, "--policy", "paper", "--json", out)
    assert analyze(STRAIGHT, *arguments, code=0) == ("", "")
    assert json.loads(out.read_text())["policy"] == "any"


def test_a_scenario_by_its_path(tmp_path: Path) -> None:
    scenario = tmp_path / "jump.yaml"
    scenario.write_text(
        "segments:\n  - {start: 40.0, model: {type: jump, distance_m: 80.0, bearing_deg: 90.0}}\n"
    )
    printed, _ = analyze(STRAIGHT, "--scenario", scenario, "--json", "-", code=None)
    found = Analysis.model_validate_json(printed)
    assert found.spoof is not None
    assert (found.spoof.onset_s, found.spoof.end_s) == (40.0, None)
    assert found.scenario == str(scenario)


def test_refused_messages_are_counted_and_told_on_stderr(tmp_path: Path) -> None:
    bad = raw(
        "/imu/data_raw",
        ImuSample(START_NS + STEP_NS // 2, (0.0, 0.0, 0.0), (math.inf, 0.0, 9.8)),
    )
    bag = write(tmp_path / "bad", sorted([*flight(6.0), bad], key=lambda one: one.log_ns))
    printed, told = analyze(bag, "--json", "-", code=3)
    reason = "/imu/data_raw: linear_acceleration.x out of range"
    assert json.loads(printed)["skipped"] == {reason: 1}
    assert "1 refused" in told
    printed, _ = analyze(bag, code=3)
    assert printed.startswith("The flight could not be judged: ")
    assert reason in printed


@pytest.mark.slow
def test_what_cannot_be_used_is_refused_in_a_line(tmp_path: Path) -> None:
    missing = tmp_path / "missing"
    assert refusal(missing) == f"Error: {missing}: does not exist; check the path"
    assert "no_such: cannot be read" in refusal(CURVED, "--scenario", "no_such")
    assert "no_such.yaml" in refusal(CURVED, "--params", "no_such.yaml")
    assert "BAG" in refusal()

    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("/**/fusion:\n  ros__parameters:\n    polizy: any\n")
    assert f"{wrong}: fusion: unknown parameter 'polizy'" in refusal(CURVED, "--params", wrong)
    wrong.write_text("segments: [{start: 500.0, model: {type: freeze}}]\n")
    assert "outside the flight" in refusal(CURVED, "--scenario", wrong, "--json", "-")
    wrong.write_text("segments: 3\n")
    assert str(wrong) in refusal(CURVED, "--scenario", wrong)

    whole = next(CURVED.glob("*.mcap")).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) // 2])
    assert str(cut) in refusal(cut, "--json", "-")
    assert str(tmp_path / "no") in refusal(STRAIGHT, "--json", tmp_path / "no/a.json")
    assert str(cut) in refusal(STRAIGHT, "--report", cut)


def test_ctrl_c_ends_it_without_a_traceback() -> None:
    process = psutil.Popen(
        [str(PROGRAM), "analyze", str(CURVED)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + TIMEOUT_S
    opened = False
    while not opened and process.poll() is None and time.monotonic() < deadline:
        with suppress(psutil.Error):
            opened = any(one.path.endswith(".mcap") for one in process.open_files())
    assert opened
    process.send_signal(signal.SIGINT)
    printed, told = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode in (1, 130)
    assert printed == ""
    assert told.strip() == "Aborted!"


@pytest.mark.parametrize(
    ("command", "library"),
    [
        (("analyze", STRAIGHT, "--report", "out"), "plotly"),
        (("evaluate", ROOT / "bags"), "scipy"),
    ],
)
def test_a_missing_library_of_the_analysis_is_named(
    command: tuple[object, ...], library: str, tmp_path: Path
) -> None:
    without = (
        "import sys; sys.modules.update(dict.fromkeys(('matplotlib', 'plotly', 'scipy')));"
        "from hijack_detect.cli.main import main; main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", without, *map(str, command)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert done.returncode == 2
    assert f"this needs {library}" in done.stderr
    assert "[analysis]" in done.stderr
    assert "Traceback" not in done.stderr
