# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a clean result is worth: never more than 100 %, and the cause where it is worth nothing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest
from small_bags import START_NS, STEP_NS, raw, write

from hijack_detect.analysis.account import Account, TakenBack
from hijack_detect.analysis.analyse import analyse
from hijack_detect.analysis.analysis import Analysis, Outcome
from hijack_detect.analysis.worth import not_judged, sensor_notes, visible
from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.detectors.fusion import Fusion
from hijack_detect.detectors.likelihood import FusionParameters
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.parts import DETECTORS, WEIGHTS
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.streams.samples import FixSample, ImuSample, Phase, PhaseSample, Sample

SECOND = 10**9
FLOWN = (Phase.STANDING,) * 10 + (Phase.FLYING,) * 40
"""Phases of 50 s."""


def verdict(at_s: float, state: State, name: str = "coast", visible: float = 0.5) -> Verdict:
    stamp = round(at_s * SECOND)
    return Verdict(
        name, stamp, state, 0.5, 1.0, f"{name} {state.value}", {"smallest_visible": visible}
    )


def account(verdicts: Iterable[Verdict], phases: Iterable[Phase] = FLOWN) -> Account:
    found = Account(DETECTORS, FusionParameters(), 0)
    for second in range(50):
        stamp = second * SECOND
        found.take(ImuSample(stamp, (0.0, 0.0, 0.0), (0.0, 0.0, 9.8)))
        found.take(FixSample(stamp, 48.0, 11.0, 500.0))
    for second, phase in enumerate(phases):
        found.take_output("phase", PhaseSample(second * SECOND, phase, 0, "as told"))
    for one in verdicts:
        found.take_output(one.detector, one)
    return found


def test_the_pull_that_would_have_been_seen_is_that_of_nine_tenths_of_the_time() -> None:
    sizes = {20 + n: 0.31 + 0.01 * n for n in range(18)} | {38: 9.0, 39: 9.0}
    found = account(
        [
            *(verdict(at_s, State.NORMAL, visible=0.1) for at_s in range(10)),  # on the ground
            verdict(10, State.NOT_OBSERVABLE),
            *(verdict(at_s, State.NORMAL, visible=size) for at_s, size in sizes.items()),
            verdict(40, State.NOT_OBSERVABLE),
        ]
    )
    _, watched = found.finish(50 * SECOND)
    assert watched.in_air.seconds == 40.0
    seen = visible(watched)
    assert seen is not None
    assert (seen.acceleration, seen.time_s) == (0.5, 18.0)
    assert watched.seen(9.0).seconds == 20.0


def test_detectors_that_see_no_carry_off_judge_nothing() -> None:
    others = [verdict(at_s, State.NORMAL, name) for name in ("gnss", "kld") for at_s in range(50)]
    found = account([*others, *(verdict(at_s, State.NOT_READY, "drag") for at_s in range(50))])
    spans, watched = found.finish(50 * SECOND)
    assert watched.carry_off.seconds == 0.0
    why = not_judged(found, watched, spans)
    assert why is not None
    assert "drag: drag not_ready" in why
    assert "only gnss, kld could" in why


def test_a_vehicle_on_the_ground_is_not_judged() -> None:
    found = account([verdict(at_s, State.NORMAL) for at_s in range(50)], [Phase.STANDING] * 50)
    spans, watched = found.finish(50 * SECOND)
    assert not_judged(found, watched, spans) == (
        "the vehicle was never in the air (standing: as told)"
    )


def test_an_alert_is_taken_back_when_its_cause_is_quiet_and_counts_again() -> None:
    """The same fusion, but for the reset: until then both are equal."""
    kept = Fusion(FusionParameters(policy="any"), {n: WEIGHTS[n] for n in ("coast", "gnss")})
    taken_back = TakenBack(FusionParameters(policy="any"))
    alerts = []
    for at_s in range(60):
        raised = 10 <= at_s < 15 or at_s in (18, 40)
        one = verdict(at_s, State.ALARM if raised else State.NORMAL)
        assert kept.update("coast", one).alert == (at_s >= 10)
        alerts.append(taken_back.update("coast", one).alert)
    assert [at_s for at_s in range(1, 60) if alerts[at_s] and not alerts[at_s - 1]] == [10, 40]
    assert [at_s for at_s in range(1, 60) if alerts[at_s - 1] and not alerts[at_s]] == [24, 46]


def analysed(path: Path, messages: Iterable[RawMessage]) -> Analysis:
    with BagReader(write(path, messages)) as reader:
        return analyse(reader, policy_parameters("default")).analysis


def flown(
    *, imu_stamp: int = 1, fix_stamp: int = 1, has_fix: bool = True, unit: float = 1.0
) -> list[RawMessage]:
    """An IMU and a receiver over 6 s; stamps are multiplied, the specific force too."""
    messages = []
    for index in range(300):
        at = START_NS + index * STEP_NS
        imu = ImuSample(at * imu_stamp, (0.0, 0.0, 0.001 * (index % 7)), (0.0, 0.0, 9.8 * unit))
        messages.append(raw("/imu/data_raw", imu, at))
        if index % 10 == 0:
            fix = FixSample(at * fix_stamp, 48.0, 11.0, 500.0, has_fix=has_fix)
            messages.append(raw("/gps/fix", fix, at))
    return messages


@pytest.mark.parametrize(
    ("odd", "cause"),
    [
        ({"fix_stamp": 0}, "the header stamps of fix do not advance: all are 0"),
        ({"imu_stamp": 0}, "the header stamps of imu do not advance: all are 0"),
        ({"imu_stamp": 0, "fix_stamp": 0}, "of fix and imu do not advance: all are 0"),
        ({"has_fix": False}, "no usable fix in 30 messages of the receiver"),
        ({"unit": 1 / 9.81}, "reads 0.999 m/s² on average"),
        ({}, "never in the air"),
    ],
)
def test_a_log_that_cannot_be_judged_says_why(
    tmp_path: Path, odd: dict[str, float], cause: str
) -> None:
    found = analysed(tmp_path / "bag", flown(**odd))  # type: ignore[arg-type]
    assert found.outcome is Outcome.NOT_JUDGED
    assert found.not_judged is not None
    assert cause in found.not_judged
    assert found.verdict.startswith("The flight could not be judged: ")
    assert found.judged_s == 0.0


@pytest.mark.parametrize("jump_s", [-3600.0, 40.0])
def test_clocks_that_jump_are_named_and_no_share_is_above_the_whole(
    tmp_path: Path, jump_s: float
) -> None:
    shift = round(jump_s * SECOND)
    messages = []
    for index, one in enumerate(flown()):
        jumped = index > 150
        stamp = one.log_ns + (shift if jumped else 0)
        if one.topic == "/imu/data_raw":
            sample: Sample = ImuSample(stamp, (0.0, 0.0, 0.0), (0.0, 0.0, 9.8))
        else:
            sample = FixSample(stamp, 48.0, 11.0, 500.0)
        messages.append(raw(one.topic, sample, one.log_ns))
    found = analysed(tmp_path / "bag", messages)
    how = "were set back by 3600.0 s" if jump_s < 0.0 else "jumped ahead by 40.0 s"
    assert found.notes == (f"The header stamps of fix and imu {how}.",)
    assert found.judged_s <= found.in_air_s <= found.duration_s
    for one in found.detectors.values():
        assert one.told_s <= found.in_air_s
        assert sum(one.state_s.values()) <= found.duration_s + 1e-5
        assert one.largest_margin is None or 0.0 <= one.largest_margin.at_s <= found.duration_s


def poor(at_s: float, figures: dict[str, float]) -> Verdict:
    return Verdict("gnss", round(at_s * SECOND), State.NORMAL, 0.1, 1.0, "calm", figures)


def test_a_poor_receiver_is_noted_with_its_worst_figures() -> None:
    found = account(
        [
            *(poor(at_s, {}) for at_s in range(10)),
            *(poor(at_s, {"poor_satellites": 5, "poor_accuracy": 6.0}) for at_s in range(10, 18)),
            *(poor(at_s, {"poor_satellites": 4}) for at_s in range(18, 20)),
            *(poor(at_s, {}) for at_s in range(20, 50)),
        ]
    )
    found.finish(50 * SECOND)
    worst = "claims an accuracy of 6.0 m, 4 satellites"
    said = f"The receiver is poor by its own word for 10 s (20 %): {worst}."
    assert said in [*sensor_notes(found, 50.0)]
    slow = account([poor(at_s, {"clock_rate": 13 / 12}) for at_s in range(50)])
    (note,) = sensor_notes(slow, 50.0)
    assert note.startswith("The clock of the stamps runs 7.7 % slow: ")
    good = account([poor(at_s, {}) for at_s in range(50)])
    good.finish(50 * SECOND)
    assert not [*sensor_notes(good, 50.0)]


def test_a_late_gps_is_noted_with_its_largest_lag_if_it_lasts() -> None:
    def lagging(at_s: float, lag_s: float) -> Verdict:
        return replace(verdict(at_s, State.NORMAL), values={"late_gps": lag_s} if lag_s else {})

    lags = [0.0] * 10 + [0.35] * 8 + [0.38] * 2 + [0.0] * 30
    found = account(lagging(at_s, lag_s) for at_s, lag_s in enumerate(lags))
    found.finish(50 * SECOND)
    assert found.late.lasted_ns == 10 * SECOND
    said = "The GPS is late for 10 s (20 %): lags by 0.38 s or more."
    assert [*sensor_notes(found, 50.0)] == [said]
    soon = account(lagging(at_s, 0.35 if at_s < 4 else 0.0) for at_s in range(50))
    soon.finish(50 * SECOND)
    assert not [*sensor_notes(soon, 50.0)]


def test_a_slow_imu_is_named_by_its_rate_and_not_by_what_follows_from_it() -> None:
    found = account([])
    for second in range(50, 100):
        light = "the mean specific force in flight is 6.4 m/s²"
        found.take_output(
            "phase", PhaseSample(second * SECOND, Phase.FLYING, 0, "as told", 10.0, light)
        )
    spans, watched = found.finish(100 * SECOND)
    assert not_judged(found, watched, spans) == (
        "the IMU cannot be used: it arrives at 10 Hz, 22 Hz are needed"
    )
