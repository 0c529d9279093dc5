# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
from __future__ import annotations

import dataclasses

import pytest

from hijack_detect.spoofing.scenario import Scenario, parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import FixSample, PressureSample, SatelliteSample

MODELS = {
    "jump": {"type": "jump", "distance_m": 20.0, "bearing_deg": 30.0, "relative": True},
    "drift": {
        "type": "drift", "speed_m_s": 3.0, "bearing_deg": 30.0, "onset_acceleration_m_s2": 0.7,
    },
    "fake_track": {
        "type": "fake_track",
        "frame": "course",
        "speed_scale": "flight",
        "positions": [[0, 0, 0], [1, 5, 0], [3, 14, 6, 1], [6, 17, 20, 3]],
    },
    "turn_away": {"type": "turn_away", "angle_deg": -70.0, "rate_deg_s": 20.0},
    "replay": {"type": "replay", "from_s": 0.05},
    "freeze": {"type": "freeze", "velocity": "zero"},
    "altitude": {"type": "altitude", "rate_m_s": 1.5, "onset_acceleration_m_s2": 0.5},
    "jitter": {"type": "jitter", "sigma_m": 1.0, "seed": 3, "sigma_m_s": 0.2},
    "forge": {
        "type": "forge", "seed": 3, "altitude_sigma_m": 2.0, "satellites": [4, 20],
        "accuracy_m": [0.5, 9.0], "horizontal_sigma_m": 1.0, "velocity_sigma_m_s": 0.2,
        "drift_speed_m_s": 2.0, "bearing_deg": 30.0, "correlation_s": 1.0,
    },
}  # fmt: skip
SMOOTH = ["drift", "fake_track", "turn_away", "freeze", "altitude"]
PLACES = {
    "Alps": (47.0, 8.0),
    "antimeridian": (-17.0, 179.9999),
    "south of the pole": (89.9, 30.0),
    "north of the pole": (-89.9, -120.0),
    "antimeridian by the pole": (89.9, 179.9999),
}
every_model = pytest.mark.parametrize("kind", MODELS)


@every_model
def test_outside_its_segments_the_same_object_comes_back(tools, kind):
    true = tools.flight("waving")
    spoofed = tools.run(true, tools.one_segment(MODELS[kind]))
    for index in [*range(50), *range(100, 151)]:
        assert spoofed.fixes[index] is true.fixes[index]
        assert spoofed.velocities[index] is true.velocities[index]
    assert all(spoofed.fixes[index] is not true.fixes[index] for index in range(50, 100))


@every_model
@pytest.mark.parametrize("start", [0.0, 0.1, 10.0, 10.13])
def test_fix_and_velocity_of_a_stamp_may_come_in_either_order(tools, kind, start):
    model = MODELS[kind]
    if kind == "replay":
        model, start = {"type": "replay", "from_s": start / 2}, start + 0.05
    true = tools.flight("waving")
    scenario = {"segments": [{"start": start, "model": model}]}
    first = tools.run(true, scenario, "fv")
    assert tools.run(true, scenario, "vf") == first
    assert tools.run(true, scenario, "mixed") == first


@pytest.mark.parametrize("kind", SMOOTH)
@pytest.mark.parametrize("place", PLACES)
def test_velocity_is_the_derivative_of_position(tools, kind, place):
    latitude, longitude = PLACES[place]
    true = tools.flight("waving", latitude, longitude, seconds=20.0, rate_hz=50)
    spoofed = tools.run(true, tools.one_segment(MODELS[kind], end=18.0))
    for index in range(502, 898, 7):
        here = spoofed.fixes[index - 1 : index + 2]
        assert spoofed.velocities[index].velocity == pytest.approx(
            tools.derivative(*here), abs=3e-3
        )


@pytest.mark.parametrize("kind", ["fake_track", "turn_away", "drift", "altitude"])
@pytest.mark.parametrize("place", PLACES)
def test_a_smooth_attack_starts_without_a_step(tools, kind, place):
    latitude, longitude = PLACES[place]
    true = tools.flight("straight", latitude, longitude)
    model = {**MODELS[kind], "positions": [[0, 0, 0], [1, 5, 0], [2, 10, 1]]}
    if kind != "fake_track":
        del model["positions"]
    spoofed = tools.run(true, tools.one_segment(model, start=10.1))
    assert tools.enu(spoofed.fixes[51], true.fixes[51]) == pytest.approx((0, 0, 0), abs=0.2)
    step = [
        b - a
        for a, b in zip(true.velocities[51].velocity, spoofed.velocities[51].velocity, strict=True)
    ]
    assert step == pytest.approx([0, 0, 0], abs=0.3)


@every_model
def test_a_true_velocity_on_request(tools, kind):
    true = tools.flight("waving")
    spoofed = tools.run(true, tools.one_segment(MODELS[kind], velocity_consistent=False))
    assert all(a is b for a, b in zip(true.velocities, spoofed.velocities, strict=True))


@every_model
def test_stamps_stay(tools, kind):
    true = tools.flight()
    spoofed = tools.run(true, tools.one_segment(MODELS[kind]))
    for kind_of in ("fixes", "velocities"):
        ours, theirs = getattr(spoofed, kind_of), getattr(true, kind_of)
        assert [s.stamp_ns for s in ours] == [s.stamp_ns for s in theirs]


@every_model
def test_a_report_of_any_sample_is_that_of_its_kind(tools, kind):
    true = tools.flight("waving")
    spoofer, by_kind = (
        Spoofer(parse_scenario(tools.one_segment(MODELS[kind])), true.first_ns) for _ in range(2)
    )
    for fix, velocity in zip(true.fixes, true.velocities, strict=True):
        count = SatelliteSample(fix.stamp_ns, 12)
        assert spoofer.report(fix) == by_kind.fix(fix)
        assert spoofer.report(velocity) == by_kind.velocity(velocity)
        assert spoofer.report(count) == by_kind.satellites(count)
    pressure = PressureSample(true.first_ns, 101_325.0)
    assert spoofer.report(pressure) is pressure


@every_model
def test_a_fix_without_position_passes(tools, kind):
    true = tools.flight()
    spoofer = Spoofer(parse_scenario(tools.one_segment(MODELS[kind])), true.first_ns)
    for index, fix in enumerate(true.fixes):
        if index in (10, 48, 49, 50, 70):
            lost = FixSample(fix.stamp_ns, 0.0, 0.0, 0.0, has_fix=False)
            assert spoofer.fix(lost) is lost
        else:
            spoofer.fix(fix)
            assert spoofer.offset_m < 200.0


@every_model
def test_a_flight_that_starts_inside_a_segment_is_anchored_at_its_first_fix(tools, kind):
    true = tools.flight()
    late = dataclasses.replace(true, fixes=true.fixes[60:], velocities=true.velocities[60:])
    spoofed = tools.run(late, tools.one_segment(MODELS[kind]))
    assert tools.run(late, tools.one_segment(MODELS[kind]), "vf") == spoofed
    apart = tools.enu(spoofed.fixes[0], late.fixes[0])
    assert sum(part * part for part in apart) ** 0.5 < 30.0


def test_a_vehicle_seen_only_from_inside_a_segment_has_no_speed_to_match(tools):
    true = tools.flight()
    scenario = {"segments": [{"start": 0.0, "model": MODELS["turn_away"]}]}
    assert tools.run(true, scenario).velocities[20].velocity == (0.0, 0.0, 0.0)


def test_truth_covers_start_but_not_end(tools):
    spoofer = Spoofer(parse_scenario(tools.one_segment(MODELS["jump"])), 1000)
    assert [spoofer.active(1000 + t) for t in (0, 9_999_999_999, 10_000_000_000)] == [
        False, False, True,
    ]  # fmt: skip
    assert [spoofer.active(1000 + t) for t in (19_999_999_999, 20_000_000_000)] == [True, False]
    assert not spoofer.active(0)


def test_an_open_segment_lasts(tools):
    scenario = {"segments": [{"start": 1.0, "model": MODELS["freeze"]}]}
    assert Spoofer(parse_scenario(scenario), 0).active(10**18)


def test_offset_is_the_separation_in_three_dimensions(tools):
    true = tools.flight("hover")
    two = [
        {"start": 5, "end": 10, "model": {"type": "jump", "distance_m": 30, "bearing_deg": 77}},
        {"start": 10, "end": 15, "model": {"type": "altitude", "step_m": -7}},
    ]
    spoofer = Spoofer(parse_scenario({"segments": two}), true.first_ns)
    assert spoofer.offset_m == 0.0
    offsets = []
    for fix in true.fixes:
        spoofer.fix(fix)
        offsets.append(spoofer.offset_m)
    assert offsets[24] == offsets[75] == 0.0
    assert offsets[25:50] == pytest.approx([30.0] * 25, abs=1e-3)
    assert offsets[50:75] == pytest.approx([7.0] * 25)


def test_each_segment_starts_from_the_true_flight(tools):
    true = tools.flight()
    freeze = {"type": "freeze"}
    two = [{"start": 5, "end": 10, "model": freeze}, {"start": 10, "end": 15, "model": freeze}]
    spoofed = tools.run(true, {"segments": two})
    assert spoofed.fixes[60].longitude_deg == true.fixes[49].longitude_deg


def test_no_segments_change_nothing(tools):
    true = tools.flight()
    spoofer = Spoofer(Scenario("none", ()), true.first_ns)
    assert all(spoofer.fix(fix) is fix for fix in true.fixes)
    assert not spoofer.active(true.first_ns)


def test_a_velocity_that_stopped_long_ago_is_not_the_course(tools):
    true = tools.flight("waving")
    spoofer = Spoofer(
        parse_scenario(tools.one_segment({**MODELS["jump"], "bearing_deg": 0.0})), true.first_ns
    )
    spoofer.velocity(dataclasses.replace(true.velocities[0], velocity=(-9.0, 0.0, 0.0)))
    for fix in true.fixes[:51]:
        last = spoofer.fix(fix)
    east, north, _ = tools.enu(last, true.fixes[50])
    v_east, v_north, _ = true.velocities[49].velocity
    assert east / north == pytest.approx(v_east / v_north, rel=0.02)
    assert east > 0.0
