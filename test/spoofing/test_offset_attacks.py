# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
from __future__ import annotations

import dataclasses
import math

import numpy as np
import pymap3d
import pytest

DRIFT = {"type": "drift", "speed_m_s": 2.0, "bearing_deg": 90.0, "onset_acceleration_m_s2": 0.5}
NORTH_JUMP = {"type": "jump", "distance_m": 20.0, "bearing_deg": 0.0}


def offsets(tools, true, spoofed):
    """East, North of the reported about the true fixes, and the difference in altitude."""
    return np.array(
        [
            (*tools.enu(b, a)[:2], b.altitude_m - a.altitude_m)
            for a, b in zip(true.fixes, spoofed.fixes, strict=True)
        ]
    )


@pytest.mark.parametrize(
    ("bearing", "east", "north"),
    [(0.0, 0.0, 20.0), (90.0, 20.0, 0.0), (180.0, 0.0, -20.0), (-30.0, -10.0, 17.320508)],
)
def test_a_jump_displaces_along_its_bearing(tools, reported, bearing, east, north):
    true = tools.flight()
    spoofed = reported({**NORTH_JUMP, "bearing_deg": bearing})
    moved = offsets(tools, true, spoofed)[50:100]
    assert moved == pytest.approx(np.tile([east, north, 0.0], (50, 1)), abs=1e-3)


def test_a_jump_is_what_pymap3d_makes_of_it(tools, reported):
    true, spoofed = tools.flight(), reported(NORTH_JUMP)
    anchor = true.fixes[49]
    position = tools.enu(true.fixes[60], anchor)
    latitude, longitude, _ = pymap3d.enu2geodetic(
        position[0],
        position[1] + 20.0,
        position[2],
        anchor.latitude_deg,
        anchor.longitude_deg,
        anchor.altitude_m,
    )
    assert spoofed.fixes[60].latitude_deg == latitude
    assert spoofed.fixes[60].longitude_deg == longitude


def test_a_jump_leaves_velocity_and_altitude_alone(tools, reported):
    true, spoofed = tools.flight("waving"), reported(NORTH_JUMP, "waving")
    assert spoofed.velocities == true.velocities
    assert [f.altitude_m for f in spoofed.fixes] == [f.altitude_m for f in true.fixes]


def test_a_relative_bearing_counts_from_the_course_at_onset(tools, reported):
    spoofed = reported({**NORTH_JUMP, "bearing_deg": 90.0, "relative": True})
    moved = offsets(tools, tools.flight(), spoofed)[60]
    assert moved == pytest.approx([12.0, -16.0, 0.0], abs=1e-3)  # right of 4 East, 3 North


def test_without_velocities_the_course_comes_from_the_last_two_fixes(tools, reported):
    spoofed = reported({**NORTH_JUMP, "bearing_deg": 90.0, "relative": True}, order="f")
    moved = offsets(tools, tools.flight(), spoofed)[60]
    assert moved == pytest.approx([12.0, -16.0, 0.0], abs=1e-3)


def test_a_hover_has_no_course_and_relative_means_north(tools, reported):
    spoofed = reported({**NORTH_JUMP, "relative": True}, "hover")
    assert offsets(tools, tools.flight("hover"), spoofed)[60] == pytest.approx(
        [0.0, 20.0, 0.0], abs=1e-6
    )


@pytest.mark.parametrize(
    ("t", "metres", "speed"),
    [(0.0, 0.0, 0.0), (2.0, 1.0, 1.0), (4.0, 4.0, 2.0), (9.0, 14.0, 2.0)],
)
def test_a_drift_gathers_speed_and_keeps_it(tools, reported, t, metres, speed):
    true, spoofed = tools.flight(), reported(DRIFT)
    index = true.at(10.0 + t)
    assert offsets(tools, true, spoofed)[index] == pytest.approx([metres, 0.0, 0.0], abs=2e-4)
    added = np.subtract(spoofed.velocities[index].velocity, true.velocities[index].velocity)
    assert added == pytest.approx([speed, 0.0, 0.0], abs=1e-4)


def test_a_drift_may_leave_the_velocity_true(tools, reported):
    spoofed = reported(DRIFT, velocity_consistent=False)
    for ours, true in zip(spoofed.velocities, tools.flight().velocities, strict=True):
        assert ours == true
    assert offsets(tools, tools.flight(), spoofed)[70][0] == pytest.approx(4.0, abs=1e-3)


def test_altitude_steps_and_ramps(tools, reported):
    model = {"type": "altitude", "rate_m_s": -2.0, "step_m": 5.0, "onset_acceleration_m_s2": 1.0}
    true, spoofed = tools.flight("waving"), reported(model, "waving")
    moved = offsets(tools, true, spoofed)
    assert moved[true.at(11.0)] == pytest.approx([0.0, 0.0, 5.0 - 0.5], abs=1e-6)
    assert moved[true.at(15.0)] == pytest.approx([0.0, 0.0, 5.0 - 2.0 * 4.0], abs=1e-6)
    climbs = [
        b.velocity[2] - a.velocity[2]
        for a, b in zip(true.velocities, spoofed.velocities, strict=True)
    ]
    assert climbs[true.at(11.0)] == pytest.approx(-1.0)
    assert climbs[true.at(15.0)] == pytest.approx(-2.0)
    assert all(
        a.velocity[:2] == b.velocity[:2]
        for a, b in zip(true.velocities, spoofed.velocities, strict=True)
    )


def test_an_altitude_ramp_without_acceleration_starts_at_once(tools, reported):
    true, spoofed = tools.flight(), reported({"type": "altitude", "rate_m_s": 3.0})
    index = true.at(10.2)
    assert spoofed.fixes[index].altitude_m - true.fixes[index].altitude_m == pytest.approx(0.6)
    assert spoofed.velocities[index].velocity[2] == pytest.approx(3.0)


def test_jitter_has_the_spread_it_is_given(tools):
    model = {
        "type": "jitter", "sigma_m": 2.0, "vertical_sigma_m": 3.0, "sigma_m_s": 0.5, "seed": 7,
    }  # fmt: skip
    true = tools.flight(seconds=200.0)
    spoofed = tools.run(true, {"segments": [{"start": 0.0, "model": model}]})
    moved = offsets(tools, true, spoofed)
    assert moved.std(axis=0) == pytest.approx([2.0, 2.0, 3.0], rel=0.1)
    assert np.abs(moved.mean(axis=0)) == pytest.approx([0.0, 0.0, 0.0], abs=0.3)
    noise = np.array([v.velocity for v in spoofed.velocities]) - [
        v.velocity for v in true.velocities
    ]
    assert noise.std(axis=0) == pytest.approx([0.5, 0.5, 0.0], rel=0.1, abs=1e-9)
    assert abs(np.corrcoef(moved[:, 0], noise[:, 0])[0, 1]) < 0.1


def test_jitter_of_a_stamp_does_not_depend_on_other_messages(tools, reported):
    model = {"type": "jitter", "sigma_m": 2.0, "seed": 7}
    true = tools.flight("hover")
    every_other = dataclasses.replace(true, fixes=true.fixes[::2], velocities=true.velocities[::2])
    thinned = tools.run(every_other, tools.one_segment(model))
    assert thinned.fixes == reported(model, "hover").fixes[::2]
    other_seed = reported({**model, "seed": 8}, "hover")
    assert other_seed.fixes[60] != thinned.fixes[30]


def test_jitter_without_velocity_noise_leaves_velocities_alone(tools, reported):
    spoofed = reported({"type": "jitter", "sigma_m": 2.0, "seed": 0})
    assert spoofed.velocities == tools.flight().velocities
    assert math.dist(tools.enu(spoofed.fixes[60], tools.flight().fixes[60]), (0, 0, 0)) > 0.1
