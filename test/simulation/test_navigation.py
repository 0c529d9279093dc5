# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The autopilot's navigation trusts its GPS: a smooth motion at once, a jump when it lasts."""

from collections.abc import Callable

import pytest

from hijack_detect.simulation.navigation import RESET_S, Navigation
from hijack_detect.streams.samples import Vector3

STEP_S = 0.02
FIX_EVERY = 10
Path = Callable[[float], Vector3]


def still(_: float) -> Vector3:
    return (0.0, 0.0, 0.0)


def run(position: Path, velocity: Path = still, seconds: float = 30.0) -> Navigation:
    """Navigate a vehicle that stands still at height 0, with these reports."""
    navigation = Navigation(STEP_S)
    for step in range(round(seconds / STEP_S)):
        now = step * STEP_S
        navigation.predict((0.0, 0.0, 0.0))
        if step % FIX_EVERY == 0:
            navigation.correct(position(now), velocity(now), 0.0, now)
    return navigation


def test_true_reports_change_nothing() -> None:
    navigation = run(still)
    assert navigation.position == navigation.velocity == (0.0, 0.0, 0.0)


def test_a_smooth_pull_is_followed() -> None:
    navigation = run(lambda t: (2.0 * t, 0.0, 0.0), lambda _: (2.0, 0.0, 0.0))
    assert navigation.position[0] == pytest.approx(2.0 * 30.0, abs=1.0)
    assert navigation.velocity[0] == pytest.approx(2.0, abs=0.1)


def test_a_pull_of_the_position_alone_is_followed_with_a_lag() -> None:
    navigation = run(lambda t: (2.0 * t, 0.0, 0.0))
    assert 50.0 < navigation.position[0] < 60.0


def test_a_small_jump_is_taken_in() -> None:
    navigation = run(lambda t: (8.0 if t > 5.0 else 0.0, 0.0, 0.0), seconds=12.0)
    assert navigation.position[0] == pytest.approx(8.0, abs=0.3)


def test_a_large_jump_is_refused_until_the_receiver_has_insisted() -> None:
    def jump(t: float) -> Vector3:
        return (100.0 if t >= 5.0 else 0.0, 0.0, 0.0)

    assert run(jump, seconds=5.0 + RESET_S - 0.2).position[0] == 0.0
    assert run(jump, seconds=5.0 + RESET_S + 1.0).position[0] == pytest.approx(100.0)


def test_a_glitch_leaves_no_trace() -> None:
    navigation = run(lambda t: (500.0 if 5.0 <= t < 7.0 else 0.0, 0.0, 0.0))
    assert navigation.position == (0.0, 0.0, 0.0)


def test_a_false_height_is_followed_within_seconds() -> None:
    navigation = run(lambda t: (0.0, 0.0, 15.0 if t > 5.0 else 0.0))
    assert navigation.position[2] == pytest.approx(15.0, abs=0.3)
    assert navigation.velocity[2] == pytest.approx(0.0, abs=0.1)
