# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which detections count, and on which half of the flights."""

from __future__ import annotations

from experiments.limits_records import (
    WINDOWS_S,
    AttackRecord,
    FlightRecord,
    MethodRecord,
)
from experiments.limits_runs import by_half, credited, halves
from hijack_detect.evaluation.trials.families import CLEAN


def said(alarm_s: float | None) -> MethodRecord:
    return MethodRecord(
        suspicious_s=alarm_s,
        alarm_s=alarm_s,
        separation_m=None if alarm_s is None else 3.0,
        margins=(0.5,) * len(WINDOWS_S),
        before_s=None,
    )


def attack(family: str, onset_s: float, **alarms: float | None) -> AttackRecord:
    return AttackRecord(
        family=family,
        size="",
        figures={},
        onset_s=onset_s,
        watched_s=60.0,
        methods={name: said(alarm_s) for name, alarm_s in alarms.items()},
    )


def flight(name: str, *attacks: AttackRecord) -> FlightRecord:
    return FlightRecord(
        name=name, kind="", clean_s=0.0, blocks={}, alarms={}, attacks=list(attacks)
    )


def test_an_alarm_that_comes_without_the_attack_as_well_is_no_merit() -> None:
    record = flight(
        "one",
        attack(CLEAN, 20.0, date=7.0, coast=None, kld=4.0),
        attack("jump", 20.0, date=2.0, coast=3.0, kld=4.0),
        attack("jump", 50.0, date=9.0, coast=None, kld=8.0),
    )
    clean, first, other = credited(record).attacks
    assert clean == record.attacks[0]
    alarms = {name: one.alarm_s for name, one in first.methods.items()}
    assert alarms == {"date": 2.0, "coast": 3.0, "kld": None}
    assert first.methods["kld"].separation_m is None
    assert other == record.attacks[2]


def test_halves_are_by_turns_in_order_of_name_and_share_no_flight() -> None:
    assert halves(["c", "a", "d", "b", "a"]) == (["a", "c"], ["b", "d"])
    records = [flight(name) for name in ("b", "a", "c", "a")]
    found = {half: [one.name for one in own] for half, own in by_half(records).items()}
    assert found == {"A": ["a", "c", "a"], "B": ["b"]}
