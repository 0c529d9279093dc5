# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Seeded onsets in forward flight."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ros import ROOT
from small_bags import START_NS, raw, write

from hijack_detect.bags.reader import BagReader
from hijack_detect.evaluation.trials.cases import BagCase
from hijack_detect.evaluation.trials.onsets import (
    SHORTEST_S,
    attacked,
    forward_flight,
    seeded_onsets,
)
from hijack_detect.spoofing.scenario import load_scenario
from hijack_detect.streams.samples import FixSample, ImuSample, VelocitySample

SPANS = st.lists(st.tuples(st.floats(0.1, 50.0), st.floats(0.1, 50.0)), min_size=1, max_size=6)
SECOND = 1_000_000_000


def flown(path: Path, speeds: list[float], *, with_velocity: bool) -> Path:
    """A flight to the North with one speed for each second, at 5 Hz."""
    messages, north_m = (
        [raw("/imu/data_raw", ImuSample(START_NS, (0.0,) * 3, (0.0, 0.0, 9.8)))],
        0.0,
    )
    for step in range(5 * len(speeds)):
        stamp, speed = START_NS + step * SECOND // 5, speeds[step // 5]
        messages.append(raw("/gps/fix", FixSample(stamp, 48.0 + north_m / 111_200.0, 11.0, 500.0)))
        if with_velocity:
            messages.append(raw("/gps/vel", VelocitySample(stamp, (0.0, speed, 0.0))))
        north_m += speed / 5.0
    return write(path, messages)


@pytest.mark.parametrize("with_velocity", [True, False])
def test_forward_flight_is_what_is_fast(with_velocity: bool, tmp_path: Path) -> None:
    speeds = [0.0] * 10 + [8.0] * 10 + [1.0] * 5 + [5.0] * 6 + [1.0] + [5.0] * 4 + [2.0] * 3
    path = flown(tmp_path / "flown", speeds, with_velocity=with_velocity)
    with BagReader(path) as reader:
        spans = forward_flight(reader)
    # Seconds 10 to 20, and 25 to 36 with a pause of a second in it, at 5 Hz.
    assert spans == [pytest.approx((10.0, 19.8), abs=0.21), pytest.approx((25.0, 35.8), abs=0.21)]


def test_no_forward_flight_no_onset(tmp_path: Path) -> None:
    path = flown(tmp_path / "hover", [0.5] * 20, with_velocity=True)
    with BagReader(path) as reader:
        assert forward_flight(reader) == []
    scenario = load_scenario(ROOT / "config/scenarios/jump.yaml")
    assert attacked(BagCase(path, "hover", "unlabelled"), scenario, 5) == []


@given(SPANS, st.integers(1, 8), st.text(max_size=5), st.floats(1.0, 200.0))
def test_onsets_lie_in_forward_flight(
    pieces: list[tuple[float, float]], count: int, name: str, latest_s: float
) -> None:
    spans, t = [], 0.0
    for pause, length in pieces:
        spans.append((t + pause, t + pause + length))
        t += pause + length
    onsets = seeded_onsets(spans, latest_s, count, name)
    assert onsets == sorted(onsets) == seeded_onsets(spans, latest_s, count, name)
    usable = any(min(end - SHORTEST_S, latest_s) > begin for begin, end in spans)
    assert len(onsets) == (count if usable else 0)
    for onset in onsets:
        assert onset <= latest_s + 0.05
        assert any(begin - 0.05 <= onset <= end - SHORTEST_S + 0.05 for begin, end in spans)


def test_each_part_of_the_flight_has_one() -> None:
    onsets = seeded_onsets([(10.0, 45.0), (55.0, 85.0)], 1000.0, 5, "x")
    # 30 and 25 s of forward flight in which an attack may begin: five parts of 11 s.
    along = [onset - 10.0 if onset <= 40.0 else onset - 25.0 for onset in onsets]
    assert [int(s / 11.0) for s in along] == [0, 1, 2, 3, 4]
    assert onsets != seeded_onsets([(10.0, 45.0), (55.0, 85.0)], 1000.0, 5, "y")


def test_the_attack_moves_to_each_onset() -> None:
    scenario = load_scenario(ROOT / "config/scenarios/turn_away_track.yaml")
    cases = attacked(BagCase(ROOT / "bags/curved_8", "curved_8", "curved"), scenario, 3)
    assert [case.kind for case in cases] == ["hijacked"] * 3
    for case in cases:
        assert case.scenario is not None
        segment = case.scenario.segments[0]
        assert case.name == f"curved_8@{segment.start_s:g}s"
        assert segment.end_s == pytest.approx(segment.start_s + 30.0)
