# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The monitor over recorded flights, without ROS."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import pytest
from live import SCENARIO, SECOND, offline
from ros import ROOT
from small_bags import START_NS, STEP_NS, flight, raw, write

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader
from hijack_detect.detectors.verdict import State
from hijack_detect.monitor.policies import POLICIES, policy_parameters
from hijack_detect.replay.offline import OfflineRun, run_offline
from hijack_detect.spoofing.scenario import ScenarioError, load_scenario
from hijack_detect.streams.samples import FixSample, ImuSample

BAGS = ("curved_8", "straight_3", "curved_no_velocity_5")
WITHIN_S = 10.0


def run(bag: str, policy: str, *, spoofed: bool) -> OfflineRun:
    return offline(ROOT / "bags" / bag, policy, SCENARIO if spoofed else None)


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("bag", BAGS)
def test_a_clean_flight_raises_no_alert(bag: str, policy: str) -> None:
    done = run(bag, policy, spoofed=False)
    assert not any(result.alert for result in done.results)
    assert done.rejected.total == 0
    assert done.separations == []
    assert done.separation_at(2**63) == 0.0
    assert any(result.state is State.NORMAL for result in done.results)


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("bag", BAGS)
def test_the_papers_attack_raises_an_alert_within_ten_seconds(bag: str, policy: str) -> None:
    done = run(bag, policy, spoofed=True)
    onset_s = load_scenario(SCENARIO).segments[0].start_s
    first = next(index for index, result in enumerate(done.results) if result.alert)
    alert_ns = done.results[first].stamp_ns
    assert onset_s < (alert_ns - done.start_ns) / SECOND < onset_s + WITHIN_S
    assert 0.0 < done.separation_at(alert_ns) < 150.0
    assert done.separation_at(done.start_ns + round(onset_s * SECOND) - 1) == 0.0
    latched = done.results[first:]
    assert all(result.alert and result.alert_since_ns == alert_ns for result in latched)


@pytest.mark.parametrize("policy", POLICIES)
def test_before_the_onset_an_attack_changes_nothing(policy: str) -> None:
    clean, spoofed = (run("curved_8", policy, spoofed=flag) for flag in (False, True))
    onset_ns = clean.start_ns + 60 * SECOND
    for name, verdicts in clean.verdicts.items():
        before = [one for one in verdicts if one.stamp_ns < onset_ns]
        assert before == spoofed.verdicts[name][: len(before)]
        assert verdicts != spoofed.verdicts[name]


def test_stamps_rise_and_every_verdict_goes_into_the_fusion() -> None:
    done = run("curved_8", "default", spoofed=True)
    for verdicts in done.verdicts.values():
        stamps = [one.stamp_ns for one in verdicts]
        assert stamps == sorted(set(stamps))
        assert all(math.isfinite(one.score) and one.threshold > 0.0 for one in verdicts)
    fused = [result.stamp_ns for result in done.results]
    assert fused == sorted(fused)
    # What comes after the last verdict of any one detector still waits for that detector.
    said_ns = [one.stamp_ns for verdicts in done.verdicts.values() for one in verdicts]
    end_ns = min(verdicts[-1].stamp_ns for verdicts in done.verdicts.values())
    assert fused == sorted(stamp_ns for stamp_ns in said_ns if stamp_ns <= end_ns)
    assert all(0.0 <= result.confidence <= 1.0 for result in done.results)


def test_bad_messages_are_counted_and_left_out(tmp_path: Path) -> None:
    good = list(flight(6.0))
    between = START_NS + 3 * SECOND + STEP_NS // 2
    bad = [
        raw("/imu/data_raw", ImuSample(between, (math.nan, 0.0, 0.0), (0.0, 0.0, 9.8))),
        raw("/imu/data_raw", ImuSample(between + 1, (math.nan, 0.0, 0.0), (0.0, 0.0, 9.8))),
        raw("/gps/fix", FixSample(between, 91.0, 11.0, 500.0)),
    ]
    runs = []
    for name, messages in (("good", good), ("bad", [*good, *bad])):
        path = write(tmp_path / name, sorted(messages, key=lambda one: one.log_ns))
        with BagReader(path) as reader:
            runs.append(run_offline(reader, policy_parameters("default")))
    clean, dirty = runs
    assert dirty.rejected.counts == {
        ("/imu/data_raw", "angular_velocity.x"): 2, ("/gps/fix", "latitude"): 1
    }  # fmt: skip
    assert dirty.rejected.first["/gps/fix", "latitude"].stamp_ns == between
    assert dataclasses.replace(dirty, rejected=clean.rejected) == clean
    assert clean.results != []


def test_every_sample_is_told_and_the_same_bag_gives_the_same_again(tmp_path: Path) -> None:
    path = write(tmp_path / "flight", flight(6.0))
    told: list[int] = []
    runs = []
    for _ in range(2):
        with BagReader(path) as reader:
            parameters = policy_parameters("default")
            runs.append(
                run_offline(reader, parameters, on_sample=lambda one: told.append(one.stamp_ns))
            )
    assert runs[0] == runs[1]
    assert len(told) == 2 * (301 + 31 + 31 + 30)  # the last count waits for a fix after it


def test_an_attack_outside_of_the_flight_is_refused() -> None:
    scenario = load_scenario(SCENARIO).moved_to(105.0)
    with (
        BagReader(ROOT / "bags/curved_8") as reader,
        pytest.raises(ScenarioError, match=r"turn_away_track\.yaml.*end.*outside the flight"),
    ):
        run_offline(reader, policy_parameters("default"), scenario)


def test_a_bag_without_imu_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "no_imu", (one for one in flight(2.0) if "imu" not in one.topic))
    with BagReader(path) as reader, pytest.raises(BagError, match="Imu"):
        run_offline(reader, policy_parameters("default"))
