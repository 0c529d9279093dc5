# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""From bags to samples: what is refused, and that nothing else changes."""

import logging
from pathlib import Path

import pytest

from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.bags.topics import PRESETS, TopicMap

START_NS = 1_700_000_000_000_000_000


def test_refused_messages_are_counted_and_the_first_is_kept(faulty_bag: Path) -> None:
    rejected = Rejected()
    with BagReader(faulty_bag) as bag:
        samples = list(read_samples(bag, PRESETS["default"], on_rejected=rejected.add))
    assert [name for name, _ in samples] == ["imu", "fix"]
    assert rejected.total == 4
    assert rejected.counts == {
        ("/imu/data_raw", "angular_velocity.y"): 1,
        ("/gps/fix", "latitude"): 3,
    }
    first = rejected.first["/gps/fix", "latitude"]
    assert (first.path, first.topic, first.stamp_ns) == (faulty_bag, "/gps/fix", START_NS + 8)
    assert "91.0" in first.reason
    assert "3 refused" in rejected.lines()[1]


def test_refused_messages_are_logged_when_nobody_counts(
    faulty_bag: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING), BagReader(faulty_bag) as bag:
        list(read_samples(bag, PRESETS["default"]))
    assert len(caplog.messages) == 2
    assert "topic /gps/fix" in caplog.messages[1]


def test_wrong_type_is_an_error(faulty_bag: Path) -> None:
    with BagReader(faulty_bag) as bag, pytest.raises(BagError, match="the input 'fix' needs"):
        list(read_samples(bag, TopicMap(imu="/gps/fix", fix="/imu/data_raw")))


def test_log_order(small_bag: Path) -> None:
    with BagReader(small_bag) as bag:
        stamps = [sample.stamp_ns for _, sample in read_samples(bag, PRESETS["default"])]
    assert len(stamps) == 4600
    assert stamps == sorted(stamps)
