# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The bags that speed is measured with, the jobs, and what counts as worse."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples

SPEED = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short flight with a fast IMU."""
    from load import load_bag  # noqa: PLC0415

    return load_bag(tmp_path_factory.mktemp("load"), 60.0, 200, 10)


def test_a_bag_has_the_rates_that_were_asked_for(bag: Path) -> None:
    rejected = Rejected()
    with BagReader(bag) as reader:
        counts = reader.message_counts
        assert counts["/imu/data_raw"] == pytest.approx(60 * 200, abs=2)
        assert counts["/gps/fix"] == counts["/gps/vel"] == pytest.approx(60 * 10, abs=12)
        assert sum(counts.values()) == sum(1 for _ in reader.messages())
        assert sum(1 for _ in read_samples(reader, reader.inputs(), on_rejected=rejected.add))
    assert rejected.total == 0


def test_a_bag_that_is_there_is_not_made_again(bag: Path) -> None:
    from load import load_bag  # noqa: PLC0415

    before = {path: path.stat().st_mtime_ns for path in bag.iterdir()}
    assert load_bag(bag.parent, 60.0, 200, 10) == bag
    assert {path: path.stat().st_mtime_ns for path in bag.iterdir()} == before


def test_every_job_counts_what_it_did(bag: Path) -> None:
    from jobs import JOBS  # noqa: PLC0415

    found = {}
    for name in JOBS:
        command = [sys.executable, str(SPEED / "jobs.py"), name, str(bag)]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        found[name] = json.loads(done.stdout)
        assert found[name]["cpu_s"] > 0.0
        assert found[name]["peak_mb"] > 10.0
    assert found["iterate"]["count"] == found["rosbags"]["count"]
    assert found["decode"]["count"] == pytest.approx(found["rosbags"]["count"], abs=2)
    assert found["detect"]["count"] > 300


def test_a_fifth_more_is_worse_and_names_the_job() -> None:
    from bench import compared  # noqa: PLC0415

    before = {"offline": {"decode": 0.3, "detect": 10.0}}
    assert compared({"offline": {"detect": 12.0, "new": 99.0}, "live": {"load": 9.0}}, before) == []
    (line,) = compared({"offline": {"decode": 0.3, "detect": 12.1}}, before)
    assert line == "offline: detect is 12.10, the baseline is 10.00"
