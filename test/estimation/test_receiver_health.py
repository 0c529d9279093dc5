# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a receiver admits of itself: each figure, as long as it lasts; nothing of a good one."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.estimation.receiver_health import (
    ACCURACY,
    NO_FIX,
    SATELLITES,
    VERTICAL,
    ReceiverHealth,
    ReceiverLimits,
    poor_words,
)
from hijack_detect.streams.samples import NANOSECONDS, FixSample, SatelliteSample

LIMITS = ReceiverLimits(no_fix_s=3.0, accuracy_m=5.0, vertical_accuracy_m=7.5, satellites=6)
GPS_HZ, IMU_HZ = 5, 5
"""Messages of the receiver, and phases of the flight."""


def flown(
    seconds: float,
    accuracy_m: Callable[[float], float | None] = lambda _: 1.0,
    vertical_m: Callable[[float], float | None] = lambda _: 2.0,
    satellites: Callable[[float], int | None] = lambda _: 10,
    *,
    no_fix: tuple[float, float] = (math.inf, math.inf),
    silent: tuple[float, float] = (math.inf, math.inf),
    hole: tuple[float, float] = (math.inf, math.inf),
) -> list[dict[str, float]]:
    """What is poor every 0.2 s: without a fix, without messages, without those of the IMU too."""
    one, found = ReceiverHealth(LIMITS), []
    for k in range(round(seconds * GPS_HZ)):
        at = k / GPS_HZ
        stamp_ns = round(at * NANOSECONDS)
        if hole[0] <= at < hole[1]:
            continue
        one.passes(stamp_ns)
        if not silent[0] <= at < silent[1]:
            has_fix, count = not no_fix[0] <= at < no_fix[1], satellites(at)
            if count is not None:
                one.satellites(SatelliteSample(stamp_ns, count if has_fix else 0))
            one.fix(FixSample(stamp_ns, 48.0, 11.0, 500.0, has_fix, accuracy_m(at), vertical_m(at)))
        found.append(one.poor())
    return found


def test_a_good_receiver_is_not_poor_and_one_that_claims_nothing_neither() -> None:
    assert not any(flown(90.0))
    assert not any(flown(90.0, lambda _: None, lambda _: None, lambda _: None))


@pytest.mark.parametrize(
    ("changed", "name", "value"),
    [
        ({"accuracy_m": lambda _: 6.0}, ACCURACY, 6.0),
        ({"vertical_m": lambda _: 8.0}, VERTICAL, 8.0),
        ({"satellites": lambda _: 5}, SATELLITES, 5),
    ],
)
def test_a_figure_beyond_its_limit_is_said(
    changed: dict[str, Callable[[float], float]], name: str, value: float
) -> None:
    found = flown(20.0, **changed)  # type: ignore[arg-type]
    assert found[-1] == {name: value}
    assert not any(found[:4])  # a few fixes say nothing


def test_a_short_lapse_is_nothing_and_a_long_one_ends_after_10_s() -> None:
    assert not any(flown(40.0, lambda at: 9.0 if 20.0 <= at < 23.0 else 1.0))
    poor = [
        k / GPS_HZ
        for k, one in enumerate(flown(60.0, lambda at: 9.0 if 20 <= at < 40 else 1.0))
        if one
    ]
    assert 24.0 < poor[0] < 26.0
    assert 44.0 < poor[-1] < 46.0


@pytest.mark.parametrize("how", ["no_fix", "silent"])
def test_a_lost_fix_is_said_for_a_minute(how: str) -> None:
    """Messages without a fix, or none at all while the IMU goes on; each loss counts."""
    found = flown(120.0, **{how: (30.0, 36.0)})  # type: ignore[arg-type]
    poor = [k / GPS_HZ for k, one in enumerate(found) if one]
    assert 33.0 <= poor[0] <= 35.0
    assert 90.0 <= poor[-1] <= 96.0
    assert set(found[GPS_HZ * 40]) == {NO_FIX}
    assert found[GPS_HZ * 40][NO_FIX] == pytest.approx(6.0, abs=1.6)
    assert not any(flown(120.0, **{how: (30.0, 32.0)}))  # type: ignore[arg-type]


def test_a_hole_of_the_recording_is_no_lost_fix() -> None:
    assert not any(flown(120.0, hole=(30.0, 90.0)))


def test_the_words_name_what_is_beyond_its_limit_only() -> None:
    figures = {"jump": 0.1, NO_FIX: 7.4, SATELLITES: 4, ACCURACY: 9.24, VERTICAL: 12.0}
    assert poor_words(figures) == (
        "no fix for 7 s of a minute, claims an accuracy of 9.2 m, "
        "claims an accuracy of 12.0 m in height, 4 satellites"
    )
    assert poor_words({"jump": 0.1}) == ""


number = st.none() | st.floats(0.01, 1e4)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.integers(0, 20 * NANOSECONDS), st.booleans(), number, number, st.integers(0, 40)
        ),
        max_size=60,
    )
)
def test_no_messages_break_it_and_no_minute_has_more_than_60_s(
    rows: list[tuple[int, bool, float | None, float | None, int]],
) -> None:
    one, stamp_ns = ReceiverHealth(LIMITS), 0
    for after_ns, has_fix, across, up, count in rows:
        stamp_ns += after_ns
        one.satellites(SatelliteSample(stamp_ns, count))
        one.fix(FixSample(stamp_ns, 48.0, 11.0, 500.0, has_fix, across, up))
        poor = one.poor()
        assert poor.get(NO_FIX, 0.0) <= 60.0
        assert bool(poor_words(poor)) is bool(poor)
