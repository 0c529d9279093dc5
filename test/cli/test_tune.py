# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `tune`, as it is typed."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from command import hijack_detect
from ros import ROOT

from hijack_detect.cli.parameter_files import load_parameters
from hijack_detect.detectors.date import DateParameters
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.simulated_bag import make_bag
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.spoofing.scenario import load_scenario


@pytest.fixture(scope="module")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clean flight, a hijacked one, and a file that is no bag."""
    folder = tmp_path_factory.mktemp("corpus")
    turn_away = load_scenario(ROOT / "config/scenarios/turn_away.yaml")
    segment = turn_away.segments[0].model_copy(update={"start_s": 36.0, "end_s": 50.0})
    make_bag(folder / "clean", FlightPlan("curved", duration_s=90.0), 4)
    attack = dataclasses.replace(turn_away, segments=(segment,))
    make_bag(folder / "hijacked", FlightPlan("curved", duration_s=60.0), 5, scenario=attack)
    (folder / "broken.mcap").write_bytes(b"no bag")
    return folder


@pytest.mark.slow
def test_it_writes_parameters_that_the_nodes_take(corpus: Path, tmp_path: Path) -> None:
    files = [tmp_path / "one.yaml", tmp_path / "two.yaml"]
    for file in files:
        done = hijack_detect("tune", corpus, "-o", file, "--scenario", "none", "--jobs", "1")
        assert done.returncode == 0, done.stderr
        assert len(done.stderr.splitlines()) == 1
        assert "broken.mcap" in done.stderr
    assert files[0].read_bytes() == files[1].read_bytes()
    tuned, default = load_parameters(files[0]), policy_parameters("default")
    assert tuned.of(DateParameters).threshold != default.of(DateParameters).threshold
    assert tuned.fusion == default.fusion
    text = files[0].read_text(encoding="utf-8")
    assert text.startswith("# Parameters of hijack_detect, policy `default`, tuned by")
    for said in ("Flights: clean (0.03 h", "Requested: 1 false alarm", "1/1 100.0 %"):
        assert said in text
    for said in ("GPS lag", "Thresholds", "Alarms on clean flights", "Attacks detected"):
        assert said in done.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nowhere", "-o", "out.yaml"), "nowhere"),
        (("nowhere", "-o", "/no/such/out.yaml"), "/no/such: is no folder"),
        (("nowhere", "-o", "out.yaml", "--scenario", "no_such"), "no_such: cannot be read"),
        (("nowhere", "-o", "out.yaml", "--false-alarms-per-hour", "0"), "0.0 is not in the range"),
        (("nowhere",), "'-o'"),
    ],
)
def test_what_it_refuses(arguments: tuple[str, ...], said: str) -> None:
    done = hijack_detect("tune", *arguments)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
