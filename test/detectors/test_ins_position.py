# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Dead reckoning against GPS, on motions worked out by hand."""

from __future__ import annotations

import math

import pytest
from scipy.spatial.transform import Rotation

from hijack_detect.detectors.ins_position import InsPosition, InsPositionParameters
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.streams.samples import AttitudeSample, FixSample, VelocitySample

MS = 1_000_000
GRAVITY = 9.80665
METRES_PER_DEGREE = math.radians(6_335_439.327)  # along the meridian, at the equator
LEVEL = Rotation.identity()


def attitude(ms: int, force: tuple[float, float, float], turn: Rotation = LEVEL) -> AttitudeSample:
    q = tuple(turn.as_quat().tolist())
    return AttitudeSample(ms * MS, q, 0.0, (0.0, 0.0, 0.0), force)


def fix(ms: int, north_m: float) -> FixSample:
    return FixSample(ms * MS, north_m / METRES_PER_DEGREE, 11.0, 0.0)


def flown(
    force: tuple[float, float, float],
    *,
    turn: Rotation = LEVEL,
    speed: float = 0.0,
    acceleration: float = 0.0,
    seconds: int = 20,
    with_velocity: bool = True,
    **parameters: float,
) -> list[Verdict]:
    """Verdicts of a flight to the North whose accelerometer reads `force` throughout."""
    detector = InsPosition(InsPositionParameters(**parameters))
    verdicts = []
    for ms in range(0, seconds * 1000 + 1, 20):
        verdicts.append(detector.update("attitude", attitude(ms, force, turn)))
        if ms % 200 == 0:
            t = ms / 1000
            now = speed + acceleration * t
            if with_velocity:
                detector.update("velocity", VelocitySample(ms * MS, (0.0, now, 0.0)))
            north = speed * t + acceleration * t * t / 2
            verdicts.append(detector.update("fix", fix(ms, north)))
    return [verdict for verdict in verdicts if verdict is not None]


@pytest.mark.parametrize("bias", [0.01, 0.05, -0.2])
def test_a_bias_of_the_accelerometer_grows_with_half_its_square_of_time(bias: float) -> None:
    last = flown((bias, 0.0, GRAVITY))[-1]
    assert last.score == pytest.approx(0.5 * abs(bias) * 20.0**2, abs=1e-3)
    assert last.state is (State.ALARM if last.score > 10.0 else State.NORMAL)


def test_a_constant_acceleration_is_followed_exactly() -> None:
    verdicts = flown((0.0, 0.5, GRAVITY), speed=3.0, acceleration=0.5)
    assert {verdict.state for verdict in verdicts} == {State.NORMAL}
    assert max(verdict.score for verdict in verdicts) < 0.02


def test_the_force_is_turned_into_the_world() -> None:
    turn = Rotation.from_euler("ZYX", [70.0, 10.0, -20.0], degrees=True)
    force = tuple(turn.inv().apply([0.0, 0.5, GRAVITY]).tolist())
    assert max(verdict.score for verdict in flown(force, turn=turn, acceleration=0.5)) < 0.02


def test_the_first_alarm_comes_when_the_limit_is_passed() -> None:
    verdicts = flown((0.05, 0.0, GRAVITY), max_distance_m=5.0)
    first = next(verdict for verdict in verdicts if verdict.state is State.ALARM)
    # 0.5 · 0.05 · t² passes 5 m at sqrt(200) = 14.1 s.
    assert first.stamp_ns == 14_200 * MS
    assert first.margin == pytest.approx(0.5 * 0.05 * 14.2**2 / 5.0, abs=1e-3)
    assert "limit 5 m" in first.reason


def test_it_starts_from_two_fixes_where_there_is_no_gps_velocity() -> None:
    verdicts = flown((0.0, 0.0, GRAVITY), speed=6.0, with_velocity=False)
    assert [verdict.state for verdict in verdicts[:2]] == [State.NOT_READY, State.NORMAL]
    assert max(verdict.score for verdict in verdicts) < 0.02


def test_it_is_not_ready_without_attitude_and_starts_afresh_after_one_was_lost() -> None:
    detector = InsPosition(InsPositionParameters())
    states = []
    for ms in range(0, 3000, 100):
        lost = ms < 1000 or ms == 2000
        sample = attitude(ms, (1.0, 0.0, GRAVITY))
        if lost:
            sample = AttitudeSample(ms * MS, None, math.inf, (0, 0, 0), (1.0, 0.0, GRAVITY))
        detector.update("attitude", sample)
        detector.update("velocity", VelocitySample(ms * MS, (0.0, 0.0, 0.0)))
        verdict = detector.update("fix", fix(ms, 0.0))
        assert verdict is not None
        states.append((verdict.state, round(verdict.score, 3)))
    assert states[9][0] is State.NOT_READY
    assert states[10] == (State.NORMAL, 0.0)
    assert states[19] == (State.NORMAL, 0.405)
    assert states[20][0] is State.NOT_READY
    assert states[21] == (State.NORMAL, 0.0)


def test_without_fixes_it_says_so() -> None:
    detector = InsPosition(InsPositionParameters())
    detector.update("fix", fix(0, 0.0))
    said = [detector.update("attitude", attitude(ms, (0, 0, GRAVITY))) for ms in range(0, 5000, 20)]
    verdicts = [verdict for verdict in said if verdict is not None]
    assert verdicts
    assert {verdict.state for verdict in verdicts} == {State.STALE}
    no_fix = FixSample(5000 * MS, 0.0, 0.0, 0.0, has_fix=False)
    verdict = detector.update("fix", no_fix)
    assert verdict is not None
    assert verdict.state is State.STALE
