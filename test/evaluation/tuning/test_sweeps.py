# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Sweeps over parameters and over sizes of attack."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from hijack_detect.evaluation.scores.metrics import Proportion
from hijack_detect.evaluation.trials.cases import HIJACKED, BagCase, SimulatedCase
from hijack_detect.evaluation.trials.protocols import hijacked_case
from hijack_detect.evaluation.tuning.attack_map import (
    Cell,
    attack_cases,
    attack_map,
    attack_sizes,
)
from hijack_detect.evaluation.tuning.attack_map import csv_text as map_csv
from hijack_detect.evaluation.tuning.sweep_plots import draw_curves, draw_map
from hijack_detect.evaluation.tuning.sweeps import (
    CLAIMED,
    CLEAN,
    SWEEPS,
    Curve,
    Sweep,
    csv_text,
    sweep,
)
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.truth import alert_is_right
from hijack_detect.simulation.plan import FlightPlan

PAPER = policy_parameters("paper")
PNG = b"\x89PNG"
CLEAN_CASE = SimulatedCase("clean", "curved", FlightPlan("curved", duration_s=60.0), 4)


def curve(kind: str, *counts: int, method: str = "correlation") -> Curve:
    return Curve(method, kind, tuple(Proportion.of(count, 4) for count in counts))


def test_the_papers_value_is_what_the_monitor_does() -> None:
    mu = dataclasses.replace(SWEEPS["mu"], values=(10.0,))
    case = hijacked_case(30_000)
    curves, failures = sweep([case, CLEAN_CASE], PAPER, mu)
    assert failures == []
    for one, flight in zip(curves[:2], (case, CLEAN_CASE), strict=True):
        done = flight.run(PAPER)
        alarms = [v.stamp_ns for v in done.run.verdicts["correlation"] if v.state.value == "alarm"]
        right = alert_is_right(alarms[0] if alarms else None, done.attack)
        assert one.correct == (Proportion.of(int(right), 1),)
    assert [one.kind for one in curves] == [HIJACKED, CLEAN, CLAIMED]


def test_a_loose_threshold_pleases_clean_flights_and_misses_attacks() -> None:
    mu = dataclasses.replace(SWEEPS["mu"], values=(0.1, 180.0))
    (hijacked, clean, claimed), _ = sweep([hijacked_case(30_000), CLEAN_CASE], PAPER, mu)
    assert [one.count for one in hijacked.correct] == [0, 0]  # too early, and never
    assert [one.count for one in claimed.correct] == [1, 0]
    assert [one.count for one in clean.correct] == [0, 1]


def test_classes_are_told_apart_and_what_cannot_be_read_is_left_out(tmp_path: Path) -> None:
    straight = SimulatedCase("straight", "straight", FlightPlan("straight", duration_s=60.0), 4)
    window = Sweep("window_s", "window", (2.0,), 2.0, methods=("correlation", "date"))
    gone = BagCase(tmp_path / "gone", "gone", "curved")
    curves, failures = sweep([CLEAN_CASE, gone, straight], PAPER, window)
    assert [failure.name for failure in failures] == ["gone"]
    assert [(one.method, one.kind, one.correct[0].total) for one in curves] == [
        (method, kind, total)
        for method in ("correlation", "date")
        for kind, total in ((CLEAN, 2), ("curved", 1), ("straight", 1))
    ]


def test_a_table_has_a_line_for_each_value() -> None:
    small = Sweep("mu_deg", "μ", (5.0, 10.0), 10.0)
    assert csv_text(small, [curve(CLEAN, 1, 4)]).splitlines() == [
        "mu_deg,method,class,correct,flights,ratio,low95,high95",
        "5,correlation,non-hijacked,1,4,0.2500,0.0063,0.8059",
        "10,correlation,non-hijacked,4,4,1.0000,0.3976,1.0000",
    ]


@pytest.mark.parametrize("name", SWEEPS)
def test_sweeps_contain_the_published_value_in_order(name: str) -> None:
    what = SWEEPS[name]
    assert what.published in what.values
    assert sorted(what.values) == list(what.values)
    for method in what.methods:
        for value in what.values:
            PAPER.having(method, **{what.parameter: value})


def test_every_cell_flies_the_same_flights() -> None:
    weak, strong = attack_cases(0.5, 0.1, 3), attack_cases(8.0, 3.2, 3)
    for one, other in zip(weak, strong, strict=True):
        assert (one.plan, one.seed) == (other.plan, other.seed)
        assert one.scenario is not None and other.scenario is not None
        assert one.scenario.segments[0].start_s == other.scenario.segments[0].start_s
        assert one.scenario.segments[0].model != other.scenario.segments[0].model
    assert attack_sizes((1.0,), (0.1, 0.2)) == [(0.0, 1.0), (1.0, 0.1), (1.0, 0.2)]


def test_a_crude_attack_is_seen_and_none_is_not() -> None:
    default = policy_parameters("default")
    cells, failures = attack_map(default, flights=1, speeds=(8.0,), accelerations=(3.2,))
    assert failures == []
    date = {cell.speed: cell for cell in cells if cell.method == "date"}
    assert (date[0.0].detected.count, date[8.0].detected.count) == (0, 1)
    assert date[0.0].median_s is None
    assert 0.0 < (date[8.0].median_s or 0.0) < 10.0
    assert len(map_csv(cells).splitlines()) == 1 + len(cells)


def test_the_same_curves_give_the_same_picture(tmp_path: Path) -> None:
    what = Sweep("mu_deg", "μ, degrees", (5.0, 10.0, 20.0), 10.0, log=True)
    curves = [curve(kind, 1, 2, 4) for kind in (HIJACKED, CLEAN, "straight", "curved", CLAIMED)]
    for name in ("one.png", "two.png"):
        draw_curves(tmp_path / name, what, curves, "title")
    drawn = (tmp_path / "one.png").read_bytes()
    assert drawn.startswith(PNG)
    assert drawn == (tmp_path / "two.png").read_bytes()


def test_a_map_of_any_number_of_methods_is_drawn(tmp_path: Path) -> None:
    cells = [
        Cell(f"method {number}", speed, gain, Proportion.of(number, 4), 2.0 if number else None)
        for number in range(4)
        for speed, gain in attack_sizes((1.0, 2.0), (0.1,))
    ]
    draw_map(tmp_path / "map.png", cells, "title")
    assert (tmp_path / "map.png").read_bytes().startswith(PNG)
