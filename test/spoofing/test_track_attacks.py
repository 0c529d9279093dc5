# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
from __future__ import annotations

import math

import numpy as np
import pymap3d
import pytest

LIST = [[0.0, 0.0, 0.0], [2.0, 20.0, 0.0], [4.0, 40.0, 10.0, 4.0], [6.0, 40.0, 30.0, 8.0]]
TRACK = {"type": "fake_track", "positions": LIST}
RIGHT = {"type": "turn_away", "angle_deg": 90.0, "rate_deg_s": 30.0}
SPEED = 5.0
COURSE = math.atan2(4.0, 3.0)


def from_onset(tools, true, fix):
    """Position from where the vehicle was at 10 s; the plane is the one of the fix before."""
    anchor = true.fixes[49]
    position = tools.enu(fix, anchor)
    up = fix.altitude_m - anchor.altitude_m
    return np.array([position[0] - 0.8, position[1] - 0.6, up])  # 0.2 s of 4 and 3 m/s


def test_a_fake_track_passes_through_its_positions(tools, reported):
    true, spoofed = tools.flight(), reported(TRACK)
    for t, *position in LIST:
        expected = [*position, 0.0][:3]
        here = from_onset(tools, true, spoofed.fixes[true.at(10.0 + t)])
        assert here == pytest.approx(expected, abs=1e-3)


def test_a_fake_track_is_what_pymap3d_makes_of_it(tools, reported):
    true, spoofed = tools.flight(), reported(TRACK)
    anchor = true.fixes[49]
    latitude, longitude, _ = pymap3d.enu2geodetic(
        40.0 + 0.8,
        10.0 + 0.6,
        0.0,
        anchor.latitude_deg,
        anchor.longitude_deg,
        anchor.altitude_m,
    )
    fix = spoofed.fixes[true.at(14.0)]
    assert fix.latitude_deg == pytest.approx(latitude, abs=1e-10)
    assert fix.longitude_deg == pytest.approx(longitude, abs=1e-10)
    assert fix.altitude_m == pytest.approx(anchor.altitude_m + 4.0)


def test_a_fake_track_between_positions_is_the_hermite_curve(tools, reported):
    true, spoofed = tools.flight(), reported(TRACK)
    here = from_onset(tools, true, spoofed.fixes[true.at(13.0)])
    # Half way from (20, 0) to (40, 10): mean + step / 8 * (m0 - m1), slopes (10, 2.5), (5, 7.5).
    assert here == pytest.approx([30.0 + 0.25 * 5.0, 5.0 - 0.25 * 5.0, 2.0 - 0.25], abs=1e-3)


def test_uneven_times_take_the_slope_of_the_parabola(tools, reported):
    parabola = [[t, t * t, 0.0] for t in (0.0, 1.0, 1.5, 4.0, 5.0)]
    true, spoofed = tools.flight(), reported({"type": "fake_track", "positions": parabola})
    for t in (1.0, 1.2, 3.0, 4.0):
        index = true.at(10.0 + t)
        assert from_onset(tools, true, spoofed.fixes[index])[0] == pytest.approx(t * t, abs=1e-3)
        assert spoofed.velocities[index].velocity[0] == pytest.approx(2.0 * t, abs=1e-3)


def test_after_its_last_position_a_fake_track_goes_on(tools, reported):
    true, spoofed = tools.flight(), reported(TRACK)
    here = from_onset(tools, true, spoofed.fixes[true.at(18.0)])
    assert here == pytest.approx([40.0, 50.0, 12.0], abs=1e-3)
    assert spoofed.velocities[true.at(18.0)].velocity == pytest.approx((0.0, 10.0, 2.0), abs=1e-3)


def test_a_track_in_the_frame_of_the_course(tools, reported):
    true = tools.flight()
    spoofed = reported({**TRACK, "frame": "course"})
    here = from_onset(tools, true, spoofed.fixes[true.at(14.0)])
    # 40 m forward along (0.8, 0.6), 10 m left along (-0.6, 0.8), 4 m up
    assert here == pytest.approx([32.0 - 6.0, 24.0 + 8.0, 4.0], abs=1e-3)


def test_a_track_scaled_to_the_flight_hands_over_smoothly(tools, reported):
    true = tools.flight()
    spoofed = reported({**TRACK, "frame": "course", "speed_scale": "flight"})
    onset = true.at(10.0)
    assert spoofed.velocities[onset].velocity == pytest.approx((4.0, 3.0, 0.0), abs=1e-4)
    assert tools.enu(spoofed.fixes[onset], true.fixes[onset]) == pytest.approx((0, 0, 0), abs=1e-3)
    here = from_onset(tools, true, spoofed.fixes[true.at(14.0)])
    assert here == pytest.approx([13.0, 16.0, 2.0], abs=1e-3)  # half of the unscaled track


def test_the_hand_over_is_smooth_between_fixes_too(tools):
    true = tools.flight()
    scenario = {"segments": [{"start": 10.13, "model": RIGHT}]}
    spoofed = tools.run(true, scenario)
    index = true.at(10.13)
    assert tools.enu(spoofed.fixes[index], true.fixes[index]) == pytest.approx((0, 0, 0), abs=0.01)


def test_a_standing_vehicle_scales_a_track_to_nothing(tools, reported):
    spoofed = reported({**TRACK, "speed_scale": "flight"}, "hover")
    true = tools.flight("hover")
    assert spoofed.velocities[70].velocity == (0.0, 0.0, 0.0)
    assert tools.enu(spoofed.fixes[70], true.fixes[70]) == pytest.approx((0, 0, 0), abs=1e-6)


def test_a_turn_is_an_arc_and_then_straight(tools, reported):
    true, spoofed = tools.flight(), reported(RIGHT)
    radius = SPEED / math.radians(30.0)
    ahead = np.array([math.sin(COURSE), math.cos(COURSE)])
    right = np.array([math.cos(COURSE), -math.sin(COURSE)])
    for t, forward, aside in [
        (0.0, 0.0, 0.0),
        (1.0, radius * math.sin(math.pi / 6), radius * (1 - math.cos(math.pi / 6))),
        (3.0, radius, radius),
        (8.0, radius, radius + 5.0 * SPEED),
    ]:
        here = from_onset(tools, true, spoofed.fixes[true.at(10.0 + t)])
        assert here[:2] == pytest.approx(forward * ahead + aside * right, abs=1e-3)
    assert spoofed.velocities[true.at(16.0)].velocity[:2] == pytest.approx(SPEED * right, abs=1e-3)


def test_a_negative_angle_turns_left(tools, reported):
    spoofed = reported({**RIGHT, "angle_deg": -90.0})
    assert spoofed.velocities[90].velocity[:2] == pytest.approx((-3.0, 4.0), abs=1e-3)


def test_a_turn_keeps_altitude_and_climb_true(tools, reported):
    true, spoofed = tools.flight("waving"), reported(RIGHT, "waving")
    assert [f.altitude_m for f in spoofed.fixes] == [f.altitude_m for f in true.fixes]
    assert [v.velocity[2] for v in spoofed.velocities] == [v.velocity[2] for v in true.velocities]


def test_a_turn_with_its_own_speed(reported):
    spoofed = reported({**RIGHT, "speed_m_s": 8.0})
    assert math.hypot(*spoofed.velocities[60].velocity) == pytest.approx(8.0)


def test_a_turn_without_course_stands_or_starts_north(reported):
    standing = reported(RIGHT, "hover")
    assert standing.velocities[60].velocity == (0.0, 0.0, 0.0)
    flying = reported({**RIGHT, "speed_m_s": 2.0}, "hover")
    assert flying.velocities[50].velocity == pytest.approx((0.0, 2.0, 0.0), abs=1e-6)
    assert flying.velocities[90].velocity == pytest.approx((2.0, 0.0, 0.0), abs=1e-4)


def test_without_velocities_a_turn_starts_from_the_last_two_fixes(tools, reported):
    alone, both = reported(RIGHT, order="f"), reported(RIGHT)
    for ours, theirs in zip(alone.fixes, both.fixes, strict=True):
        assert tools.enu(ours, theirs) == pytest.approx((0, 0, 0), abs=2e-3)
