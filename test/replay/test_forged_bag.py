# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Forged parameters in a bag: the copy, the replay and the offline run say the same."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ros import ROOT
from small_bags import START_NS, flight, raw, write

from hijack_detect.bags.encoding import encode_count
from hijack_detect.bags.reader import BagReader, RawMessage
from hijack_detect.bags.samples import read_samples
from hijack_detect.replay.injection import inject
from hijack_detect.replay.offline import OfflineRun, spoofed_samples
from hijack_detect.replay.playback import MessageSpoofer, Playback
from hijack_detect.simulation.flight import generate_flight
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.spoofing.scenario import Scenario, load_scenario, parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import NANOSECONDS, FixSample, SatelliteSample

MODEL = {
    "type": "forge", "seed": 2, "altitude_sigma_m": 3.0, "satellites": [30, 40],
    "accuracy_m": [1.0, 9.0], "horizontal_sigma_m": 1.0, "velocity_sigma_m_s": 0.5,
}  # fmt: skip
TEXT = {"segments": [{"start": 1.0, "end": 3.0, "model": MODEL}]}
FORGED = parse_scenario(TEXT)
Open = Callable[..., Playback]
GPS = ("fix", "velocity", "satellites")


def offline(reader: BagReader, scenario: Scenario | None) -> list[tuple[str, Any]]:
    run = OfflineRun(reader.start_ns)
    return [one for one in spoofed_samples(reader, scenario, run) if one[0] in GPS]


@pytest.mark.parametrize("name", ["small", "curved_8"])
def test_copy_replay_and_offline_run_agree(
    name: str, bag: Path, tmp_path: Path, playback: Open
) -> None:
    path = bag if name == "small" else ROOT / "bags/curved_8"
    file = tmp_path / "forged.yaml"
    file.write_text(FORGED.to_yaml())
    with BagReader(path) as reader:
        inject(reader, tmp_path / "copy", FORGED)
        wanted = offline(reader, FORGED)
        true = offline(reader, None)
    with BagReader(tmp_path / "copy") as copy:
        topics = copy.inputs("auto")
        read = [one for one in read_samples(copy, topics) if one[0] in GPS]
        assert list(map(repr, read)) == list(map(repr, wanted))  # NaN is no number
        copied = {
            topic: [one.data for one in copy.messages({topic})]
            for input_name, topic in topics.items()
            if input_name in GPS
        }
    assert wanted != true
    assert max(one.count for _, one in wanted if isinstance(one, SatelliteSample)) >= 30
    sent: dict[str, list[bytes]] = {topic: [] for topic in copied}
    for one in playback(path, scenario=str(file)).messages():
        if f"/{one.topic}" in sent:
            sent[f"/{one.topic}"].append(one.data)
    assert sent == copied


def fixes_and_counts(path: Path) -> tuple[list[Any], list[int]]:
    with BagReader(path) as reader:
        fixes = [reader.deserialize(one) for one in reader.messages({"/gps/fix"})]
        return fixes, [reader.deserialize(one).data for one in reader.messages({"/gps/satellites"})]


def test_only_a_forged_accuracy_changes_the_covariance(bag: Path, tmp_path: Path) -> None:
    with BagReader(bag) as reader:
        inject(reader, tmp_path / "copy", FORGED)
        quiet = parse_scenario(
            {"segments": [{"start": 1.0, "model": {**MODEL, "accuracy_m": [1, 1]}}]}
        )
        inject(reader, tmp_path / "quiet", quiet)
    fixes, _ = fixes_and_counts(tmp_path / "copy")
    kinds = [one.position_covariance_type for one in fixes]
    assert kinds == [0] * 5 + [1] * 10 + [0] * 6
    attacked = np.array([one.position_covariance for one in fixes[5:15]])
    accuracy = np.sqrt(attacked[:, 0])
    assert accuracy.min() >= 1.0 and accuracy.max() <= 9.0 and accuracy.std() > 1.0
    for row, sigma in zip(attacked, accuracy, strict=True):  # unknown before: 1.5 times as high
        expected = np.diag([sigma**2, sigma**2, (1.5 * sigma) ** 2])
        assert row.reshape(3, 3) == pytest.approx(expected)
    assert [one.position_covariance.tolist() for one in fixes[:5]] == [[0.0] * 9] * 5
    fixes, _ = fixes_and_counts(tmp_path / "quiet")
    assert fixes[10].position_covariance[0] == 1.0


def test_a_known_vertical_variance_changes_in_proportion() -> None:
    with BagReader(ROOT / "bags/curved_8") as reader:
        one = next(iter(reader.messages({"/gps/fix"})))
        message = reader.deserialize(one)
    message.position_covariance = np.diag([4.0, 4.0, 36.0]).ravel()
    message.position_covariance_type = 2
    model = {**MODEL, "accuracy_m": [8.0, 8.0]}
    scenario = parse_scenario({"segments": [{"start": 0.0, "model": model}]})
    spoofer = MessageSpoofer(scenario, one.log_ns - NANOSECONDS, lambda *_: None)
    assert spoofer.apply(one, "fix", message).active
    assert message.position_covariance.tolist() == [64.0, 0, 0, 0, 64.0, 0, 0, 0, 576.0]
    assert message.position_covariance_type == 1


def test_a_count_has_the_stamp_of_the_last_usable_fix_before_it(tmp_path: Path) -> None:
    """Not its log time: the fixes of the attack begin later than the counts that come first."""
    second = NANOSECONDS
    messages = [
        RawMessage("/gps/satellites", *_at(START_NS + 10, 3)),
        raw("/gps/fix", FixSample(START_NS + second // 2, 48.0, 11.0, 500.0), START_NS + 20),
        RawMessage("/gps/satellites", *_at(START_NS + 2 * second, 3)),
        raw("/gps/fix", FixSample(START_NS + second, 48.0, 11.0, 500.0), START_NS + 2 * second + 1),
        raw("/gps/fix", FixSample(START_NS + 9, 91.0, 11.0, 500.0), START_NS + 2 * second + 2),
        RawMessage("/gps/satellites", *_at(START_NS + 2 * second + 3, 3)),
        RawMessage("/gps/satellites", *_at(START_NS + 2 * second + 4, 255)),
        raw("/gps/fix", FixSample(START_NS + 2 * second, 48.0, 11.0, 500.0), START_NS + 3 * second),
    ]
    imu = [one for one in flight() if one.topic == "/imu/data_raw"]
    path = write(tmp_path / "odd", sorted([*imu, *messages], key=lambda one: one.log_ns))
    with BagReader(path) as reader:
        done = inject(reader, tmp_path / "copy", FORGED)
        wanted = [one.count for name, one in offline(reader, FORGED) if name == "satellites"]
    _, counts = fixes_and_counts(tmp_path / "copy")
    assert counts[:2] == [3, 3] and 30 <= counts[2] <= 40 and counts[3] == 255
    assert wanted == counts[1:3]
    assert done.refused.total == 1


def _at(log_ns: int, count: int) -> tuple[str, int, bytes]:
    msgtype, data = encode_count(count)
    return msgtype, log_ns, data


def test_a_forged_receiver_in_closed_loop_forges_the_numbers_too() -> None:
    plan = FlightPlan("curved", duration_s=60.0)
    scenario = load_scenario(ROOT / "config/scenarios/soft.yaml").moved_to(30.0)
    attacked = generate_flight(plan, 3, Spoofer(scenario, plan.start_ns))
    honest = generate_flight(plan, 3)
    onset_ns = plan.start_ns + 30 * NANOSECONDS
    before = [one for one in attacked.satellites if one.stamp_ns < onset_ns]
    assert before == honest.satellites[: len(before)]
    numbers = [one.count for one in attacked.satellites[len(before) :]]
    assert min(numbers) == 6 and max(numbers) == 20
    assert [one.stamp_ns for one in attacked.satellites] == [one.stamp_ns for one in attacked.fixes]
    again = [dataclasses.replace(one, count=0) for one in honest.satellites]
    spoofer = Spoofer(scenario, plan.start_ns)
    assert [spoofer.satellites(one).count for one in again][len(before) :] == numbers
