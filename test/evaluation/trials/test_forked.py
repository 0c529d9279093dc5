# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attacks that fork off a clean run say what whole runs with the same scenario say."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import pytest
from ros import ROOT

from experiments.forked import run_forked
from hijack_detect.bags.reader import BagReader
from hijack_detect.evaluation.scores.methods import with_baselines
from hijack_detect.evaluation.trials.cases import BagCase
from hijack_detect.evaluation.trials.families import FAMILIES, Size, jump, scenario_of
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import OfflineRun
from hijack_detect.spoofing.scenario import Scenario, ScenarioError
from hijack_detect.streams.samples import NANOSECONDS

BAG = ROOT / "bags/curved_8"
PARAMETERS = with_baselines(MonitorParameters(), published_kld=False)
HORIZON_S = 8.0
FREEZE, REPLAY = FAMILIES["freeze"][0], FAMILIES["replay"][0]


@dataclass(frozen=True)
class One:
    onset_s: float
    scenario: Scenario | None


def one(size: Size, onset_s: float) -> One:
    return One(onset_s, scenario_of("x", size, "curved_8", onset_s))


# Two overlap, and two begin at the same time.
ATTACKS = (
    one(jump(15.0), 40.0),
    one(FREEZE, 44.33),
    one(REPLAY, 44.33),
    One(60.0, None),
    one(FAMILIES["drift"][-1], 104.0),
)


def forked(attacks: Sequence[One], path: Path = BAG, **more: Any) -> list[tuple[One, OfflineRun]]:
    with BagReader(path) as reader:
        return list(run_forked(reader, attacks, PARAMETERS, horizon_s=HORIZON_S, **more))


TOLD: list[tuple[str, Any]] = []
"""What was said of the clean flight while the attacks ran."""


@lru_cache
def runs() -> list[tuple[One, OfflineRun]]:
    return forked(ATTACKS, on_clean=lambda *said: TOLD.append(said))


@lru_cache
def whole(scenario: Scenario | None) -> OfflineRun:
    case = BagCase(BAG, "curved_8", "hijacked", scenario)
    return case.run(PARAMETERS).run


def lists(run: OfflineRun) -> dict[str, list[Any]]:
    return {**run.verdicts, "fusion": run.results}


@pytest.mark.parametrize("number", range(len(ATTACKS)))
def test_a_fork_says_what_the_whole_run_says(number: int) -> None:
    attack, run = runs()[number]
    assert attack is ATTACKS[number]
    complete = whole(attack.scenario)
    onset_ns = complete.start_ns + round(attack.onset_s * NANOSECONDS)
    end_ns = onset_ns + round(HORIZON_S * NANOSECONDS)
    for part, expected in lists(complete).items():
        found = lists(run)[part]
        begin = expected.index(found[0])
        assert found == expected[begin : begin + len(found)], part
        # It begins before the onset, or with it, and goes on until the horizon or the end.
        assert found[0].stamp_ns <= onset_ns + NANOSECONDS // 4
        assert found[-1].stamp_ns >= min(end_ns - NANOSECONDS, expected[-1].stamp_ns)
    for stamp_ns, separation in run.separations:
        assert complete.separation_at(stamp_ns) == separation


def test_an_attack_is_seen_and_the_clean_flight_stays_quiet() -> None:
    alerts = [run.results[-1].alert for _, run in runs()]
    assert (alerts[0], alerts[3]) == (True, False)


def test_forks_of_one_copy_share_nothing() -> None:
    onset_s = ATTACKS[0].onset_s
    jumped = ATTACKS[0]
    (_, first), (_, clean), (_, second) = forked(
        [jumped, One(onset_s, None), dataclasses.replace(jumped)]
    )
    assert lists(first) == lists(second) == lists(runs()[0][1])
    for part, found in lists(clean).items():
        expected = lists(whole(None))[part]
        begin = expected.index(found[0])
        assert found == expected[begin : begin + len(found)]


def test_the_clean_run_is_told_and_not_touched_by_the_attacks() -> None:
    assert len(runs()) == len(ATTACKS)
    for part, expected in lists(whole(None)).items():
        assert [output for name, output in TOLD if name == part] == expected


def test_runs_are_made_as_the_flight_goes_on() -> None:
    """Only one horizon of samples is kept: a run comes as soon as its samples are there."""
    newest = [0]

    def note(_: str, output: Any) -> None:
        newest[0] = output.stamp_ns

    with BagReader(BAG) as reader:
        runs = run_forked(reader, ATTACKS[:2], PARAMETERS, horizon_s=HORIZON_S, on_clean=note)
        for attack, _ in runs:
            now_s = (newest[0] - reader.start_ns) / NANOSECONDS
            assert now_s == pytest.approx(attack.onset_s + HORIZON_S, abs=1.0)


def test_an_attack_outside_the_flight_is_refused() -> None:
    with pytest.raises(ScenarioError, match="outside the flight"):
        forked([one(jump(5.0), 500.0)])
