# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Finding the flights of a folder, and what their labels make of them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from ros import ROOT
from small_bags import SPOOF_TEXT, flag, flight, write

from hijack_detect.bags.errors import BagError
from hijack_detect.evaluation.scores.evaluate import run_case
from hijack_detect.evaluation.trials.corpus import bag_paths, corpus_cases
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.spoofing.scenario import parse_scenario

SITL = ROOT.parent / "shared" / "flights" / "sitl"
SECOND = 10**9


def labelled(bag: Path, kind: str, attack: tuple[float, float] | None = None) -> Path:
    times = None if attack is None else dict(zip(("t_start", "t_end"), attack, strict=True))
    (bag / "label.json").write_text(json.dumps({"kind": kind, "attack": times}))
    return bag


def test_bags_are_found_in_order_of_name_as_folders_and_as_files(tmp_path: Path) -> None:
    write(tmp_path / "b" / "two", flight())
    write(tmp_path / "b" / "one", flight())
    (tmp_path / "a.mcap").symlink_to(next((tmp_path / "b" / "one").glob("*.mcap")))
    (tmp_path / "c" / "empty").mkdir(parents=True)
    (tmp_path / "notes.txt").write_text("no bag")
    (tmp_path / "c" / "loop").symlink_to(tmp_path)
    cases = corpus_cases(tmp_path)
    assert [case.name for case in cases] == ["a.mcap", "b/one", "b/two"]
    assert {case.kind for case in cases} == {"unlabelled"}
    assert [case.name for case in corpus_cases(tmp_path / "b" / "two")] == ["two"]


def test_a_bag_whose_recorder_died_is_found_by_its_file(tmp_path: Path) -> None:
    bag = labelled(write(tmp_path / "one", flight()), "straight")
    (bag / "metadata.yaml").unlink()
    assert [(case.name, case.kind) for case in corpus_cases(tmp_path)] == [
        ("one/one.mcap", "straight")
    ]


def test_one_file_labels_bags_and_logs_of_its_folder(tmp_path: Path) -> None:
    folder = tmp_path / "flights"
    for name in ("clean", "spoofed", "unknown"):
        write(folder / name, flight())
    (folder / "text.log").write_text("FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n")
    (folder / "notes.txt").write_text("no flight")
    entries = [
        {"file": "clean", "vehicle": "quad", "class": "flight", "attack": None},
        {"file": "spoofed", "vehicle": "quad", "class": "flight",
         "attack": {"t_start": 1.0, "t_end": 3.0}},
        {"file": "text.log", "vehicle": "wing", "class": "natural_fault", "attack": None,
         "alert_ok_from_s": 56, "note": "fails"},
        {"file": "gone.bin", "vehicle": "wing", "class": "import", "attack": None},
    ]  # fmt: skip
    (folder / "labels.json").write_text(json.dumps(entries))
    cases = {case.name: case for case in corpus_cases(tmp_path)}
    assert {name: case.kind for name, case in cases.items()} == {
        "flights/clean": "flight",
        "flights/spoofed": "hijacked",
        "flights/text.log": "natural_fault",
        "flights/unknown": "unlabelled",
    }
    label = cases["flights/text.log"].label
    assert label is not None
    assert (label.vehicle, label.alert_ok_from_s) == ("wing", 56.0)
    done = run_case(MonitorParameters(), cases["flights/spoofed"])
    assert (done.kind, done.onset_s, done.attack_end_s, done.vehicle) == (
        "hijacked", 1.0, 3.0, "quad",
    )  # fmt: skip
    with pytest.raises(ValueError, match=r"text\.log"):
        run_case(MonitorParameters(), cases["flights/text.log"])

    for text in ("{", "[3]", '[{"file": "clean"}]'):
        (folder / "labels.json").write_text(text)
        with pytest.raises(BagError, match=r"labels\.json"):
            corpus_cases(tmp_path)


def test_nothing_to_find_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BagError, match=r"there is no bag in it"):
        corpus_cases(tmp_path)
    missing = tmp_path / "missing"
    with pytest.raises(BagError, match=re.escape(str(missing))):
        corpus_cases(missing)


def test_classes_are_those_of_the_labels(tmp_path: Path) -> None:
    for kind in ("straight", "curved", "hardneg"):
        labelled(write(tmp_path / kind, flight()), kind)
    labelled(write(tmp_path / "spoofed", flight()), "hijack", (1.0, 2.5))
    cases = {case.name: case for case in corpus_cases(tmp_path)}
    assert {name: case.kind for name, case in cases.items()} == {
        "curved": "curved",
        "hardneg": "hardneg",
        "spoofed": "hijacked",
        "straight": "straight",
    }
    clean = run_case(MonitorParameters(), cases["curved"])
    assert (clean.kind, clean.onset_s, clean.clean_s) == ("curved", None, 4.0)
    spoofed = run_case(MonitorParameters(), cases["spoofed"])
    assert (spoofed.kind, spoofed.onset_s, spoofed.attack_end_s) == ("hijacked", 1.0, 2.5)
    assert (spoofed.duration_s, spoofed.clean_s) == (4.0, 1.0)


def test_labels_that_say_too_little_are_refused_when_the_flight_runs(tmp_path: Path) -> None:
    labelled(write(tmp_path / "when", flight()), "hijack")
    broken = write(tmp_path / "broken", flight()) / "label.json"
    broken.write_text("{")
    cases = {case.name: case for case in corpus_cases(tmp_path)}
    with pytest.raises(ValueError, match=r"when: is labelled as hijacked"):
        run_case(MonitorParameters(), cases["when"])
    with pytest.raises(ValueError, match=re.escape(str(broken))):
        run_case(MonitorParameters(), cases["broken"])


def test_an_unlabelled_bag_is_hijacked_if_its_topics_say_so(tmp_path: Path) -> None:
    bag = list(flight())
    start = bag[0].log_ns
    truth = [flag("/spoof_active", start + round(s * SECOND), s >= 2.0) for s in (0.5, 2.0, 3.0)]
    write(tmp_path / "one", sorted([*bag, *truth], key=lambda raw: raw.log_ns))
    found = run_case(MonitorParameters(), corpus_cases(tmp_path)[0])
    assert (found.kind, found.onset_s) == ("hijacked", 2.0)


@pytest.mark.skipif(not SITL.is_dir(), reason="the labelled flights (../shared/flights) are absent")
def test_the_labelled_flights_are_all_found() -> None:
    cases = corpus_cases(SITL)
    kinds = [case.kind for case in cases]
    assert {kind: kinds.count(kind) for kind in kinds} == {
        "straight": 8,
        "curved": 8,
        "hardneg": 4,
        "hijacked": 11,
    }
    assert len(list(bag_paths(SITL))) == len({case.name for case in cases}) == 31


def test_clean_flights_are_attacked_at_onsets_in_forward_flight(tmp_path: Path) -> None:
    messages = list(flight(20.0))
    labelled(write(tmp_path / "one", messages), "curved")
    labelled(write(tmp_path / "spoofed", messages), "hijack", (1.0, 2.5))
    write(tmp_path / "two", messages)
    (tmp_path / "two" / "two.mcap").write_bytes(b"")
    jump = parse_scenario(SPOOF_TEXT)
    cases = corpus_cases(tmp_path, jump, 2)
    assert [case.name for case in cases[:3]] == ["one", "spoofed", "two"]
    onsets = [case.scenario.segments[0].start_s for case in cases[3:] if case.scenario]
    assert [case.name for case in cases[3:]] == [f"one@{onset:g}s" for onset in onsets]
    assert [case.injected for case in cases] == [False] * 3 + [True] * 2
    done = run_case(MonitorParameters(), cases[3])
    assert (done.kind, done.injected, done.clean_s) == ("hijacked", True, 0.0)
    assert done.onset_s == pytest.approx(onsets[0])
