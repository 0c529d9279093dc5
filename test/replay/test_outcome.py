# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Judging a flight: alarms before the attack, the first one in it, and the alert."""

from __future__ import annotations

import pytest

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.replay.truth import (
    Attack,
    DetectorOutcome,
    alert_is_right,
    changes,
    detector_outcome,
)

N, S, A = State.NORMAL, State.SUSPICIOUS, State.ALARM


def verdicts(*states: State) -> list[Verdict]:
    return [Verdict("date", stamp, state, 0.0, 1.0, "") for stamp, state in enumerate(states)]


@pytest.mark.parametrize(
    ("states", "attack", "false_alarms", "first"),
    [
        ([], None, 0, None),
        ([N, S, N], None, 0, None),
        ([N, A, A, N, A], None, 2, None),
        ([A, A, N], Attack(5, None), 1, None),
        ([N, S, A, A], Attack(2, None), 0, 2),
        ([N, S, A, A], Attack(3, None), 1, 3),
        ([N, N, S, A, A], Attack(2, 4), 0, 3),
        ([A, N, A, N, A], Attack(3, None), 2, 4),
    ],
)
def test_outcome_of_one_detector(
    states: list[State], attack: Attack | None, false_alarms: int, first: int | None
) -> None:
    assert detector_outcome(verdicts(*states), attack) == DetectorOutcome(false_alarms, first)


@pytest.mark.parametrize(
    ("alert_ns", "attack", "right"),
    [
        (None, None, True),
        (5, None, False),
        (None, Attack(5, 9), False),
        (4, Attack(5, 9), False),
        (5, Attack(5, 9), True),
        (8, Attack(5, 9), True),
        (9, Attack(5, 9), False),
        (99, Attack(5, None), True),
    ],
)
def test_an_alert_is_right_inside_the_attack_only(
    alert_ns: int | None, attack: Attack | None, right: bool
) -> None:
    assert alert_is_right(alert_ns, attack) is right


def test_changes_of_state() -> None:
    assert changes(verdicts(N, N, S, A, A, N)) == [(0, N), (2, S), (3, A), (5, N)]
    assert changes([]) == []
