# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Disturbances are as large as they say, and leave the rest of the flight as it was."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from hijack_detect.simulation.disturbances import (
    Anomaly,
    Disturbances,
    Gust,
    Jump,
    Outage,
    Pulse,
    Spin,
    Vibration,
)
from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.navigation import Navigation
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.simulation.sensors import shaking

BEGIN = 42.0
PLAN = FlightPlan("straight", duration_s=70.0)


def disturbed(seed: int = 1, route: str = "straight", **what: object) -> Flight:
    plan = dataclasses.replace(PLAN, route=route, disturbances=Disturbances(**what))  # type: ignore[arg-type]
    return generate_flight(plan, seed)


def early(flight: Flight, name: str) -> list[object]:
    """Samples before the disturbance."""
    until = flight.plan.start_ns + round((BEGIN - 0.2) * 1e9)
    return [sample for sample in getattr(flight, name) if sample.stamp_ns < until]


def test_a_pulse_is_the_discrete_gust_of_the_airworthiness_rules() -> None:
    time = np.linspace(9.0, 15.0, 601)
    height = Pulse(10.0, 2.0).height(time)
    inside = (time >= 10.0) & (time <= 14.0)
    assert height[inside] == pytest.approx(0.5 - 0.5 * np.cos(np.pi * (time[inside] - 10.0) / 2.0))
    assert np.all(height[~inside] == 0.0)


def test_a_pulse_without_rise_is_a_step() -> None:
    time = np.array([9.99, 10.0, 12.0, 12.01])
    assert Pulse(10.0, 0.0, 2.0).height(time).tolist() == [0.0, 1.0, 1.0, 0.0]
    assert Pulse(10.0, 0.0, math.inf).height(time).tolist() == [0.0, 1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    "what",
    [
        {"gusts": (Gust(Pulse(BEGIN, 1.0, 5.0), (8.0, 0.0, 0.0)),)},
        {"anomalies": (Anomaly(Pulse(BEGIN, 1.0, 5.0), (2e-5, 0.0, 0.0)),)},
        {"outages": (Outage(BEGIN, 10.0),)},
        {"jumps": (Jump(BEGIN, (2.0, 0.0, 0.0)),)},
    ],
)
def test_up_to_its_begin_the_flight_is_the_undisturbed_one(what: dict[str, object]) -> None:
    plain, hard = generate_flight(PLAN, 1), disturbed(**what)
    for name in ("imu", "fixes", "velocities", "satellites", "magnetics", "pressures"):
        assert early(hard, name) == early(plain, name)


def test_a_gust_is_added_to_the_wind_and_the_vehicle_holds_its_route() -> None:
    plain = generate_flight(PLAN, 1)
    hard = disturbed(gusts=(Gust(Pulse(BEGIN, 2.0), (8.0, 0.0, 0.0)),))
    added = hard.motion.wind - plain.motion.wind
    assert added.max(axis=0) == pytest.approx([8.0, 0.0, 0.0], abs=1e-3)
    assert np.abs(hard.motion.position - plain.motion.position).max() < 6.0


def test_turbulence_replaces_what_was_drawn_and_nothing_else() -> None:
    plain, hard = generate_flight(PLAN, 1).conditions, disturbed(turbulence_m_s=1.6).conditions
    assert dataclasses.replace(hard, gust_m_s=plain.gust_m_s) == plain
    assert hard.gust_m_s == 1.6


@pytest.mark.parametrize(("route", "rate"), [("hover", 180.0), ("straight", 90.0)])
def test_a_spin_turns_the_nose_and_not_the_course(route: str, rate: float) -> None:
    plain = generate_flight(dataclasses.replace(PLAN, route=route), 1)
    hard = disturbed(route=route, spins=(Spin(BEGIN, 2.0, rate),))
    turned = hard.motion.angular_velocity[:, 2] - plain.motion.angular_velocity[:, 2]
    assert np.sum(turned) / 100.0 == pytest.approx(4.0 * math.pi, abs=0.2)
    assert np.degrees(turned.max()) == pytest.approx(rate, rel=0.15)
    assert np.abs(hard.motion.position - plain.motion.position).max() < 2.0


def test_braking_is_as_hard_as_a_multirotor_can() -> None:
    motion = generate_flight(FlightPlan("brake", speed=10.0), 1).motion
    speed = np.hypot(motion.velocity[:, 0], motion.velocity[:, 1])
    slower = -np.gradient(speed, 0.01)
    assert 4.0 < slower.max() < 7.5
    stops = np.flatnonzero(np.diff((speed > 1.0).astype(int)) == -1)
    assert len(stops) >= 3


def test_an_anomaly_adds_its_field_whatever_the_attitude() -> None:
    plain = generate_flight(PLAN, 1)
    hard = disturbed(anomalies=(Anomaly(Pulse(BEGIN, 0.0, 10.0), (12e-6, 16e-6, 0.0)),))
    added = np.array([b.field for b in hard.magnetics]) - [a.field for a in plain.magnetics]
    length = np.linalg.norm(added, axis=1)
    assert length[430:510] == pytest.approx(20e-6, rel=0.02)
    assert np.all(length[:419] == 0.0)
    assert hard.imu == plain.imu


def test_in_an_outage_nothing_is_reported_and_the_vehicle_drifts_by_its_inertial_error() -> None:
    plain, hard = generate_flight(PLAN, 1), disturbed(outages=(Outage(BEGIN, 10.0),))
    stamps = [(fix.stamp_ns - PLAN.start_ns) / 1e9 for fix in hard.fixes]
    assert not any(BEGIN <= stamp < BEGIN + 10.0 for stamp in stamps)
    assert len(plain.fixes) - len(hard.fixes) == 50
    assert len(hard.velocities) == len(hard.satellites) == len(hard.fixes)
    error = np.hypot(*hard.conditions.accelerometer_error[:2])
    drift = np.linalg.norm((hard.motion.position - plain.motion.position)[round(52e2), :2])
    assert drift == pytest.approx(0.5 * error * 10.0**2, abs=4.0)
    assert np.abs(hard.motion.position[3000:, 2] - 20.0).max() < 3.0


def test_a_receiver_that_comes_back_far_away_is_believed_at_once() -> None:
    navigation = Navigation(0.02)
    for step in range(600):
        navigation.predict((0.0, 0.0, 0.0))
        if step % 10 == 0:
            navigation.miss(0.0, step * 0.02)
    navigation.correct((50.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 12.0)
    assert navigation.position[0] == pytest.approx(50.0)


def test_a_jump_stays_and_the_vehicle_follows() -> None:
    plain, hard = generate_flight(PLAN, 1), disturbed(jumps=(Jump(BEGIN, (0.0, 2.0, 0.0)),))
    north = [
        111_000.0 * (b.latitude_deg - a.latitude_deg)
        for a, b in zip(plain.fixes, hard.fixes, strict=True)
        if 0.0 <= (a.stamp_ns - PLAN.start_ns) / 1e9 - BEGIN < 0.25
    ]
    assert north[0] == pytest.approx(2.0, abs=0.02)
    assert hard.fixes == hard.measured_fixes
    moved = hard.motion.position[5500] - plain.motion.position[5500]
    assert moved == pytest.approx([0.0, -2.0, 0.0], abs=0.3)


def test_vibration_has_its_rms_and_is_folded_by_the_sampling() -> None:
    strong = Vibration(4.0, 110.0, wander_hz=1.0)
    rate, force = shaking(strong, 6000, 100.0, np.random.default_rng(1))
    assert force.std(axis=0) == pytest.approx(4.0, rel=0.1)
    assert rate.std(axis=0) == pytest.approx(0.2, rel=0.1)
    spectrum = np.abs(np.fft.rfft(force[:, 2]))
    assert np.fft.rfftfreq(6000, 0.01)[spectrum.argmax()] == pytest.approx(10.0, abs=3.0)


def test_vibration_is_felt_in_flight_only_and_by_the_imu_alone() -> None:
    plain, hard = generate_flight(PLAN, 1), disturbed(vibration=Vibration(4.0, 120.0, white=1.0))
    felt = np.array([b.specific_force for b in hard.imu]) - [a.specific_force for a in plain.imu]
    assert np.all(felt[plain.motion.airborne == 0.0] == 0.0)
    assert felt[3000:].std(axis=0) == pytest.approx(4.0, rel=0.15)
    assert hard.fixes == plain.fixes
    assert hard.magnetics == plain.magnetics


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda: Pulse(-1.0, 1.0), "start is -1.0"),
        (lambda: Pulse(1.0, math.inf), "rise is inf"),
        (lambda: Pulse(1.0, 1.0, math.nan), "hold is nan"),
        (lambda: Spin(1.0, 1.0, 200.0), "rate is 200.0"),
        (lambda: Spin(1.0, math.inf, 90.0), "turns are inf"),
        (lambda: Outage(1.0, -1.0), "duration is -1.0"),
        (lambda: Jump(math.nan, (0.0, 0.0, 0.0)), "start is nan"),
        (lambda: Vibration(-1.0, 90.0), "force is -1.0"),
        (lambda: Disturbances(turbulence_m_s=-1.0), "turbulence is -1.0"),
    ],
)
def test_values_that_make_no_sense_are_refused(make: object, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        make()  # type: ignore[operator]
