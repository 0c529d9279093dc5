# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""One alert from several verdicts."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.detectors.fusion import Fusion, FusionResult
from hijack_detect.detectors.likelihood import (
    UNCALIBRATED,
    FusionParameters,
    LikelihoodRatio,
    RecentPeak,
    Weight,
    odds,
    probability,
    together,
)
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.parts import DETECTORS, WEIGHTS, weights
from hijack_detect.parameters import ParameterError

SECOND = 10**9
NAMES = ("correlation", "date")
RATIOS = {name: one.ratio for name, one in WEIGHTS.items() if one.ratio is not None}
ADVISORY = WEIGHTS.keys() - RATIOS.keys()
SOFT = {name for name, one in WEIGHTS.items() if not one.may_alert}


def verdict(name: str, at_s: float, state: State, margin: float | None = None) -> Verdict:
    usual = {State.ALARM: 1.5, State.SUSPICIOUS: 1.1, State.NORMAL: 0.1}
    margin = usual.get(state, 0.0) if margin is None else margin
    return Verdict(name, round(at_s * SECOND), state, 2.0 * margin, 2.0, f"{name} says so")


def heard(*names: str) -> dict[str, Weight]:
    return {name: WEIGHTS.get(name, UNCALIBRATED) for name in names}


def fusion(policy: str = "default", **parameters: float) -> Fusion:
    return Fusion(FusionParameters.from_mapping({"policy": policy, **parameters}), heard(*NAMES))


def feed(one: Fusion, *verdicts: Verdict) -> list[FusionResult]:
    return [one.update(v.detector, v) for v in verdicts]


def both(at_s: float, correlation: State, date: State) -> list[Verdict]:
    return [verdict("correlation", at_s, correlation), verdict("date", at_s, date)]


@pytest.mark.parametrize("name", NAMES)
def test_any_alerts_on_a_single_alarm(name: str) -> None:
    one = fusion("any")
    assert not feed(one, *both(0, State.NORMAL, State.NORMAL))[-1].alert
    result = feed(one, verdict(name, 1, State.ALARM))[-1]
    assert result.alert
    assert result.alert_since_ns == SECOND
    assert result.state is State.ALARM
    assert f"{name} says so" in result.reason


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, ""),
        (
            {"poor_no_fix": 7.0},
            "; the receiver is poor by its own word (no fix for 7 s of a minute)",
        ),
        ({"late_gps": 0.38}, "; the GPS is late (lags by 0.38 s or more)"),
    ],
)
def test_an_alert_beside_a_poor_or_late_receiver_says_that_it_can_be_a_fault(
    values: dict[str, float], words: str
) -> None:
    one = Fusion(FusionParameters(policy="any"), heard(*NAMES, "gnss"))
    beside = replace(verdict("gnss", 0, State.NORMAL), values=values)
    doubt = f"{words}: this can be a fault of the receiver" if words else ""
    result = feed(one, beside, verdict("date", 1, State.ALARM))[-1]
    assert result.cause == f"date says so [date, 1.5 × its limit]{doubt}"


@pytest.mark.parametrize("state", [one for one in State if one is not State.ALARM])
@pytest.mark.parametrize("policy", ["any", "default", "paper"])
def test_nothing_but_an_alarm_alerts(policy: str, state: State) -> None:
    one = fusion(policy)
    for at in range(10):
        for name in NAMES:
            margin = 0.8 if state is State.SUSPICIOUS else None
            assert not one.update(name, verdict(name, at, state, margin)).alert


@pytest.mark.parametrize("name", RATIOS)
def test_no_detector_is_certain_alone(name: str) -> None:
    one = Fusion(FusionParameters(), heard(name))
    for at in range(10):
        assert not feed(one, verdict(name, at, State.SUSPICIOUS, 1000.0))[-1].alert


def test_paper_alerts_when_both_have_claimed_however_far_apart() -> None:
    one = fusion("paper")
    assert not feed(one, verdict("correlation", 1, State.ALARM))[-1].alert
    assert not feed(one, *both(2, State.NORMAL, State.NORMAL))[-1].alert
    assert not feed(one, verdict("correlation", 3, State.ALARM))[-1].alert
    result = feed(one, verdict("date", 200, State.ALARM))[-1]
    assert result.alert
    assert result.alert_since_ns == 200 * SECOND
    assert result.causes == ("correlation", "date")
    assert "correlation" in result.reason
    assert "date" in result.reason


def test_the_alert_is_latched_until_reset() -> None:
    one = fusion("any")
    feed(one, verdict("date", 1, State.ALARM))
    for at in range(2, 100):
        for result in feed(one, *both(at, State.NORMAL, State.NORMAL)):
            assert result.alert
            assert result.alert_since_ns == SECOND
            assert result.state is State.ALARM
            assert result.confidence == 1.0
            assert "date, 1.5 × its limit" in result.reason
    one.reset()
    result = feed(one, *both(100, State.NORMAL, State.NORMAL))[-1]
    assert not result.alert
    assert result.alert_since_ns is None
    assert result.causes == ()
    assert result.state is State.NORMAL
    assert feed(one, verdict("date", 101, State.ALARM))[-1].alert_since_ns == 101 * SECOND


def test_later_alarms_change_neither_the_time_nor_the_cause_of_the_alert() -> None:
    one = fusion("any")
    first = feed(one, verdict("date", 1, State.ALARM))[-1]
    later = feed(one, verdict("correlation", 2, State.ALARM), verdict("date", 3, State.ALARM))[-1]
    assert later.alert_since_ns == first.alert_since_ns == SECOND
    assert later.reason == first.reason
    assert later.causes == first.causes == ("date",)


def test_reset_forgets_the_claims_of_the_paper_policy() -> None:
    one = fusion("paper")
    feed(one, verdict("correlation", 1, State.ALARM))
    one.reset()
    assert not feed(one, verdict("date", 2, State.ALARM))[-1].alert
    assert feed(one, verdict("correlation", 3, State.ALARM))[-1].alert


def test_a_silent_detector_becomes_stale() -> None:
    one = fusion(stale_s=3.0)
    feed(one, *both(0, State.NORMAL, State.NORMAL))
    for at_s in (1.5, 3.0):
        assert feed(one, verdict("correlation", at_s, State.NORMAL))[-1].state is State.NORMAL
    result = feed(one, verdict("correlation", 3.1, State.NORMAL))[-1]
    assert result.state is State.STALE
    assert result.lost == ("date",)
    assert result.detectors["date"].state is State.STALE
    assert "silent for 3.1 s" in result.detectors["date"].reason
    back = feed(one, verdict("date", 3.2, State.NORMAL))[-1]
    assert back.state is State.NORMAL
    assert back.lost == ()


def test_a_detector_that_never_spoke_is_lost_after_a_grace() -> None:
    one = fusion(stale_s=3.0)
    assert feed(one, verdict("date", 10, State.NORMAL))[-1].lost == ()
    assert feed(one, verdict("date", 13, State.NORMAL))[-1].lost == ()
    result = feed(one, verdict("date", 13.1, State.NORMAL))[-1]
    assert result.lost == ("correlation",)
    assert result.state is State.STALE


def test_a_stale_alarm_does_not_hide_behind_its_age() -> None:
    """An alert that was given stays, whoever falls silent afterwards."""
    one = fusion("any")
    feed(one, verdict("date", 0, State.ALARM))
    result = feed(one, verdict("correlation", 100, State.NORMAL))[-1]
    assert result.alert
    assert result.lost == ("date",)


@pytest.mark.parametrize(
    ("correlation", "date", "expected"),
    [
        (State.NOT_READY, State.NOT_READY, State.NOT_READY),
        (State.NOT_OBSERVABLE, State.NOT_READY, State.NOT_READY),
        (State.NORMAL, State.NOT_READY, State.NOT_READY),  # only date could see a carry-off
        (State.NORMAL, State.NOT_OBSERVABLE, State.NOT_OBSERVABLE),
        (State.NOT_OBSERVABLE, State.NORMAL, State.NORMAL),
        (State.NORMAL, State.SUSPICIOUS, State.SUSPICIOUS),
        (State.STALE, State.NORMAL, State.STALE),
        (State.STALE, State.SUSPICIOUS, State.SUSPICIOUS),
        (State.NORMAL, State.ALARM, State.SUSPICIOUS),
        (State.ALARM, State.NORMAL, State.NORMAL),  # correlation alone is no ground for doubt
        (State.ALARM, State.SUSPICIOUS, State.SUSPICIOUS),
    ],
)
def test_the_state_is_the_worst_claim_that_can_be_made(
    correlation: State, date: State, expected: State
) -> None:
    result = feed(fusion(), *both(1, correlation, date))[-1]
    assert result.state is expected
    assert not result.alert


margins = st.floats(0.0, 100.0)


@given(margins, margins, margins)
def test_confidence_is_within_bounds_and_grows_with_each_margin(
    a: float, b: float, more: float
) -> None:
    def confidence(first: float, second: float) -> float:
        return feed(
            fusion(),
            verdict("correlation", 1, State.NORMAL, first),
            verdict("date", 1, State.NORMAL, second),
        )[-1].confidence

    low = confidence(a, b)
    assert 0.0 <= low <= 1.0
    assert confidence(a + more, b) >= low
    assert confidence(a, b + more) >= low
    assert math.isfinite(low)


def test_a_policy_that_does_not_exist_is_refused() -> None:
    with pytest.raises(ParameterError, match="policy"):
        fusion("both")


ALL = (*NAMES, "kld", "coast", "drag")


def calibrated(**parameters: float) -> Fusion:
    return Fusion(FusionParameters.from_mapping(parameters), heard(*ALL))


def alarm(name: str, at_s: float, margin: float = 3.0) -> Verdict:
    return verdict(name, at_s, State.ALARM, margin)


def test_the_probability_is_that_of_the_likelihood_ratios() -> None:
    """Ln odds = ln prior odds + Σ ln ratios; 0.1 is a prior of 1 : 9."""
    said = [verdict(name, 1, State.NORMAL, 0.6) for name in ALL]
    result = feed(calibrated(), *said)[-1]
    ratio = math.exp(together({name: RATIOS[name](0.6) for name in ALL}, WEIGHTS))
    assert result.confidence == pytest.approx(ratio / 9.0 / (1.0 + ratio / 9.0), rel=1e-12)


@pytest.mark.parametrize("state", [State.NOT_READY, State.NOT_OBSERVABLE, State.STALE])
def test_a_detector_that_cannot_tell_says_nothing(state: State) -> None:
    said = [verdict(name, 1, state, 50.0) for name in ALL]
    assert feed(calibrated(), *said)[-1].confidence == pytest.approx(0.1)


@pytest.mark.parametrize("name", ["kld", "coast"])
def test_default_alerts_on_a_strong_detector_alone_when_it_lasts(name: str) -> None:
    first, second, third = feed(calibrated(), alarm(name, 1), alarm(name, 1.1), alarm(name, 1.2))
    assert not first.alert
    assert not second.alert
    assert third.alert
    assert third.causes == (name,)
    assert third.confidence > 0.6
    assert f"{name} says so" in third.reason


@pytest.mark.parametrize(
    ("name", "state"), [("correlation", State.NORMAL), ("drag", State.SUSPICIOUS)]
)
def test_default_never_alerts_on_what_has_innocent_causes(name: str, state: State) -> None:
    one = Fusion(FusionParameters(), heard(name))
    for at in range(100):
        result = feed(one, alarm(name, at, 50.0))[-1]
        assert not result.alert
        assert result.state is state


def test_time_in_which_the_odds_were_high_before_an_alarm_counts() -> None:
    one = calibrated()
    odds_high = [verdict("coast", at_s, State.SUSPICIOUS, 1.05) for at_s in (10.0, 10.1, 10.2)]
    assert not any(result.alert for result in feed(one, *odds_high))
    assert feed(one, alarm("coast", 10.3))[-1].alert_since_ns == round(10.3 * SECOND)


@pytest.mark.parametrize("policy", ["any", "paper"])
def test_the_other_policies_report_the_doubt_of_any_detector(policy: str) -> None:
    (result,) = feed(fusion(policy), verdict("correlation", 1, State.SUSPICIOUS))
    assert result.state is State.SUSPICIOUS


def test_detectors_near_to_their_limits_never_alert_without_one_beyond_its_own() -> None:
    one = calibrated()
    for t in range(1, 20):
        near = [verdict(name, t, State.NORMAL, 0.99) for name in RATIOS]
        assert not any(result.alert for result in (feed(one, said)[-1] for said in near))


@given(
    st.lists(
        st.tuples(
            st.sampled_from(sorted({*RATIOS, *ADVISORY})),
            st.sampled_from([State.NORMAL, State.SUSPICIOUS, State.ALARM, State.NOT_READY]),
            st.floats(0.0, 5.0),
        ),
        max_size=60,
    )
)
def test_an_alert_names_a_detector_beyond_its_limit_and_nothing_else(
    said: list[tuple[str, State, float]],
) -> None:
    one = calibrated()
    for at, (name, state, margin) in enumerate(said):
        within = max(margin, 1.01) if state is State.ALARM else min(margin, 0.99)
        result = feed(one, verdict(name, 0.1 * at, state, within))[-1]
    if said and result.alert:
        alarmed = {name for name, state, _ in said if state is State.ALARM}
        assert {*result.causes} <= alarmed
        assert {*result.causes} - SOFT - ADVISORY


def test_every_part_votes_or_is_advisory_and_none_is_both() -> None:
    assert {*DETECTORS} == {*RATIOS, *ADVISORY}
    assert not ADVISORY & RATIOS.keys()
    assert ADVISORY <= SOFT


@pytest.mark.parametrize("name", DETECTORS)
def test_who_votes_can_move_the_probability_and_who_cannot_never_degrades(name: str) -> None:
    def quiet(at_s: float) -> list[Verdict]:
        return [verdict(other, at_s, State.NORMAL, 0.1) for other in DETECTORS if other != name]

    loud, calm, silent, unready = (Fusion(FusionParameters(), WEIGHTS) for _ in range(4))
    high = feed(loud, *quiet(1), verdict(name, 1, State.ALARM, 3.0))[-1]
    low = feed(calm, *quiet(1), verdict(name, 1, State.NORMAL, 0.1))[-1]
    gone = feed(silent, *quiet(1), *quiet(9))[-1]
    late_s = 2.0 * FusionParameters().overdue_s
    feed(unready, *(verdict(name, at, State.NOT_READY) for at in range(round(late_s))))
    late = feed(unready, *quiet(late_s), verdict(name, late_s, State.NOT_READY))[-1]
    if name in ADVISORY:
        assert high.confidence == low.confidence
        assert high.state is gone.state is late.state is State.NORMAL
        assert not gone.degraded + late.degraded
    else:
        assert high.confidence > low.confidence
        assert name in gone.degraded
        assert name in late.degraded


def test_a_probability_without_an_alarm_is_suspicious_and_no_alert() -> None:
    one = calibrated()
    for at in range(100):
        said = [verdict(name, at, State.NORMAL, 0.9) for name in ("coast", "gnss", "altitude")]
        result = feed(one, *said)[-1]
        assert result.confidence >= 0.9
        assert not result.alert
    assert result.state is State.SUSPICIOUS


def result_state(one: Fusion) -> State:
    return feed(one, verdict("date", 100, State.NORMAL))[-1].state


@pytest.mark.parametrize(("apart_s", "together"), [(4.9, True), (5.1, False)])
def test_margins_close_in_time_count_together(apart_s: float, together: bool) -> None:
    one = calibrated(stale_s=100.0)
    alone = feed(calibrated(), verdict("date", 0, State.NORMAL, 0.9))[-1].confidence
    feed(one, verdict("coast", 0, State.NORMAL, 0.9))
    both_heard = feed(one, verdict("date", apart_s, State.NORMAL, 0.9))[-1].confidence
    assert (both_heard > alone) is together


def test_a_warning_ends_at_half_of_what_began_it() -> None:
    """With warn_probability p it begins at p and ends below p / 2."""
    one = calibrated(together_s=0.0, warn_probability=0.3)

    def chance(margin: float) -> float:
        said = verdict("date", 1, State.NORMAL, margin)
        return feed(calibrated(), said)[-1].confidence

    margin = next(m / 100 for m in range(1, 100) if chance(m / 100) >= 0.16)
    assert chance(margin) < 0.29
    said = feed(one, verdict("date", 1, State.NORMAL, margin))[-1]
    assert said.state is not State.SUSPICIOUS
    assert feed(one, verdict("coast", 2, State.NORMAL, 5.0))[-1].state is State.SUSPICIOUS
    assert feed(one, verdict("date", 3, State.NORMAL, margin))[-1].state is State.SUSPICIOUS
    assert feed(one, verdict("date", 4, State.NORMAL, 0.0))[-1].state is not State.SUSPICIOUS


def test_an_alarm_that_kld_keeps_does_not_alert_again_after_a_reset() -> None:
    one = calibrated()
    assert feed(one, alarm("kld", 1), alarm("kld", 1.3))[-1].alert
    one.reset()
    result = feed(one, alarm("kld", 2), alarm("kld", 3))[-1]
    assert not result.alert
    assert result.state is State.SUSPICIOUS
    assert feed(one, alarm("coast", 3), alarm("coast", 3.5))[-1].causes == ("coast",)
    one.reset()
    results = feed(one, verdict("kld", 4, State.NORMAL), alarm("kld", 5), alarm("kld", 6))
    assert results[-1].causes == ("kld",)


def test_the_paper_asks_the_papers_detectors() -> None:
    paper = Fusion(FusionParameters(policy="paper"), heard(*ALL))
    assert feed(paper, verdict("kld", 1, State.NORMAL, 0.9))[-1].confidence == 0.0
    result = feed(paper, alarm("kld", 1), alarm("coast", 1), verdict("date", 2, State.ALARM))[-1]
    assert not result.alert
    assert result.state is State.SUSPICIOUS
    result = feed(paper, verdict("correlation", 3, State.ALARM))[-1]
    assert result.causes == ("date", "correlation")


def test_what_was_heard_out_stays_so_when_the_clock_is_set_back() -> None:
    one, afresh = calibrated(), calibrated()
    feed(one, alarm("kld", 100))
    one.reset()
    afresh.inherit(one)
    assert not feed(afresh, alarm("kld", 1), alarm("kld", 2))[-1].alert
    results = feed(afresh, verdict("kld", 3, State.NORMAL), alarm("kld", 4), alarm("kld", 5))
    assert results[-1].alert


@given(st.lists(st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 20.0)), min_size=1, max_size=40))
def test_the_recent_peak_is_the_largest_of_the_last_seconds(
    steps: list[tuple[float, float]],
) -> None:
    peak, said, at = RecentPeak(5 * SECOND), [], 0.0
    for step, margin in steps:
        at += step
        one = verdict("coast", at, State.NORMAL, margin)
        said.append(one)
        peak.add(one)
        found = peak.at(one.stamp_ns)
        recent = [v.margin for v in said if one.stamp_ns - v.stamp_ns <= 5 * SECOND]
        assert found is not None
        assert found.margin == max(recent)


@given(st.floats(1e-6, 1.0 - 1e-6))
def test_odds_and_probability_are_inverse(chance: float) -> None:
    assert probability(odds(chance)) == pytest.approx(chance, rel=1e-9)


def test_detectors_that_share_a_source_of_error_count_as_one() -> None:
    assert together({"date": 1.0, "gnss": -0.5}, WEIGHTS) == 0.5
    assert together({"date": 1.0, "coast": 2.0, "drag": 2.5}, WEIGHTS) == 2.5
    assert together({"altitude": 1.0, "kld": 2.0, "drag": 2.5}, WEIGHTS) == 4.5
    assert together({"coast": -0.1, "drag": -0.2}, WEIGHTS) == -0.1
    assert together({}, WEIGHTS) == 0.0


def test_a_soft_alarm_supports_an_alert_and_never_makes_one() -> None:
    near = RATIOS["coast"].neutral * 1.2
    calm = fusion("default")
    said = [verdict("drag", t, State.ALARM, 3.0) for t in (1, 2, 3)]
    said += [verdict("coast", 3.5 + 0.1 * k, State.SUSPICIOUS, near) for k in range(9)]
    results = feed(calm, *said)
    assert not any(one.alert for one in results)
    assert feed(calm, *[verdict("date", 4.4 + 0.1 * k, State.ALARM) for k in range(5)])[-1].alert


def with_further(**parameters: float | str) -> Fusion:
    chosen = FusionParameters.from_mapping({"further_detectors": "own", **parameters})
    return Fusion(chosen, {**heard(*NAMES), **chosen.further})


def test_a_further_detector_supports_an_alert_and_never_makes_one() -> None:
    one = with_further(alarm_probability=0.5)
    said = [verdict("own", 1 + 0.1 * k, State.ALARM, 50.0) for k in range(40)]
    results = feed(one, *said)
    assert not any(result.alert for result in results)
    assert results[-1].state is State.SUSPICIOUS
    near = RATIOS["date"].neutral * 1.2
    assert not feed(one, *[verdict("date", 5.0 + 0.1 * k, State.NORMAL, near) for k in range(5)])[
        -1
    ].alert
    (*_, last) = feed(one, *[verdict("date", 5.6 + 0.1 * k, State.ALARM) for k in range(5)])
    assert last.causes == ("date", "own")


def test_a_further_detector_that_is_missing_degrades_the_monitor() -> None:
    one = with_further()
    results = feed(one, *[v for t in range(6) for v in both(t, State.NORMAL, State.NORMAL)])
    assert results[-1].lost == ("own",)
    assert results[-1].state is State.STALE


@pytest.mark.parametrize("names", ["a/b", "own own", "1st", "with-dash"])
def test_names_that_no_topic_can_have_are_refused(names: str) -> None:
    with pytest.raises(ParameterError, match="further_detectors"):
        FusionParameters(further_detectors=names)


@pytest.mark.parametrize("name", ["coast", "fusion", "course"])
def test_a_name_of_our_own_is_refused(name: str) -> None:
    with pytest.raises(ParameterError, match=f"'{name}'"):
        weights(FusionParameters(further_detectors=name))


def test_a_further_detector_with_a_weight_makes_an_alert_of_its_own() -> None:
    one = with_further(further_weights="own=10.0,0.6,-0.1,5.0")
    (*_, last) = feed(one, *[verdict("own", 1 + 0.1 * k, State.ALARM, 2.0) for k in range(5)])
    assert last.causes == ("own",)
    ratio = math.exp(5.0) / 9.0
    assert last.confidence == pytest.approx(ratio / (1.0 + ratio))


@pytest.mark.parametrize(
    "words",
    [
        "",
        ",supports",
        ",velocity",
        ",carry_off,height",
        ",supports,carry_off,velocity",
        ",keeps_alarm",
    ],
)
def test_a_weight_reads_back_what_it_writes(words: str) -> None:
    one = Weight.from_text(f"10.0,0.6,-0.1,5.0{words}")
    assert one.ratio == LikelihoodRatio(10.0, 0.6, -0.1, 5.0)
    assert (one.may_alert, one.sees_carry_off) == ("supports" not in words, "carry_off" in words)
    assert one.shares in words
    assert one.keeps_alarm == ("keeps_alarm" in words)
    assert Weight.from_text(one.text) == one


def test_an_advisory_weight_never_alerts() -> None:
    one = Weight.from_text("advisory")
    assert (one.ratio, one.may_alert) == (None, False)
    assert Weight.from_text(one.text) == one


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("own=1,2,3", "it takes four numbers"),
        ("own", "could not convert"),
        ("own=1,0.5,-0.1,nan", "it takes four numbers"),
        ("own=-1,0.5,-0.1,3", "SLOPE and NEUTRAL must be above 0"),
        ("own=1,0.5,0.1,3", "0 from LOW to HIGH"),
        ("own=1,0.5,-0.1,3,suports", "'suports'"),
        ("own=1,0.5,-0.1,3,velocity,height", "'height'"),
        ("other=1,0.5,-0.1,3", "'other', which 'further_detectors' has not"),
    ],
)
def test_a_weight_that_cannot_be_one_is_refused(given: str, told: str) -> None:
    with pytest.raises(ParameterError, match=f"'further_weights'.*{told}"):
        with_further(further_weights=given)
