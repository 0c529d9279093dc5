# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
from __future__ import annotations

import dataclasses

import pytest

from hijack_detect.spoofing.onset import History
from hijack_detect.spoofing.scenario import parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import FixSample

REPLAY = {"type": "replay", "from_s": 4.0}


def restamped(sample, like):
    return dataclasses.replace(sample, stamp_ns=like.stamp_ns)


def test_a_frozen_receiver_repeats_its_last_fix_and_velocity(tools, reported):
    true, spoofed = tools.flight("waving"), reported({"type": "freeze"}, "waving")
    for index in range(50, 100):
        assert spoofed.fixes[index] == restamped(true.fixes[49], true.fixes[index])
        assert spoofed.velocities[index] == restamped(true.velocities[49], true.velocities[index])


@pytest.mark.parametrize(("mode", "index"), [("zero", None), ("true", 70)])
def test_the_velocity_of_a_frozen_receiver(tools, reported, mode, index):
    spoofed = reported({"type": "freeze", "velocity": mode}, "waving")
    expected = (0.0, 0.0, 0.0) if index is None else tools.flight("waving").velocities[70].velocity
    assert spoofed.velocities[70].velocity == expected


def test_a_frozen_velocity_without_a_past_is_the_first(tools):
    true = tools.flight("waving")
    spoofed = tools.run(true, {"segments": [{"start": 0, "model": {"type": "freeze"}}]})
    assert {v.velocity for v in spoofed.velocities} == {true.velocities[0].velocity}
    assert {f.latitude_deg for f in spoofed.fixes} == {true.fixes[0].latitude_deg}


def test_a_replay_moves_on_in_time(tools, reported):
    true, spoofed = tools.flight("waving"), reported(REPLAY, "waving")
    for index in range(50, 100):
        earlier = index - 30
        assert spoofed.fixes[index] == restamped(true.fixes[earlier], true.fixes[index])
        assert spoofed.velocities[index].velocity == true.velocities[earlier].velocity


def test_a_replay_interpolates_between_samples(tools, reported):
    true, spoofed = tools.flight(), reported({"type": "replay", "from_s": 4.1})
    expected = tools.enu(true.fixes[21], true.fixes[20])
    here = tools.enu(spoofed.fixes[50], true.fixes[20])
    assert here == pytest.approx([0.5 * part for part in expected], abs=1e-6)


def test_a_replay_interpolates_across_the_antimeridian(tools):
    true = tools.flight(latitude=-17.0, longitude=179.9999)
    signs = [fix.longitude_deg > 0 for fix in true.fixes]
    across = signs.index(False)
    model = {"type": "replay", "from_s": (across - 0.5) / 5.0}
    spoofed = tools.run(true, tools.one_segment(model))
    east, north, _ = tools.enu(spoofed.fixes[50], true.fixes[across])
    assert (east, north) == pytest.approx((-0.4, -0.3), abs=1e-3)


def test_a_replay_may_overtake_its_own_onset(tools):
    true = tools.flight("waving")
    scenario = {"segments": [{"start": 10.0, "model": {"type": "replay", "from_s": 9.0}}]}
    spoofed = tools.run(true, scenario)
    assert spoofed.fixes[120] == restamped(true.fixes[115], true.fixes[120])


def test_a_replay_of_what_was_not_recorded_passes(tools):
    true = tools.flight()
    late = dataclasses.replace(true, fixes=true.fixes[60:], velocities=true.velocities[60:])
    spoofed = tools.run(late, tools.one_segment(REPLAY))
    assert spoofed.fixes[0] == late.fixes[0]
    assert spoofed.fixes[10] == restamped(late.fixes[0], late.fixes[10])


def test_a_replay_remembers_no_more_than_it_needs(tools):
    true = tools.flight(seconds=100.0)
    scenario = {
        "segments": [{"start": 40.0, "end": 60.0, "model": {"type": "replay", "from_s": 30}}]
    }
    spoofer = Spoofer(parse_scenario(scenario), true.first_ns)
    held = []
    for fix, velocity in zip(true.fixes, true.velocities, strict=True):
        spoofer.fix(fix)
        spoofer.velocity(velocity)
        (recording,) = spoofer._recordings.values()
        held.append((len(recording.fixes), len(recording.velocities)))
    assert max(held) <= (52, 52)  # 10 s at 5 Hz and one on either side
    assert held[140] == (1, 1)


def test_a_history_ignores_samples_out_of_order():
    history: History[FixSample] = History(0, None)
    history.add(FixSample(10, 1.0, 2.0, 3.0))
    history.add(FixSample(5, 9.0, 9.0, 9.0))
    assert len(history) == 1
    assert history.around(7) == (FixSample(10, 1.0, 2.0, 3.0),) * 2 + (0.0,)
