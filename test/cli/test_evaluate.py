# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The command `hijack-detect evaluate` as its user runs it."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import psutil
import pytest
from ros import ROOT
from small_bags import flight, write

from hijack_detect.cli.evaluate import PROTOCOLS
from hijack_detect.evaluation.scores.evaluate import Evaluation
from hijack_detect.evaluation.scores.methods import Judgement
from hijack_detect.evaluation.trials.protocols import PROTOCOLS as MADE

PROGRAM = Path(sys.executable).with_name("hijack-detect")
SITL = ROOT.parent / "shared" / "flights" / "sitl"
METHODS = ["ins_position", "correlation", "date", "both", "kld", "coast", "gnss", "altitude",
           "heading", "drag", "fusion"]  # fmt: skip


def evaluate(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(PROGRAM), "evaluate", *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, "COLUMNS": "120"},
        capture_output=True,
        text=True,
        timeout=120.0,
        check=False,
    )


def refusal(*arguments: object) -> str:
    done = evaluate(*arguments)
    assert done.returncode == 2, done
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    return done.stderr


@pytest.fixture
def corpus(tmp_path: Path) -> Path:
    """Two good bags, one of them hijacked, and a damaged one between them."""
    folder = tmp_path / "corpus"
    for name, attack in (("a_good", None), ("b_damaged", None), ("c_good", (1.0, 3.0))):
        bag = write(folder / name, flight())
        kind = "straight" if attack is None else "hijack"
        times = None if attack is None else {"t_start": attack[0], "t_end": attack[1]}
        (bag / "label.json").write_text(json.dumps({"kind": kind, "attack": times}))
    file = next((folder / "b_damaged").glob("*.mcap"))
    file.write_bytes(file.read_bytes()[:5000])
    return folder


def test_json_is_alone_on_stdout_and_a_damaged_flight_stops_nothing(corpus: Path) -> None:
    done = evaluate(corpus, "--json", "-", "--jobs", 2)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    assert Evaluation.model_validate(found).model_dump(mode="json") == found
    assert [flight["name"] for flight in found["flights"]] == ["a_good", "c_good"]
    assert [flight["onset_s"] for flight in found["flights"]] == [None, 1.0]
    assert list(found["methods"]) == METHODS
    assert found["policy"] == "default"
    (failed,) = found["failed"]
    assert failed["name"] == "b_damaged"
    assert "truncated" in failed["reason"]
    assert done.stderr == f"b_damaged: {failed['reason']}\n"
    correct = found["methods"]["date"]["correct"]
    assert (correct["straight"]["count"], correct["straight"]["total"]) == (1, 1)
    assert (correct["hijacked"]["count"], correct["hijacked"]["total"]) == (0, 1)
    assert evaluate(corpus, "--json", "-", "--jobs", 1).stdout == done.stdout


def test_tables_and_page_name_methods_classes_and_flights(corpus: Path, tmp_path: Path) -> None:
    page, data = tmp_path / "new" / "page", tmp_path / "other" / "all.json"
    arguments = ("--policy", "paper", "--html", page, "--json", data, "--jobs", 1)
    done = evaluate(corpus, *arguments)
    assert done.returncode == 0, done.stderr
    for text in (*METHODS, "straight", "hijacked", "2 flights, 1 could not be read"):
        assert text in done.stdout, text
    html = (page / "index.html").read_text(encoding="utf-8")
    for text in (*METHODS, "a_good", "b_damaged", "c_good", "missed", "Clopper", "ROC"):
        assert text in html, text
    assert 'src="http' not in html
    assert json.loads(data.read_text())["policy"] == "paper"


def test_exit_code_two_if_no_flight_could_be_read(corpus: Path) -> None:
    for name in ("a_good", "c_good"):
        next((corpus / name).glob("*.mcap")).write_bytes(b"")
    done = evaluate(corpus, "--json", "-", "--jobs", 1)
    assert done.returncode == 2
    found = json.loads(done.stdout)
    assert (found["flights"], found["methods"], len(found["failed"])) == ([], {}, 3)
    assert len(done.stderr.splitlines()) == 3


def test_what_cannot_be_used_is_refused(corpus: Path, tmp_path: Path) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    assert refusal(empty).startswith(f"Error: {empty}: there is no bag in it")
    assert "either a folder of flights or --protocol" in refusal()
    assert "either a folder of flights or --protocol" in refusal(corpus, "--protocol", "feng2018")
    assert "--scale goes with --protocol" in refusal(corpus, "--scale", 2)
    assert "--onsets goes with --scenario" in refusal(corpus, "--onsets", 2)
    protocol = ("--protocol", "feng2018", "--scenario", "jump")
    assert "--scenario goes with a folder of flights" in refusal(*protocol)
    assert "no_such: cannot be read" in refusal(corpus, "--scenario", "no_such")
    onto = (corpus, "--protocol", "basan2022")
    assert "--scale goes with --protocol, and simulated flights" in refusal(*onto, "--scale", 2)
    assert "--scenario goes with a folder of flights" in refusal(*onto, "--scenario", "jump")
    assert "--onsets goes with --scenario, or" in refusal("--protocol", "basan2022", "--onsets", 2)
    assert "'feng2018'" in refusal("--protocol", "unknown")
    assert "not both" in refusal(corpus, "--policy", "paper", "--params", "config/paper.yaml")
    missing = tmp_path / "missing.yaml"
    assert refusal(corpus, "--params", missing).startswith(f"Error: {missing}: ")
    blocked = next(corpus.glob("*/*.mcap"))
    assert refusal(corpus, "--html", blocked).startswith(f"Error: {blocked}: cannot be made")


def test_a_killed_evaluation_leaves_no_workers() -> None:
    arguments = [str(PROGRAM), "evaluate", "--protocol", "feng2018", "--jobs", "2", "--json", "-"]
    with subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
        parent = psutil.Process(run.pid)
        while len(workers := parent.children(recursive=True)) < 3:  # two, and what tracks them
            assert run.poll() is None
        run.kill()
    _, alive = psutil.wait_procs(workers, timeout=20.0)
    for one in alive:
        one.kill()
    assert not alive


def test_parameters_from_a_file(corpus: Path) -> None:
    file = ROOT / "config" / "paper.yaml"
    by_file, by_name = (
        json.loads(evaluate(corpus, "--json", "-", "--jobs", 1, *given).stdout)
        for given in (("--params", file), ("--policy", "paper"))
    )
    assert by_file["policy"] == str(file)
    assert by_file["flights"] == by_name["flights"]


def test_the_protocols_on_offer_are_those_that_are_made() -> None:
    assert tuple(MADE) == PROTOCOLS


@pytest.mark.slow
def test_basans_attacks_put_into_the_clean_flights_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "curved").symlink_to(ROOT / "bags/curved_8")
    page, data = tmp_path / "page", tmp_path / "all.json"
    onto = (tmp_path, "--protocol", "basan2022", "--onsets", 1)
    done = evaluate(*onto, "--html", page, "--json", data)
    assert done.returncode == 0, done.stderr
    html = (page / "index.html").read_text(encoding="utf-8")
    for text in (
        "soft",
        "hard_1",
        "hard_2",
        "smooth",
        "kld_faithful",
        "Table 4",
        "Table 5",
        "0.94",
    ):
        assert text in done.stdout, text
        assert text in html, text
    assert "µs per update" in done.stdout

    found = Evaluation.model_validate_json(data.read_text())
    kinds = ["clean", "soft", "hard_1", "hard_2", "smooth"]
    assert [flight.kind for flight in found.flights] == kinds
    clean, soft, *_ = found.flights
    assert clean.methods["kld"].judgement is Judgement.QUIET
    assert soft.methods["kld"].judgement is Judgement.DETECTED
    assert soft.forged is not None
    # 150 values: the standard error of their deviation is 4.2 / sqrt(300) m.
    assert soft.forged["altitude"].sigma == pytest.approx(4.214, abs=1.0)
    assert soft.forged["satellites"].sigma == pytest.approx(math.sqrt(10.0), abs=0.5)
    assert clean.forged is not None
    assert {one.likelihood for one in clean.forged.values()} == {0.0}
    assert found.forging is not None
    assert all(one.microseconds > 0.0 for one in found.forging)


@pytest.mark.slow
@pytest.mark.skipif(not SITL.is_dir(), reason="the labelled flights (../shared/flights) are absent")
def test_labelled_flights(tmp_path: Path) -> None:
    names = ("dev_000_straight", "dev_008_curved", "dev_024_hijack")
    for name in names:
        (tmp_path / name).symlink_to(SITL / name)
    found = Evaluation.model_validate_json(evaluate(tmp_path, "--json", "-").stdout)
    assert [flight.name for flight in found.flights] == list(names)
    assert [flight.kind for flight in found.flights] == ["straight", "curved", "hijacked"]
    label = json.loads((SITL / names[2] / "label.json").read_text())
    assert found.flights[2].onset_s == pytest.approx(label["attack"]["t_start"])
    assert found.methods["fusion"].type_1.count == 0
