# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Judging methods on one flight: when an alarm is right, and what score it has."""

from __future__ import annotations

import pytest

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.likelihood import FusionParameters
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.evaluation.scores.evaluate import run_case
from hijack_detect.evaluation.scores.methods import (
    BASELINE,
    PAPER,
    Judgement,
    MethodOutcome,
    fused,
    judge_case,
)
from hijack_detect.evaluation.trials.cases import CaseRun, SimulatedCase
from hijack_detect.monitor.parts import DETECTORS, PUBLISHED
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.offline import OfflineRun
from hijack_detect.replay.truth import Attack
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.streams.samples import NANOSECONDS

N, S, A = State.NORMAL, State.SUSPICIOUS, State.ALARM
J = Judgement
START_NS = 5 * NANOSECONDS
REST = [name for name in DETECTORS if name not in PUBLISHED]


def verdicts(name: str, *said: tuple[State, float]) -> list[Verdict]:
    """One verdict a second, the first one second after the start."""
    return [
        Verdict(name, START_NS + second * NANOSECONDS, state, margin * 4.0, 4.0, "")
        for second, (state, margin) in enumerate(said, start=1)
    ]


def quiet(name: str) -> list[Verdict]:
    return verdicts(name, (N, 0.0))


def result(second: int, alert_since: int | None, confidence: float) -> FusionResult:
    since_ns = None if alert_since is None else START_NS + alert_since * NANOSECONDS
    stamp_ns = START_NS + second * NANOSECONDS
    return FusionResult(stamp_ns, N, since_ns is not None, since_ns, confidence, "", {}, ())


def case_run(
    attack: tuple[int, int | None] | None = None,
    results: list[FusionResult] | None = None,
    **said: list[Verdict],
) -> CaseRun:
    """A flight of ten seconds, attacked between two of them."""
    run = OfflineRun(START_NS)
    run.verdicts = {name: quiet(name) for name in DETECTORS} | said
    run.results = results or []
    run.separations = [(START_NS + s * NANOSECONDS, 10.0 * s) for s in range(11)]
    known = None
    if attack is not None:
        begin, end = (None if s is None else START_NS + s * NANOSECONDS for s in attack)
        assert begin is not None
        known = Attack(begin, end)
    return CaseRun(run, known, START_NS + 10 * NANOSECONDS)


def date_on(attack: tuple[int, int | None] | None, *said: tuple[State, float]) -> MethodOutcome:
    return judge_case(case_run(attack, date=verdicts("date", *said)))["date"]


def test_a_clean_flight_is_correct_without_alarm() -> None:
    found = date_on(None, (N, 0.5), (S, 1.5), (N, 0.2))
    assert found == MethodOutcome(
        judgement=J.QUIET,
        first_alarm_s=None,
        alarms=(),
        false_alarms=0,
        time_to_detect_s=None,
        deviation_m=None,
        score=1.5,
    )
    assert found.judgement.correct


def test_alarms_of_a_clean_flight_are_counted_by_episode() -> None:
    found = date_on(None, (A, 2.0), (A, 3.0), (N, 0.2), (A, 1.1))
    assert found.judgement is J.FALSE_ALARM
    assert not found.judgement.correct
    assert found.alarms == ((1.0, 2.0), (4.0, 4.0))
    assert found.false_alarms == 2
    assert (found.first_alarm_s, found.time_to_detect_s, found.score) == (1.0, None, 3.0)


def test_an_alarm_in_the_attack_detects_it() -> None:
    found = date_on((3, 6), (N, 0.9), (N, 5.0), (S, 1.2), (A, 2.0), (N, 0.0), (A, 9.0))
    assert found.judgement is J.DETECTED
    assert (found.first_alarm_s, found.time_to_detect_s, found.deviation_m) == (4.0, 1.0, 40.0)
    assert found.false_alarms == 0
    # Neither the margin before the onset nor that after the end counts.
    assert found.score == 2.0


@pytest.mark.parametrize(
    ("attack", "judgement", "false_alarms"),
    [
        ((2, None), J.DETECTED, 0),
        ((3, None), J.EARLY, 1),
        ((4, 6), J.EARLY, 1),
        ((1, 2), J.LATE, 0),
        ((0, 1), J.LATE, 0),
    ],
)
def test_the_first_alarm_of_the_flight_decides(
    attack: tuple[int, int | None], judgement: Judgement, false_alarms: int
) -> None:
    found = date_on(attack, (N, 0.0), (A, 2.0), (A, 2.0), (N, 0.0), (A, 2.0))
    assert (found.judgement, found.false_alarms) == (judgement, false_alarms)
    assert (found.time_to_detect_s is None) == (judgement is not J.DETECTED)


def test_the_deviation_is_unknown_without_true_positions() -> None:
    run = case_run((1, None), date=verdicts("date", (N, 0.0), (A, 2.0)))
    run.run.separations = []
    found = judge_case(run)["date"]
    assert (found.judgement, found.time_to_detect_s, found.deviation_m) == (J.DETECTED, 1.0, None)


def test_no_alarm_misses_the_attack() -> None:
    found = date_on((2, None), (N, 3.0), (S, 1.5))
    assert (found.judgement, found.score) == (J.MISSED, 1.5)


def test_both_alarms_when_the_second_of_the_pair_has_and_keeps_its_alarm() -> None:
    run = case_run(
        (2, 8),
        correlation=verdicts("correlation", (A, 1.5), (N, 0.1), (N, 0.4), (N, 0.2)),
        date=verdicts("date", (N, 0.0), (N, 0.0), (A, 2.5), (N, 0.0), (N, 0.0)),
        later=verdicts("later", (N, 0.0)),
    )
    both = judge_case(run)["both"]
    assert (both.judgement, both.first_alarm_s, both.alarms) == (J.DETECTED, 3.0, ((3.0, 5.0),))
    assert both.score == 0.4
    assert [r.alert for r in fused(run.run.verdicts, PAPER, PUBLISHED)] == [False] * 5 + [True] * 4


def test_both_needs_both() -> None:
    run = case_run(None, date=verdicts("date", (A, 9.0)))
    found = judge_case(run)
    assert (found["date"].judgement, found["both"].judgement) == (J.FALSE_ALARM, J.QUIET)
    assert found["both"].score == 0.0


def test_the_confidence_of_the_fusion_counts_up_to_the_alert() -> None:
    results = [result(2, None, 0.3), result(4, None, 0.7), result(5, 5, 1.0), result(6, 5, 1.0)]
    outcomes = [
        judge_case(case_run(attack, results))["fusion"] for attack in [(3, 5), (3, 9), (6, 9)]
    ]
    assert [(o.judgement, o.score) for o in outcomes] == [
        (J.LATE, 0.7),
        (J.DETECTED, 1.0),
        (J.EARLY, 0.0),
    ]


def test_methods_are_in_order_and_later_detectors_are_among_them() -> None:
    run = case_run(later=quiet("later"), **{BASELINE.name: quiet(BASELINE.name)})
    assert list(judge_case(run)) == [BASELINE.name, *PUBLISHED, "both", *REST, "later", "fusion"]


def test_a_simulated_flight_gives_the_same_outcome_each_time() -> None:
    case = SimulatedCase("short", "straight", FlightPlan(duration_s=60.0), 4)
    first, again = (run_case(policy_parameters("paper"), case) for _ in range(2))
    assert first == again
    assert (first.kind, first.duration_s, first.clean_s) == ("straight", 60.0, 60.0)
    assert list(first.methods) == [BASELINE.name, *PUBLISHED, "both", *REST, "fusion"]


def test_what_is_seen_of_an_attack_after_false_alarms() -> None:
    """Both had alarmed before the onset at 4 s; the pilot took it back."""
    said = [(A, 2.0), (N, 0.1), (N, 0.1), (A, 1.2), (A, 1.2), (N, 0.2), (A, 3.0), (N, 0.0)]
    date = verdicts("date", *said)
    correlation = verdicts("correlation", *[(A, 2.0), *[(N, 0.1)] * 4, (A, 1.5)])
    run = case_run((4, 9), [result(1, 1, 1.0)], correlation=correlation, date=date)
    found = judge_case(run, FusionParameters(policy="default"))
    assert {found.pop(name).judgement for name in REST} == {J.MISSED}
    assert {name: one.judgement for name, one in found.items()} == dict.fromkeys(found, J.EARLY)
    # An alarm that begins at the onset is of the attack: it was not on before.
    assert found["date"].found_s == 0.0
    assert found["correlation"].found_s == 2.0
    # A fusion that starts at the onset cannot tell that, and takes the next one; the policy
    # `default` a verdict later, as its probability has to last.
    assert found["both"].found_s == 3.0
    assert found["fusion"].found_s == 4.0
    assert judge_case(case_run(None, date=date))["date"].found_s is None


def test_an_alarm_that_goes_on_is_not_found_anew() -> None:
    date = verdicts("date", *[(A, 2.0)] * 9)
    found = judge_case(case_run((4, 9), [result(1, 1, 1.0)], date=date))
    assert {name: one.found_s for name, one in found.items()} == dict.fromkeys(found)


def test_claimed_is_the_share_of_the_attack_that_a_method_sees_by_itself() -> None:
    said = verdicts("kld", (N, 0.5), (A, 3.0), (A, 2.0), (A, 0.2), (A, 0.1), (A, 9.0))
    found = judge_case(case_run((2, 6), kld=said))
    # Four verdicts lie within seconds 2 to 6, two of them above 1; the kept alarm is no claim.
    assert found["kld"].claimed == 0.5
    assert found["fusion"].claimed is None
    assert judge_case(case_run(kld=said))["kld"].claimed is None
