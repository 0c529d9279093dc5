# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Records of attacks, against hand-made verdicts, and one flight of each sort."""

from __future__ import annotations

from functools import partial

import pytest
from ros import ROOT

from experiments.limits_records import (
    WINDOWS_S,
    CleanLog,
    FlightRecord,
    method_record,
    record_case,
    record_forked,
)
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.evaluation.trials.cases import BagCase
from hijack_detect.evaluation.trials.families import CLEAN
from hijack_detect.evaluation.trials.limits import limits
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import OfflineRun

SECOND = 1_000_000_000
START_NS = 1_764_000_000 * SECOND
NORMAL, SUSPICIOUS, ALARM = State.NORMAL, State.SUSPICIOUS, State.ALARM


def said(time_s: float, state: State, margin: float) -> Verdict:
    return Verdict("date", START_NS + round(time_s * SECOND), state, 2.0 * margin, 2.0, "because")


RUN = OfflineRun(START_NS)
RUN.separations = [(START_NS + t * SECOND, float(t)) for t in range(200)]
record = partial(method_record, onset_ns=START_NS + 100 * SECOND, run=RUN, watched_s=60.0)


def test_first_times_and_largest_margins_after_the_onset() -> None:
    verdicts = [
        said(99.0, NORMAL, 0.9),
        said(100.5, NORMAL, 0.25),
        said(104.0, SUSPICIOUS, 1.5),
        said(109.0, ALARM, 2.0),
        said(119.0, SUSPICIOUS, 1.0),
        said(159.0, ALARM, 3.0),
        said(161.0, ALARM, 9.0),
    ]
    found = record(verdicts, before_s=None)
    assert (found.suspicious_s, found.alarm_s, found.separation_m) == (4.0, 9.0, 109.0)
    assert dict(zip(WINDOWS_S, found.margins, strict=True)) == {
        1.0: 0.25,
        2.0: 0.25,
        5.0: 1.5,
        10.0: 2.0,
        20.0: 2.0,
        60.0: 3.0,
    }
    assert found.before_s is None


def test_an_alarm_before_the_onset_is_told() -> None:
    assert record([said(99.5, ALARM, 2.0)], before_s=None).before_s == 0.5
    assert record([said(99.5, ALARM, 2.0)], before_s=0.25).before_s == 0.25
    assert record([said(100.0, NORMAL, 0.0)], before_s=7.0).before_s == 7.0


def test_clean_time_in_blocks_and_episodes() -> None:
    log = CleanLog(START_NS)
    for verdict in (
        said(1.0, NORMAL, 0.5),
        said(9.9, ALARM, 1.25),
        said(10.1, ALARM, 1.5),
        said(12.0, NORMAL, 0.1),
        said(35.0, ALARM, 2.0),
    ):
        log.add("date", verdict)
    log.add("attitude", "not a verdict")
    found = log.record("f", "clean", 40.0, [])
    assert found.blocks == {"date": [1.25, 1.5, 0.0, 2.0]}
    assert found.alarms == {"date": [(9.9, 10.1), (35.0, 35.0)]}
    assert log.before_s("date", START_NS + 5 * SECOND) is None
    assert log.before_s("date", START_NS + 10 * SECOND) == 0.0
    assert log.before_s("date", START_NS + 20 * SECOND) == pytest.approx(9.9)


@pytest.mark.slow
def test_a_recorded_flight_under_some_attacks() -> None:
    case = BagCase(ROOT / "bags/straight_3", "straight_3", "straight")
    sizes = {"40 m", "in motion", "any phase"}
    done: list[tuple[int, int]] = []
    found = record_forked(
        MonitorParameters(),
        case,
        moving=1,
        any_phase=1,
        chosen=lambda one: one.size in sizes,
        on_done=lambda *told: done.append(told),
    )
    assert done == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert FlightRecord.model_validate_json(found.model_dump_json()) == found
    assert found.alarms["fusion"] == []
    assert sorted(one.family for one in found.attacks) == sorted(
        [CLEAN, CLEAN, "jump", "jump_any_phase"]
    )
    for attack in found.attacks:
        kld = attack.methods["kld"]
        assert (kld.alarm_s is not None) == (attack.family != CLEAN)
        if kld.separation_m is not None:
            assert kld.separation_m == pytest.approx(40.0, rel=1e-3)
        assert list(kld.margins) == sorted(kld.margins)


def test_a_simulated_flight_under_attack() -> None:
    case = next(case for case in limits() if case.kind == "jump_20")
    found = record_case(MonitorParameters(), case)
    assert case.scenario is not None
    (attack,) = found.attacks
    onset_s = case.scenario.segments[0].start_s
    assert (attack.family, attack.onset_s, found.clean_s) == ("jump_20", onset_s, onset_s)
    assert set(attack.methods) == set(found.blocks)
    assert len(found.blocks["date"]) <= onset_s / 10.0 + 1
