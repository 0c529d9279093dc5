# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Standing, taking off, hovering, landing, hands and crashes, from synthetic sensors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hijack_detect.estimation.flight_phase import FlightPhaseEstimator, FlightPhaseParameters
from hijack_detect.monitor.graph import Stage
from hijack_detect.simulation.flight import Flight
from hijack_detect.streams.samples import (
    NANOSECONDS,
    ImuSample,
    Phase,
    PhaseSample,
    PressureSample,
    VelocitySample,
)

RATE_HZ = 50
METRE_PA = 12.0
G = 9.80665


class Vehicle:
    """Makes samples of successive pieces of a flight."""

    def __init__(self, *, barometer: bool = True) -> None:
        self.estimator = FlightPhaseEstimator(FlightPhaseParameters())
        self.rng = np.random.default_rng(5)
        self.height, self.step, self.barometer = 0.0, 0, barometer
        self.said: list[PhaseSample] = []

    def go(
        self,
        seconds: float,
        gyro: float = 0.005,
        force: float = 0.03,
        *,
        climb: float = 0.0,
        speed: float = 0.0,
        up: tuple[float, float, float] = (0.0, 0.0, 1.0),
    ) -> Phase:
        for _ in range(round(seconds * RATE_HZ)):
            self.step += 1
            stamp = self.step * NANOSECONDS // RATE_HZ
            self.height += climb / RATE_HZ
            if self.barometer and self.step % 5 == 0:
                pascal = 95_000.0 - METRE_PA * self.height + self.rng.normal(0.0, 1.0)
                self.estimator.update("pressure", PressureSample(stamp - 1, pascal))
            if self.step % 10 == 0:
                self.estimator.update("velocity", VelocitySample(stamp - 1, (speed, 0.1, climb)))
            turn = self.rng.normal(0.0, gyro / 3**0.5, 3).tolist()
            felt = (np.array(up) * G + self.rng.normal(0.0, force / 3**0.5, 3)).tolist()
            out = self.estimator.update("imu", ImuSample(stamp, tuple(turn), tuple(felt)))
            if out is not None:
                self.said.append(out)
        return self.said[-1].phase


def test_a_flight_from_rest_to_rest() -> None:
    one = Vehicle()
    assert one.go(10.0) is Phase.STANDING
    assert one.go(4.0, 0.15, 0.4, climb=1.0) is Phase.FLYING
    assert one.go(60.0, 0.08, 0.3) is Phase.FLYING
    assert one.go(3.8, 0.1, 0.3, climb=-1.0) in (Phase.FLYING, Phase.LANDING)
    assert one.go(6.0) is Phase.STANDING


def test_a_hover_that_is_as_quiet_as_rest_is_flight() -> None:
    one = Vehicle()
    one.go(10.0, 0.02, 0.2)
    one.go(4.0, 0.15, 0.4, climb=1.0)
    assert one.go(300.0, 0.02, 0.2) is Phase.FLYING
    assert {sample.phase for sample in one.said[-1400:]} == {Phase.FLYING}


def test_motors_that_idle_after_a_touch_down_are_no_flight() -> None:
    one = Vehicle()
    one.go(10.0)
    one.go(4.0, 0.3, 0.45, climb=1.0)
    one.go(30.0, 0.3, 0.45)
    one.go(3.5, 0.3, 0.45, climb=-1.0)
    one.go(0.5, 0.7, 2.5, climb=-0.5)
    assert one.go(6.0, 0.025, 0.45) is Phase.STANDING
    assert one.go(4.0, 0.3, 0.45, climb=1.0) is Phase.FLYING


@pytest.mark.parametrize(
    ("height_m", "bump", "gyro", "speed"),
    [
        (1.0, 0.45, 0.025, 0.0),
        (4.0, 2.5, 0.025, 0.0),
        (1.0, 2.5, 0.08, 0.0),
        (1.0, 2.5, 0.025, 3.0),
    ],
    ids=["no bump", "high", "turning", "moving by GPS"],
)
def test_a_shaken_hover_is_no_touch_down(
    height_m: float, bump: float, gyro: float, speed: float
) -> None:
    one = Vehicle()
    one.go(10.0)
    one.go(4.0, 0.3, 0.45, climb=1.0)
    one.go(30.0, 0.3, 0.45)
    one.go(4.0, 0.3, 0.45, climb=(height_m - one.height) / 4.0)
    one.go(0.5, 0.7, bump)
    one.go(60.0, gyro, 0.45, speed=speed)
    assert {sample.phase for sample in one.said[-250:]} <= {Phase.FLYING, Phase.LANDING}


def test_speed_and_climb_tell_without_a_barometer() -> None:
    fast, rising = Vehicle(barometer=False), Vehicle(barometer=False)
    for one in (fast, rising):
        assert one.go(5.0) is Phase.STANDING
    assert fast.go(3.0, 0.15, 0.4, speed=5.0) is Phase.FLYING
    assert rising.go(3.0, 0.15, 0.4, climb=1.5) is Phase.FLYING


def test_a_receiver_that_settles_beside_a_quiet_imu_is_no_flight() -> None:
    one = Vehicle(barometer=False)
    assert one.go(30.0, speed=3.0, climb=2.0) in (Phase.UNKNOWN, Phase.STANDING)


def test_a_hand_and_a_crash() -> None:
    one = Vehicle()
    one.go(5.0)
    tilted = (0.8, 0.0, 0.6)
    assert one.go(4.0, 0.5, 0.5, up=tilted) is Phase.HANDLED
    one = Vehicle()
    one.go(5.0)
    one.go(4.0, 0.15, 0.4, climb=1.0)
    one.go(5.0, 0.1, 0.3, speed=6.0)
    assert one.go(3.0, 0.02, 0.1, up=(0.0, 0.3, -0.95)) is Phase.CRASHED


def test_a_monitor_that_starts_in_a_hover_judges_after_20_s() -> None:
    one = Vehicle()
    assert one.go(25.0, 0.08, 0.3) is Phase.FLYING


def test_clipping_vibration_and_scale_are_named() -> None:
    one = Vehicle()
    one.go(6.0, up=(0.0, 0.0, 1.0 / G))
    assert "at rest the specific force is 1.0" in one.said[-1].imu_fault
    shaken = Vehicle()
    shaken.go(5.0)
    shaken.go(5.0, 0.2, 20.0, climb=1.0)
    assert "vibrates" in shaken.said[-1].imu_fault
    clean = Vehicle()
    clean.go(5.0)
    clean.go(20.0, 0.15, 1.0, climb=1.0)
    assert {sample.imu_fault for sample in clean.said} == {""}
    assert clean.said[-1].imu_rate_hz == 50.0


@pytest.mark.parametrize("gap_s", [2.0, 10.0, 29.0])
def test_a_gap_in_flight_keeps_the_phase(gap_s: float) -> None:
    one = Vehicle()
    one.go(10.0)
    one.go(4.0, 0.15, 0.4, climb=1.0)
    one.step += round(gap_s * RATE_HZ)
    assert one.go(3.0, 0.08, 0.3) is Phase.FLYING


def test_after_a_long_gap_the_phase_is_unknown_until_it_is_seen() -> None:
    one = Vehicle()
    one.go(10.0)
    one.go(4.0, 0.15, 0.4, climb=1.0)
    one.step += 31 * RATE_HZ
    before = len(one.said)
    one.go(25.0, 0.08, 0.3)
    assert one.said[before].phase is Phase.UNKNOWN
    assert one.said[-1].phase is Phase.FLYING


def test_a_barometer_that_drifts_with_the_weather_does_not_take_off() -> None:
    """5 m in 5 minutes, more than a front brings; the vehicle is shaken by wind now and then."""
    one = Vehicle()
    for k in range(30):
        one.go(10.0, 0.05 if k % 5 == 4 else 0.005, climb=5.0 / 300.0)
    assert {sample.phase for sample in one.said} <= {Phase.UNKNOWN, Phase.STANDING}


@pytest.mark.parametrize("route", ["curved", "straight"])
def test_a_simulated_flight_is_flown_from_its_take_off_to_its_end(
    route: str, flight: Callable[..., Flight], samples: Callable[..., list[tuple[str, Any]]]
) -> None:
    flown = flight(route, 1)
    said = phases(samples(flown, "imu", "fix", "velocity"))
    start = flown.plan.start_ns
    height = flown.motion.position[:, 2] - flown.motion.position[0, 2]
    high = int(flown.motion.offsets_ns[int(np.argmax(height > 5.0))])
    flying = [one for one in said if one.stamp_ns - start > high + 2 * NANOSECONDS]
    assert {one.phase for one in flying} == {Phase.FLYING}
    assert {one.imu_fault for one in said} == {""}


def phases(sent: list[tuple[str, Any]]) -> list[PhaseSample]:
    estimator = FlightPhaseEstimator(FlightPhaseParameters())
    outputs = (estimator.update(name, one) for name, one in sent)
    return [one for one in outputs if one is not None]


@pytest.mark.parametrize("seed", [1, 2])
def test_the_phase_does_not_depend_on_the_order_of_arrival(
    seed: int, flight: Callable[..., Flight], samples: Callable[..., list[tuple[str, Any]]]
) -> None:
    """Within what an input is waited for: half a second of one input, then of the next."""
    sent = [
        one
        for one in samples(flight("curved", seed), "imu", "fix", "velocity")
        if one[1].stamp_ns < flight("curved", seed).plan.start_ns + 20 * NANOSECONDS
    ]

    def staged(order: list[tuple[str, Any]]) -> list[PhaseSample]:
        stage = Stage(lambda: FlightPhaseEstimator(FlightPhaseParameters()))
        return [out for name, one in order for out in stage.push(name, one)]

    late = sorted(sent, key=lambda one: (one[1].stamp_ns // (NANOSECONDS // 2), one[0]))
    assert late != sent
    plain, mixed = staged(sent), staged(late)
    both = min(len(plain), len(mixed))
    assert both > 50
    assert plain[:both] == mixed[:both]


@settings(max_examples=50)
@given(st.lists(st.tuples(*[st.floats(-1000.0, 1000.0)] * 6), min_size=1, max_size=200))
def test_no_readings_break_it(readings: list[tuple[float, ...]]) -> None:
    one = FlightPhaseEstimator(FlightPhaseParameters())
    for at, values in enumerate(readings):
        stamp = (at + 1) * NANOSECONDS // 20
        one.update("imu", ImuSample(stamp, values[:3], values[3:]))  # type: ignore[arg-type]
