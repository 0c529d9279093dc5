# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A spoofed GPS steers the vehicle: what is reported follows the plan, the truth does not."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
import pymap3d
import pytest

from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.motion import IMU_HZ
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.spoofing.scenario import load_scenario, parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import FixSample, SatelliteSample, VelocitySample

SCENARIOS = Path(__file__).parents[2] / "config/scenarios"
ONSET_S = 60.0
DRIFT = {"type": "drift", "bearing_deg": 90.0, "speed_m_s": 2.0, "onset_acceleration_m_s2": 0.4}
JUMP = {"type": "jump", "bearing_deg": 90.0, "distance_m": 8.0}
PLAN = FlightPlan("curved", wind_m_s=3.0)


@lru_cache
def clean(route: str = "curved") -> Flight:
    return generate_flight(FlightPlan(route, wind_m_s=3.0), 4)


def attacked(model: dict[str, object], route: str = "curved", **segment: object) -> Flight:
    entry = {"start": ONSET_S, **segment, "model": model}
    spoofer = Spoofer(parse_scenario({"segments": [entry]}), PLAN.start_ns)
    return generate_flight(FlightPlan(route, wind_m_s=3.0), 4, spoofer)


def dragged(flight: Flight, at_s: float, route: str = "curved") -> np.ndarray:
    """Where the vehicle is, from where it would be without the attack: metres in ENU."""
    row = round(at_s * IMU_HZ)
    result: np.ndarray = flight.motion.position[row] - clean(route).motion.position[row]
    return result


def offset(flight: Flight, at_s: float) -> np.ndarray:
    """Reported less measured position at the last fix before a time, metres in ENU."""
    last = sum(fix.stamp_ns <= flight.plan.start_ns + at_s * 1e9 for fix in flight.fixes) - 1
    here, there = flight.measured_fixes[last], flight.fixes[last]
    return np.array(
        pymap3d.geodetic2enu(
            there.latitude_deg, there.longitude_deg, there.altitude_m,
            here.latitude_deg, here.longitude_deg, here.altitude_m,
        )
    )  # fmt: skip


@pytest.mark.parametrize("route", ["straight", "curved", "hover", "survey", "fixed_yaw"])
@pytest.mark.parametrize("acceleration", [0.1, 0.4])
def test_a_carry_off_drags_the_vehicle_by_its_offset_the_other_way(
    route: str, acceleration: float
) -> None:
    flight = attacked(DRIFT | {"onset_acceleration_m_s2": acceleration}, route)
    assert np.linalg.norm(offset(flight, 105.0)) > 60.0
    for at_s in (70.0, 80.0, 105.0):
        apart = dragged(flight, at_s, route) + offset(flight, at_s)
        assert np.linalg.norm(apart) < 2.5
    reported = dragged(flight, 105.0, route) + offset(flight, 105.0)
    assert np.linalg.norm(reported) < 2.5, "the reports still follow the plan"


def test_a_carry_off_of_positions_alone_drags_it_as_well() -> None:
    flight = attacked(DRIFT, velocity_consistent=False)
    assert np.linalg.norm(dragged(flight, 105.0) + offset(flight, 105.0)) < 6.0
    assert np.linalg.norm(dragged(flight, 105.0)) > 70.0


def test_a_small_jump_moves_the_vehicle_at_once() -> None:
    flight = attacked(JUMP)
    assert np.linalg.norm(dragged(flight, 70.0) + offset(flight, 70.0)) < 2.0
    assert np.linalg.norm(offset(flight, 70.0)) == pytest.approx(8.0, abs=0.1)


def test_a_large_jump_is_refused_first_and_followed_when_it_lasts() -> None:
    flight = attacked(JUMP | {"distance_m": 30.0}, "hover")
    assert np.linalg.norm(dragged(flight, 69.0, "hover")) < 3.0
    assert np.linalg.norm(dragged(flight, 90.0, "hover") + offset(flight, 90.0)) < 2.0
    short = attacked(JUMP | {"distance_m": 30.0}, "hover", end=65.0)
    assert np.linalg.norm(dragged(short, 90.0, "hover")) < 0.5


@pytest.mark.parametrize("scenario", ["turn_away", "turn_away_track"])
@pytest.mark.parametrize("route", ["straight", "curved"])
def test_a_false_track_drives_the_vehicle_off(scenario: str, route: str) -> None:
    """The track does not answer the vehicle, which steers against it further and further."""
    spoofer = Spoofer(load_scenario(SCENARIOS / f"{scenario}.yaml"), PLAN.start_ns)
    flight = generate_flight(FlightPlan(route, wind_m_s=3.0), 4, spoofer)
    away = {at_s: np.linalg.norm(dragged(flight, at_s, route)) for at_s in range(59, 90)}
    assert away[59] == 0.0
    assert away[65] > 5.0
    assert max(away.values()) > 100.0
    assert max(np.hypot(*flight.motion.velocity[6000:9000, :2].T)) > 12.0
    assert np.abs(flight.motion.position[8900, 2] - 20.0) < 15.0


def test_a_false_climb_brings_the_vehicle_down() -> None:
    model = {"type": "altitude", "rate_m_s": 1.0, "onset_acceleration_m_s2": 0.5}
    flight = attacked(model, end=75.0)
    assert dragged(flight, 75.0)[2] == pytest.approx(-9.0, abs=3.0)
    assert np.linalg.norm(dragged(flight, 75.0)[:2]) < 0.5
    assert abs(dragged(flight, 109.0)[2]) < 1.0


def test_the_ground_stops_it() -> None:
    flight = attacked({"type": "altitude", "rate_m_s": 2.0})
    assert flight.motion.position[:, 2].min() == 0.0
    assert flight.motion.position[-1, 2] == 0.0


def test_before_the_onset_nothing_differs() -> None:
    flight, onset_ns = attacked(DRIFT), PLAN.start_ns + round(ONSET_S * 1e9)
    rows = round(ONSET_S * IMU_HZ)
    assert flight.imu[:rows] == clean().imu[:rows]
    assert [fix for fix in flight.fixes if fix.stamp_ns < onset_ns] == [
        fix for fix in clean().fixes if fix.stamp_ns < onset_ns
    ]
    assert flight.imu != clean().imu


def test_the_receiver_sees_every_measurement_in_order_and_the_flight_keeps_its_answers() -> None:
    seen: list[FixSample | VelocitySample | SatelliteSample] = []

    class Recorder:
        def fix(self, sample: FixSample) -> FixSample:
            seen.append(sample)
            return sample

        def velocity(self, sample: VelocitySample) -> VelocitySample:
            seen.append(sample)
            return VelocitySample(sample.stamp_ns, (0.0, 0.0, 0.0))

        def satellites(self, sample: SatelliteSample) -> SatelliteSample:
            seen.append(sample)
            return SatelliteSample(sample.stamp_ns, 5)

    flight = generate_flight(PLAN, 4, Recorder())
    assert [one.stamp_ns for one in seen] == sorted(one.stamp_ns for one in seen)
    assert seen[::3] == flight.measured_fixes == flight.fixes
    assert {one.velocity for one in flight.velocities} == {(0.0, 0.0, 0.0)}
    assert {one.count for one in flight.satellites} == {5}


def test_same_attack_same_flight() -> None:
    first, second = attacked(DRIFT), attacked(DRIFT)
    assert first.imu == second.imu
    assert first.fixes == second.fixes
