"""One alert from several verdicts."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.detectors.fusion import Fusion, FusionParameters, FusionResult
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.parameters import ParameterError

SECOND = 10**9
NAMES = ("correlation", "date")


def verdict(name: str, at_s: float, state: State, margin: float | None = None) -> Verdict:
    usual = {State.ALARM: 1.5, State.SUSPICIOUS: 1.1, State.NORMAL: 0.1}
    margin = usual.get(state, 0.0) if margin is None else margin
    return Verdict(name, round(at_s * SECOND), state, 2.0 * margin, 2.0, f"{name} says so")


def fusion(policy: str = "default", **parameters: float) -> Fusion:
    return Fusion(FusionParameters.from_mapping({"policy": policy, **parameters}), NAMES)


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


@pytest.mark.parametrize("state", [one for one in State if one is not State.ALARM])
@pytest.mark.parametrize("policy", ["any", "default", "paper"])
def test_nothing_but_an_alarm_alerts(policy: str, state: State) -> None:
    one = fusion(policy)
    for at in range(10):
        for name in NAMES:
            assert not one.update(name, verdict(name, at, state)).alert


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


def test_default_alerts_on_date_alone() -> None:
    result = feed(fusion(), verdict("date", 1, State.ALARM, 1.01))[-1]
    assert result.alert


def test_default_never_alerts_on_the_correlation_alone() -> None:
    one = fusion()
    for at in range(100):
        results = feed(
            one, verdict("correlation", at, State.ALARM, 50.0), verdict("date", at, State.NORMAL)
        )
        assert not any(result.alert for result in results)
    assert results[-1].state is State.SUSPICIOUS


@pytest.mark.parametrize(("margin", "alert"), [(0.79, False), (0.81, True)])
@pytest.mark.parametrize("first", NAMES)
def test_default_alerts_on_the_correlation_with_date_close(
    first: str, margin: float, alert: bool
) -> None:
    turned = verdict("correlation", 1, State.ALARM)
    close = verdict("date", 1, State.NORMAL, margin)
    ordered = (turned, close) if first == "correlation" else (close, turned)
    assert feed(fusion(), *ordered)[-1].alert is alert


@pytest.mark.parametrize(("apart_s", "alert"), [(4.9, True), (5.1, False)])
@pytest.mark.parametrize("first", NAMES)
def test_default_counts_as_one_event_only_what_is_close_in_time(
    first: str, apart_s: float, alert: bool
) -> None:
    one = fusion(stale_s=100.0)
    second = "date" if first == "correlation" else "correlation"
    kinds = {"correlation": (State.ALARM, 1.5), "date": (State.NORMAL, 0.9)}
    results = feed(one, verdict(first, 0, *kinds[first]), verdict(second, apart_s, *kinds[second]))
    assert results[-1].alert is alert


def test_the_alert_is_latched_until_reset() -> None:
    one = fusion("any")
    feed(one, verdict("date", 1, State.ALARM))
    for at in range(2, 100):
        for result in feed(one, *both(at, State.NORMAL, State.NORMAL)):
            assert result.alert
            assert result.alert_since_ns == SECOND
            assert result.state is State.ALARM
            assert result.confidence == 1.0
            assert "date alarm" in result.reason
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
    assert feed(one, verdict("correlation", 3.0, State.NORMAL))[-1].state is State.NORMAL
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
        (State.NOT_OBSERVABLE, State.NOT_READY, State.NOT_OBSERVABLE),
        (State.NOT_OBSERVABLE, State.NORMAL, State.NORMAL),
        (State.NORMAL, State.SUSPICIOUS, State.SUSPICIOUS),
        (State.STALE, State.NORMAL, State.STALE),
        (State.STALE, State.SUSPICIOUS, State.SUSPICIOUS),
        (State.ALARM, State.NORMAL, State.SUSPICIOUS),
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


def test_confidence_is_a_half_for_one_detector_at_its_threshold() -> None:
    one = fusion()
    assert feed(one, verdict("date", 1, State.NORMAL, 0.0))[-1].confidence == 0.0
    assert feed(one, verdict("date", 2, State.NORMAL, 1.0))[-1].confidence == pytest.approx(0.5)


def test_a_policy_that_does_not_exist_is_refused() -> None:
    with pytest.raises(ParameterError, match="policy"):
        fusion("both")


def three(policy: str) -> Fusion:
    return Fusion(FusionParameters(policy=policy), (*NAMES, "kld"))


def test_kld_is_one_more_voter_and_none_of_the_papers() -> None:
    alarm = verdict("kld", 1, State.ALARM)
    assert feed(three("default"), alarm)[-1].causes == ("kld",)
    assert feed(three("any"), alarm)[-1].alert
    paper = three("paper")
    result = feed(paper, alarm, verdict("date", 2, State.ALARM))[-1]
    assert not result.alert
    assert result.state is State.SUSPICIOUS
    result = feed(paper, verdict("correlation", 3, State.ALARM))[-1]
    assert result.alert
    assert result.causes == ("date", "correlation")


def test_with_the_correlation_a_close_kld_alerts() -> None:
    one = three("default")
    result = feed(
        one, verdict("kld", 1, State.NORMAL, 0.9), verdict("correlation", 2, State.ALARM)
    )[-1]
    assert result.causes == ("correlation", "kld")


def test_an_alarm_that_kld_keeps_does_not_alert_again_after_a_reset() -> None:
    one = three("default")
    assert feed(one, verdict("kld", 1, State.ALARM))[-1].alert
    one.reset()
    result = feed(one, verdict("kld", 2, State.ALARM))[-1]
    assert not result.alert
    assert result.state is State.SUSPICIOUS
    assert feed(one, verdict("date", 3, State.ALARM))[-1].causes == ("date",)
    one.reset()
    results = feed(one, verdict("kld", 4, State.NORMAL), verdict("kld", 5, State.ALARM))
    assert results[-1].causes == ("kld",)


def test_the_papers_confidence_asks_the_papers_detectors() -> None:
    margin = verdict("kld", 1, State.NORMAL, 0.9)
    assert feed(three("paper"), margin)[-1].confidence == 0.0
    assert feed(three("default"), margin)[-1].confidence > 0.4


def test_what_was_heard_out_stays_so_when_the_clock_is_set_back() -> None:
    one, afresh = three("default"), three("default")
    feed(one, verdict("kld", 100, State.ALARM))
    one.reset()
    afresh.inherit(one)
    assert not feed(afresh, verdict("kld", 1, State.ALARM))[-1].alert
    results = feed(afresh, verdict("kld", 2, State.NORMAL), verdict("kld", 3, State.ALARM))
    assert results[-1].alert
