# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""When a detector that means flight may judge."""

import math

import pytest

from hijack_detect.detectors.flight_gate import MIN_IMU_HZ, SILENT_NS, FlightGate
from hijack_detect.detectors.verdict import State
from hijack_detect.streams.samples import NANOSECONDS, Phase, PhaseSample

IN_THE_AIR = [one for one in Phase if one.airborne]
ON_GROUND = [one for one in Phase if not one.airborne and one is not Phase.UNKNOWN]


def phase(at_s: float, what: Phase, rate_hz: float = 100.0, fault: str = "") -> PhaseSample:
    stamp_ns = round(at_s * NANOSECONDS)
    return PhaseSample(stamp_ns, what, stamp_ns, "seen by the test", rate_hz, fault)


def gate(*samples: PhaseSample, min_imu_hz: float = MIN_IMU_HZ) -> FlightGate:
    one = FlightGate(min_imu_hz)
    for sample in samples:
        one.update(sample)
    return one


def test_flight_is_hover_cruise_and_landing() -> None:
    assert set(IN_THE_AIR) == {Phase.FLYING, Phase.LANDING}


@pytest.mark.parametrize("what", IN_THE_AIR)
def test_it_is_open_in_flight(what: Phase) -> None:
    assert gate(phase(1, what)).blocked(NANOSECONDS) is None


@pytest.mark.parametrize("what", ON_GROUND)
@pytest.mark.parametrize("min_imu_hz", [0.0, MIN_IMU_HZ])
def test_nothing_can_be_told_on_the_ground(what: Phase, min_imu_hz: float) -> None:
    blocked = gate(phase(1, what), min_imu_hz=min_imu_hz).blocked(NANOSECONDS)
    assert blocked == (
        State.NOT_OBSERVABLE,
        f"not in flight: {what.value}, seen by the test",
    )


def test_it_is_not_ready_while_the_phase_is_unknown() -> None:
    blocked = gate(phase(1, Phase.UNKNOWN)).blocked(NANOSECONDS)
    assert blocked == (State.NOT_READY, "not known to be in flight: seen by the test")


def test_a_fault_of_the_imu_is_the_reason() -> None:
    blocked = gate(phase(1, Phase.FLYING, fault="the accelerometer clips")).blocked(NANOSECONDS)
    assert blocked == (State.NOT_OBSERVABLE, "the accelerometer clips")


def test_an_imu_that_is_too_slow_is_the_reason() -> None:
    assert gate(phase(1, Phase.FLYING, MIN_IMU_HZ)).blocked(NANOSECONDS) is None
    blocked = gate(phase(1, Phase.FLYING, 10.0)).blocked(NANOSECONDS)
    assert blocked == (
        State.NOT_OBSERVABLE,
        f"the IMU arrives at 10 Hz, {MIN_IMU_HZ:.0f} Hz are needed",
    )


def test_a_detector_without_an_imu_does_not_ask_for_one() -> None:
    poor = phase(1, Phase.FLYING, 2.0, "the accelerometer clips")
    assert gate(poor, min_imu_hz=0.0).blocked(NANOSECONDS) is None


def test_without_a_phase_a_detector_goes_on_as_in_flight() -> None:
    assert gate().blocked(NANOSECONDS) is None
    one = gate(phase(1, Phase.STANDING))
    assert one.blocked(NANOSECONDS + SILENT_NS) is not None
    assert one.blocked(NANOSECONDS + SILENT_NS + 1) is None
    assert math.isinf(one.airborne_s(NANOSECONDS + SILENT_NS + 1))


def test_time_in_the_air_counts_from_the_take_off_and_over_a_landing_broken_off() -> None:
    one = gate(phase(1, Phase.STANDING))
    assert one.airborne_s(NANOSECONDS) == 0.0
    for at, what in ((2, Phase.FLYING), (3, Phase.LANDING), (4, Phase.FLYING)):
        one.update(phase(at, what))
    assert one.airborne_s(5 * NANOSECONDS) == 3.0
    one.update(phase(6, Phase.STANDING))
    one.update(phase(7, Phase.FLYING))
    assert one.airborne_s(8 * NANOSECONDS) == 1.0
