# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Components that a receiver does not measure are NaN, never 0."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.streams.messages import (
    HEIGHT,
    REPEATS,
    SATELLITES,
    UNKNOWN_COUNT,
    VERTICAL_VELOCITY,
    Absence,
)
from hijack_detect.streams.samples import NANOSECONDS, FixSample, VelocitySample

STEP_NS = NANOSECONDS // 5


def velocities(ups: list[float], east: float = 3.0) -> list[VelocitySample]:
    return [VelocitySample(k * STEP_NS, (east, 0.0, up)) for k, up in enumerate(ups)]


def fixes(heights: list[float], speed: float = 5.0) -> list[FixSample]:
    return [
        FixSample(k * STEP_NS, 48.0 + speed * 0.2 * k / 111_320.0, 11.0, height)
        for k, height in enumerate(heights)
    ]


def marked(absence: Absence, samples: list[VelocitySample]) -> list[bool]:
    return [absence(sample).has_vertical for sample in samples]  # type: ignore[union-attr]


def measured(absence: Absence, samples: list[FixSample]) -> list[bool]:
    return [absence(sample).has_altitude for sample in samples]  # type: ignore[union-attr]


def test_a_climb_that_is_0_from_the_start_is_absent_until_it_is_not() -> None:
    absence = Absence()
    assert marked(absence, velocities([0.0] * 30 + [0.1, 0.0, -0.2])) == [False] * 30 + [True] * 3
    assert absence.names == [VERTICAL_VELOCITY]


def test_a_climb_that_becomes_0_in_motion_is_absent_after_some_samples() -> None:
    found = marked(Absence(), velocities([0.1] + [0.0] * 40 + [0.3]))
    assert found == [True] * REPEATS + [False] * (41 - REPEATS) + [True]


def test_standing_still_with_a_climb_of_0_is_no_evidence() -> None:
    absence = Absence()
    assert all(marked(absence, velocities([0.1] + [0.0] * 100, east=0.0)))
    assert not absence.names


def test_a_height_of_0_is_absent_from_the_first_fix() -> None:
    absence = Absence()
    assert not any(measured(absence, fixes([0.0] * 50)))
    assert absence.names == [HEIGHT]


def test_a_height_that_never_changes_is_absent_once_the_vehicle_has_moved() -> None:
    found = measured(Absence(), fixes([47.0] * 100))
    assert all(found[:30])
    assert not any(found[32:])


def test_a_height_that_has_changed_is_measured() -> None:
    assert all(measured(Absence(), fixes([47.0, 47.1] + [47.0] * 200)))
    assert all(measured(Absence(), fixes([47.0] * 200, speed=0.0)))


def test_an_unknown_number_of_satellites_is_none() -> None:
    absence = Absence()
    counts = [0, 0, 9, 0, UNKNOWN_COUNT]
    assert [absence(count) for count in counts] == [None, None, 9, 0, None]
    assert absence.counts[SATELLITES] == 3


def test_another_recording_begins_anew() -> None:
    absence = Absence()
    stream = [VelocitySample(60 * NANOSECONDS, (3.0, 0.0, 1.0)), *velocities([0.0] * 3)]
    assert marked(absence, stream) == [True, False, False, False]


@given(
    st.lists(st.sampled_from([0.0, 0.0, 0.0, 0.2, math.nan]), max_size=120),
    st.sampled_from([0.0, 3.0]),
)
def test_marking_twice_is_marking_once(ups: list[float], east: float) -> None:
    once, twice = Absence(), Absence()
    for sample in velocities(ups, east):
        found = once(sample)
        assert found is not None
        assert twice(found) is found
