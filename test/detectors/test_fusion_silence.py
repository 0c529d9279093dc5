# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the fusion says when nothing comes any more, and when it comes again."""

import math

from hijack_detect.detectors.fusion import Fusion, FusionResult
from hijack_detect.detectors.likelihood import FusionParameters
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.parts import WEIGHTS

SECOND = 10**9


def verdict(name: str, at_s: float, state: State) -> Verdict:
    score = 2.0 if state is State.ALARM else 0.1
    return Verdict(name, round(at_s * SECOND), state, score, 1.0, f"{name} says so")


def test_after_a_hole_it_is_stale_until_somebody_can_tell_again() -> None:
    names = ("gnss", "coast", "date")
    one = Fusion(FusionParameters(), {name: WEIGHTS[name] for name in names})

    def said(at_s: float, *states: State) -> FusionResult:
        for name, state in zip(names, states, strict=True):
            result = one.update(name, verdict(name, at_s, state))
        return result

    calm = [State.NORMAL] * 3
    assert said(0.0, *calm).state is State.NORMAL
    assert said(1.9, *calm).state is State.NORMAL
    first = one.update("gnss", verdict("gnss", 4.1, State.NORMAL))
    assert (first.state, first.lost) == (State.STALE, ("coast", "date"))
    for at_s in (4.2, 5.2, 6.2):
        unready = said(at_s, State.NORMAL, State.NOT_READY, State.NOT_OBSERVABLE)
        assert unready.state is State.STALE
        assert math.isnan(unready.claim)
        assert "all inputs had stopped" in unready.reason
    again = said(7.2, State.NORMAL, State.NOT_READY, State.NORMAL)
    assert (again.state, again.claim) == (State.NORMAL, again.confidence)
    late = said(8.2, State.NORMAL, State.NOT_READY, State.NOT_OBSERVABLE)
    assert late.state is State.NOT_OBSERVABLE
    assert math.isnan(late.claim)


def test_a_vehicle_that_stands_is_not_stale_for_ever_after_a_hole() -> None:
    one = Fusion(FusionParameters(), {name: WEIGHTS[name] for name in ("coast", "date")})
    for at_s in (0.0, 4.0):
        for name in ("coast", "date"):
            one.update(name, verdict(name, at_s, State.NOT_OBSERVABLE))
    last = one.update("coast", verdict("coast", 4.2, State.NOT_OBSERVABLE))
    assert last.state is State.NOT_OBSERVABLE


def test_silence_by_the_clock_takes_no_alert_back_and_gives_none() -> None:
    weights = {"date": WEIGHTS["date"]}
    calm, alarmed = (Fusion(FusionParameters(policy="any"), weights) for _ in range(2))
    quiet = calm.update("date", verdict("date", 1.0, State.NORMAL)).silent(2.1)
    assert (quiet.state, quiet.alert, quiet.lost) == (State.STALE, False, ("date",))
    assert math.isnan(quiet.claim)
    assert quiet.stamp_ns == SECOND
    kept = alarmed.update("date", verdict("date", 1.0, State.ALARM)).silent(2.1)
    assert (kept.state, kept.alert, kept.claim) == (State.ALARM, True, 1.0)
