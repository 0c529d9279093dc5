# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A link that drops out is no attack, and an attack after it is found."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from holes import Flight, Hole, run_holes, with_hole
from ros import ROOT

from hijack_detect.bags.reader import BagReader
from hijack_detect.detectors.verdict import JUDGED
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.parts import WEIGHTS
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.offline import FlightNotes, outputs_of, spoofed_samples
from hijack_detect.spoofing.scenario import Scenario, load_scenario
from hijack_detect.streams.samples import NANOSECONDS

TURNING = "curved_8"
HOLES = {
    True: (Hole(30.0, 4.0), Hole(47.0, 4.0), Hole(85.0, 4.0, "imu"), Hole(57.5, 4.0, "gps")),
    False: (Hole(30.0, 2.0), Hole(57.5, 10.0, "imu"), Hole(71.2, 10.0), Hole(85.0, 4.0, "imu")),
}
"""With GPS velocities and without: in turns that no gyroscope saw, where the heading is lost."""
ATTACK = """
segments:
  - {start: 65.0, model: {type: drift, speed_m_s: 4.0, bearing_deg: 45.0,
     onset_acceleration_m_s2: 1.0}}
"""


@cache
def flown(bag: str, *, velocity: bool, scenario: Scenario | None = None) -> Flight:
    with BagReader(ROOT / "bags" / bag) as reader:
        samples = spoofed_samples(reader, scenario, FlightNotes(reader.start_ns))
        return [one for one in samples if velocity or one[0] != "velocity"]


@pytest.mark.parametrize("velocity", HOLES)
def test_a_hole_is_no_attack_and_detectors_can_tell_again(velocity: bool) -> None:
    flight = flown(TURNING, velocity=velocity)
    start_ns = flight[0][1].stamp_ns
    seeing = {name for name, one in WEIGHTS.items() if one.sees_carry_off}
    for hole, said in run_holes(flight, HOLES[velocity], policy_parameters("default")):
        alerts = [one.cause for part, one in said if part == "fusion" and one.alert]
        assert not alerts, f"{hole}: {alerts[0]}"
        end_ns = start_ns + round((hole.start_s + hole.length_s) * NANOSECONDS)
        telling = [
            one.stamp_ns - end_ns
            for part, one in said
            if part in seeing and one.stamp_ns > end_ns and one.state in JUDGED
        ]
        assert telling, f"{hole}: nobody can tell again"
        assert min(telling) < 15 * NANOSECONDS, str(hole)


@pytest.mark.parametrize("velocity", [True, False])
def test_an_attack_5_s_after_a_hole_is_found(velocity: bool, tmp_path: Path) -> None:
    path = tmp_path / "attack.yaml"
    path.write_text(ATTACK)
    flight = flown("straight_3", velocity=velocity, scenario=load_scenario(path))
    monitor = Monitor(policy_parameters("default"))
    said = outputs_of(with_hole(flight, Hole(56.0, 4.0)), monitor)
    alert = next(one for part, one in said if part == "fusion" and one.alert)
    seconds = (alert.alert_since_ns - flight[0][1].stamp_ns) / NANOSECONDS
    assert 65.0 < seconds < (75.0 if velocity else 78.0)
