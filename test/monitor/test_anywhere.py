# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The same flight anywhere on Earth: quiet while it is clean, alerted when it is carried off."""

from __future__ import annotations

import dataclasses

import pytest

from hijack_detect.evaluation.trials.cases import flight_samples
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.offline import outputs_of
from hijack_detect.simulation.flight import generate_flight
from hijack_detect.simulation.gps import velocity_there
from hijack_detect.simulation.plan import FlightPlan, Place
from hijack_detect.spoofing.scenario import parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import NANOSECONDS

ONSET_S, WITHIN_S = 60.0, 5.0
DRIFT = {
    "type": "drift",
    "speed_m_s": 12.0,
    "bearing_deg": 80.0,
    "onset_acceleration_m_s2": 1.5,
}


@pytest.mark.parametrize(
    "place",
    [
        pytest.param((-17.0, 179.999, 50.0), id="antimeridian"),
        pytest.param((0.0003, -0.0003, 20.0), id="equator and Greenwich"),
        pytest.param((-33.0, -70.0, -400.0), id="South West, 400 m below the ellipsoid"),
        pytest.param((28.0, 86.9, 9000.0), id="9000 m"),
        pytest.param((89.99, 10.0, 0.0), id="1.1 km from the North Pole"),
        pytest.param((-89.9, -120.0, 2835.0), id="11 km from the South Pole"),
    ],
)
def test_a_place(place: tuple[float, float, float]) -> None:
    start = Place.at(*place)
    flight = generate_flight(FlightPlan("curved", duration_s=75.0, place=start), 1)
    spoofer = Spoofer(
        parse_scenario({"segments": [{"start": ONSET_S, "model": DRIFT}]}), flight.imu[0].stamp_ns
    )
    pairs = list(zip(flight.fixes, flight.velocities, strict=True))
    attacked = dataclasses.replace(
        flight,
        fixes=[spoofer.fix(fix) for fix, _ in pairs],
        velocities=[spoofer.velocity(velocity_there(start, *pair)) for pair in pairs],
    )
    monitor = Monitor(policy_parameters("default"))
    results = [
        output for part, output in outputs_of(flight_samples(attacked), monitor) if part == "fusion"
    ]
    first_ns = next(one.stamp_ns for one in results if one.alert)
    alert_s = (first_ns - flight.imu[0].stamp_ns) / NANOSECONDS
    assert ONSET_S < alert_s < ONSET_S + WITHIN_S
