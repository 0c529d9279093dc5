# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The gates of PX4 and ArduPilot: their arithmetic by hand, and their behaviour at rest."""

import math
from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np
import pytest

from experiments.autopilot_gates import ardupilot, px4
from experiments.autopilot_gates.epochs import Epochs, cut, standard_height_m
from experiments.autopilot_gates.flights import GATES
from experiments.autopilot_gates.gate_filter import GateFilter, Judged
from experiments.autopilot_gates.outcome import alarms, clean
from hijack_detect.streams.samples import (
    FixSample,
    ImuSample,
    PressureSample,
    Sample,
    Vector3,
    VelocitySample,
)

SECOND = 1_000_000_000
START_NS = 1_750_000_000 * SECOND
ONSET_S = 30


def standing(seconds: float, gap_s: tuple[float, float] = (0.0, 0.0)) -> Iterator[Sample]:
    """A vehicle that stands still: IMU at 50 Hz but for a gap, GPS at 5 Hz."""
    for step in range(round(seconds * 50)):
        stamp = START_NS + step * SECOND // 50
        if not gap_s[0] < step / 50 < gap_s[1]:
            yield ImuSample(stamp, (0.0, 0.0, 0.0), (0.0, 0.0, 9.80665))
        if step % 10 == 0:
            yield FixSample(stamp, 48.0, 11.0, 500.0)
            yield VelocitySample(stamp, (0.0, 0.0, 0.0))


@lru_cache
def epochs() -> Epochs:
    return cut(standing(60.0), [(0, math.pi / 2)])


def fly(gate: GateFilter, reported: Callable[[float], tuple[Vector3, Vector3]]) -> list[Judged]:
    """Report the truth, and from ONSET_S on a position and velocity by the time since then."""
    judged = []
    for epoch in epochs().items:
        t = (epoch.stamp_ns - START_NS) / SECOND - ONSET_S
        still: Vector3 = (0.0, 0.0, 0.0)
        judged.append(gate.step(epoch, *(reported(t) if t >= 0 else (still, still))))
    return judged


def since_onset_s(judged: Judged) -> float:
    return (judged.stamp_ns - START_NS) / SECOND - ONSET_S


def test_px4_takes_the_worst_axis_and_ardupilot_pools_them() -> None:
    innovation, variance = np.array([3.0, 1.0]), np.array([1.0, 4.0])
    assert px4.worst_ratio(innovation, variance, 5.0) == pytest.approx(9.0 / 25.0)
    assert ardupilot.pooled_ratio(innovation, variance, 5.0) == pytest.approx(10.0 / 125.0)


def test_five_standard_deviations_are_the_edge() -> None:
    edge, variance = np.array([10.0]), np.array([4.0])
    assert px4.worst_ratio(edge, variance, px4.GPS_P_GATE) == pytest.approx(1.0)
    assert ardupilot.pooled_ratio(edge, variance, ardupilot.POS_I_GATE) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("position_s", "velocity_s", "expected"),
    [(9.9, 0.2, False), (10.1, 0.2, True), (6.9, 8.0, False), (7.1, 8.0, True), (0.0, 60.0, False)],
)
def test_ardupilot_waits_ten_seconds_with_velocity_and_seven_without(
    position_s: float, velocity_s: float, expected: bool
) -> None:
    assert ardupilot.timed_out(position_s, velocity_s) is expected


def test_noise_of_a_step_becomes_a_density() -> None:
    noise = px4.Px4Filter.imu.densities()
    assert (noise.accel, noise.gyro) == pytest.approx((0.035, 0.0015))


@pytest.mark.parametrize(("name", "timeout_s"), [("PX4", 7.0), ("ArduPilot", 10.0)])
def test_a_jump_is_rejected_at_once_and_believed_after_the_time_out(
    name: str, timeout_s: float
) -> None:
    gate = GATES[name]()
    judged = fly(gate, lambda t: ((40.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    first = next(one for one in judged if one.rejected)
    assert since_onset_s(first) == 0.0
    assert first.rejected == ["position"]
    reset = next(one for one in judged if one.resets)
    assert since_onset_s(reset) == pytest.approx(timeout_s, abs=0.21)
    assert not judged[-1].rejected
    assert gate.ekf.position[0] == pytest.approx(40.0, abs=0.5)


@pytest.mark.parametrize("name", list(GATES))
def test_a_slow_carry_off_drags_the_filter_along_unnoticed(name: str) -> None:
    gate = GATES[name]()
    judged = fly(gate, lambda t: ((0.1 * t * t, 0.0, 0.0), (0.2 * t, 0.0, 0.0)))
    assert not any(one.rejected or one.resets for one in judged)
    assert gate.ekf.position[0] == pytest.approx(0.1 * 29.8**2, abs=3.0)


@pytest.mark.parametrize("name", list(GATES))
def test_the_filter_at_rest_stays_far_below_its_gate(name: str) -> None:
    judged = fly(GATES[name](), lambda t: ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    found = clean("rest", name, judged)
    assert (found.rejections, found.resets) == (0, 0)
    assert found.worst < 0.01
    assert found.hours == pytest.approx(39.0 / 3600.0, abs=1e-3)


def judged_at(*rejected: bool, reset_at: int = -1) -> list[Judged]:
    return [
        Judged(k * SECOND // 5, {"position": 2.0 * bad}, ("position",) * (k == reset_at), True)
        for k, bad in enumerate(rejected)
    ]


def test_a_lasting_alarm_needs_a_second_in_a_row() -> None:
    judged = judged_at(False, True, False, *[True] * 7)
    offsets = [float(k) for k in range(len(judged))]
    first, lasting = alarms(judged, offsets, 0)
    assert first is not None
    assert lasting is not None
    assert (first.after_s, first.off_m, first.by) == (0.2, 1.0, ["position"])
    assert (lasting.after_s, lasting.off_m) == (1.6, 8.0)
    assert alarms(judged[:8], offsets[:8], 0)[1] is None


def test_what_is_rejected_after_a_reset_is_no_alarm() -> None:
    judged = judged_at(False, False, True, True, reset_at=1)
    assert alarms(judged, [0.0] * 4, 0) == (None, None)


def test_a_flight_is_cut_at_the_fixes_and_restarted_after_a_gap() -> None:
    items = cut(standing(10.0, gap_s=(4.0, 6.0)), [(0, 0.0)]).items
    assert next(k for k, one in enumerate(items) if one.restart) == 0
    assert sum(one.restart for one in items) == 2
    lengths = [float(np.sum(one.block.dt)) for one in items if not one.restart]
    assert max(lengths) == pytest.approx(0.2)


def test_the_barometer_counts_from_the_first_fix() -> None:
    def samples() -> Iterator[Sample]:
        for sample in standing(5.0):
            if isinstance(sample, FixSample):
                climbed = sample.stamp_ns > START_NS + 3 * SECOND
                yield PressureSample(sample.stamp_ns, 89_874.6 if climbed else 101_325.0)
            yield sample

    items = cut(samples(), [(0, 0.0)]).items
    assert items[0].barometer_m == pytest.approx(0.0, abs=1e-6)
    assert items[-1].barometer_m == pytest.approx(1000.0, abs=1.0)
    assert standard_height_m(101_325.0) == 0.0
