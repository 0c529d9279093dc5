# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Likelihood ratios: what is fitted, and what the fusion makes of it."""

from __future__ import annotations

import math

import pytest

from experiments.fusion_calibration import (
    ALERTING,
    RATIOS,
    Piece,
    least_high,
    pieces,
    ratio,
    reliability,
)
from experiments.limits_records import (
    WINDOWS_S,
    AttackRecord,
    FlightRecord,
    MethodRecord,
)


def said(margin: float, alarm_s: float | None) -> MethodRecord:
    return MethodRecord(
        suspicious_s=alarm_s,
        alarm_s=alarm_s,
        separation_m=None,
        margins=(margin,) * len(WINDOWS_S),
        before_s=None,
    )


def flight(
    blocks: dict[str, list[float]], alarms: dict[str, list[tuple[float, float]]]
) -> FlightRecord:
    attack = AttackRecord(
        family="jump",
        size="",
        figures={},
        onset_s=5.0,
        watched_s=12.0,
        methods={"gnss": said(2.0, 0.3), "coast": said(1.2, 11.0), "date": said(0.0, None)},
    )
    return FlightRecord(
        name="one", kind="", clean_s=30.0, blocks=blocks, alarms=alarms, attacks=[attack]
    )


def test_a_flight_is_cut_into_clean_blocks_and_attacks() -> None:
    record = flight({"gnss": [0.5, 0.0, 1.5], "coast": [0.0, 0.2]}, {"gnss": [(21.0, 22.0)]})
    first, second, third, attack = pieces(record, None)
    assert [one.margins for one in (first, second, third)] == [
        {"gnss": 0.5},
        {"coast": 0.2},
        {"gnss": 1.5},
    ]
    assert [one.alarmed for one in (first, second, third)] == [False, False, True]
    assert attack.family == "jump"
    assert attack.margins == {"gnss": 2.0, "coast": 1.2}
    assert attack.alarmed
    assert len(list(pieces(record, 25.0))) == 3, "the receiver fails in the third block"


def test_the_largest_word_is_the_ratio_of_the_exceedances() -> None:
    attacked = [(2.0, 0.5), (0.1, 0.5)]
    fitted = ratio([0.5] * 1000, attacked, math.inf)
    assert fitted.neutral == 0.5
    assert fitted.high == pytest.approx(math.log(0.5 / (0.5 / 1000)), abs=0.01)
    assert fitted(1.0) == pytest.approx(fitted.high, abs=0.01)
    assert fitted(0.5) == pytest.approx(0.0, abs=1e-9)
    assert ratio([0.5] * 1000, attacked, 2.7).high == 2.7


@pytest.mark.parametrize("name", sorted(ALERTING))
def test_with_the_ratios_in_force_an_alarm_alone_is_an_alert(name: str) -> None:
    """So no other ratios change an alert, as long as they say at least so much at the limit."""
    assert RATIOS[name].high > least_high(RATIOS)
    quiet = {other: 0.05 for other in RATIOS}
    assert Piece("jump", {**quiet, name: 1.0}, alarmed=True).alerts(RATIOS)
    assert not Piece("jump", {**quiet, name: 1.0}, alarmed=False).alerts(RATIOS)


def test_reliability_weighs_clean_and_attacked_alike_and_families_too() -> None:
    sure, idle = Piece("jump", {"gnss": 5.0}, True), Piece("drift", {}, False)
    clean = Piece("no_attack", {}, False)
    found = [(sure, RATIOS), (idle, RATIOS), (idle, RATIOS), *[(clean, RATIOS)] * 7]
    brier, bins = reliability(found)
    claim = 1.0 / (1.0 + math.exp(-RATIOS["gnss"].high))
    assert brier == pytest.approx(0.5 * 0.25 + 0.25 * 0.25 + 0.25 * (1.0 - claim) ** 2)
    assert sum(weight for _, _, weight in bins) == pytest.approx(1.0)
    assert bins[0][:2] == pytest.approx((0.5, 1.0 / 3.0))
