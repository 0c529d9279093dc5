# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What must hold of the recorded flights, by the class of each: when there is an alert.

All of `real/` runs always; `bags/` and `sitl/`, on which limits were chosen, with HIJACK_CORPUS=all
(`make corpus`). HIJACK_FLIGHTS names another folder of the same form. One test is one flight, so
that the workers of a parallel run share them.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from ros import ROOT

from experiments.vehicles import FAILS_FROM_S
from hijack_detect.evaluation.scores.evaluate import FAULT, run_case
from hijack_detect.evaluation.scores.metrics import FlightOutcome
from hijack_detect.evaluation.trials.cases import HIJACKED, BagCase, CorpusLabel
from hijack_detect.evaluation.trials.corpus import corpus_cases
from hijack_detect.monitor.policies import policy_parameters

FLIGHTS = Path(os.environ.get("HIJACK_FLIGHTS", ROOT.parent / "shared/flights"))
WHOLE = os.environ.get("HIJACK_CORPUS") == "all"
FOLDERS = ("real", "bags", "sitl") if WHOLE else ("real",)

FOUND_WITHIN_S: dict[str, float | None] = {
    "dev_020_hijack": None,  # carry-off at 0.2 m/s²
    "dev_021_hijack": None,  # 0.1 m/s²
    "dev_022_hijack": 4.5,  # 0.6 m/s²
    "dev_023_hijack": 4.5,  # 0.6 m/s²
    "dev_024_hijack": 5.0,  # the velocity was left honest
    "dev_025_hijack": None,  # jump of 8 m
    "dev_026_hijack": 1.0,  # jump of 40 m
    "dev_027_hijack": 4.5,  # turned away by 60° in 15 s
    "dev_028_hijack": 50.0,  # by 40° in 25 s
    "dev_029_hijack": 8.0,  # altitude, 1 m/s
    "dev_030_hijack": 2.0,  # freeze
}
"""Seconds from the onset to the alert that each attack may take; None if it is not required."""
UNSEEN = frozenset({"ground", "low_imu_rate", "sitl"})
"""Classes of `real/` in which nothing that needs an IMU in flight may claim to tell."""
LOST_FIX = frozenset({"erle_quad_6nov_loiter_rtl.bin"})
"""Flights of class `flight` of which it is true: 6 s without a fix, and an HDOP of 2.53."""


@dataclass(frozen=True)
class Flight:
    """A flight and the folder of the corpus that it is in."""

    folder: str
    case: BagCase


def flights() -> Iterator[Any]:
    for folder in FOLDERS:
        if not (FLIGHTS / folder).is_dir():
            reason = f"the recorded flights are absent: {FLIGHTS / folder}"
            yield pytest.param(None, id=folder, marks=pytest.mark.skip(reason=reason))
            continue
        for case in corpus_cases(FLIGHTS / folder):
            yield pytest.param(Flight(folder, known(case)), id=case.name)


def known(case: BagCase) -> BagCase:
    """The case with the second from which its receiver fails."""
    fails_s = FAILS_FROM_S.get(case.name)
    if fails_s is None:
        return case
    label = case.label or CorpusLabel("")
    return replace(case, kind=FAULT, label=replace(label, alert_ok_from_s=fails_s))


@pytest.mark.slow
@pytest.mark.parametrize("flight", [*flights()])
def test_alerts_are_right_or_there_are_none(flight: Flight) -> None:
    case = flight.case
    try:
        done = run_case(policy_parameters("default"), case)
    except ValueError as error:
        assert case.kind == "import", error
        assert "MCAP" not in str(error), "a log of another format is not a damaged bag"
        return
    assert done.watch is not None
    if case.kind == "poor_gps":
        assert done.watch.poor_receiver
    elif case.kind == "flight" and case.name not in LOST_FIX:
        assert not done.watch.poor_receiver
    first = done.watch.first
    assert first is None, f"false alert at {first.at_s:.1f} s: {first.cause}"
    if case.kind in UNSEEN:
        assert done.watch.not_judged is not None
        assert done.watch.carry_off_s == 0.0
    elif case.kind == FAULT:
        assert done.methods["fusion"].alarms, "a receiver that fails is not found"
    elif case.kind == HIJACKED:
        found_in_time(done)


def found_in_time(done: FlightOutcome) -> None:
    within_s = FOUND_WITHIN_S.get(done.name)
    taken_s = done.methods["fusion"].time_to_detect_s
    if within_s is not None:
        assert taken_s is not None, "the attack is missed"
        assert taken_s <= within_s
