# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A condition becomes an alarm once it has held long enough."""

import pytest

from hijack_detect.detectors.persistence import Persistence
from hijack_detect.detectors.verdict import State, Verdict

SECOND = 10**9


def test_suspicious_before_alarm() -> None:
    one = Persistence(1.0)
    assert one.state(0, False) is State.NORMAL
    assert one.state(SECOND, True) is State.SUSPICIOUS
    assert one.state(2 * SECOND - 1, True) is State.SUSPICIOUS
    assert one.state(2 * SECOND, True) is State.ALARM
    assert one.state(3 * SECOND, True) is State.ALARM
    assert one.state(4 * SECOND, False) is State.NORMAL
    assert one.state(5 * SECOND, True) is State.SUSPICIOUS


def test_reset_starts_over() -> None:
    one = Persistence(1.0)
    one.state(0, True)
    one.reset()
    assert one.state(2 * SECOND, True) is State.SUSPICIOUS


def test_without_persistence_the_first_sample_alarms() -> None:
    assert Persistence(0.0).state(0, True) is State.ALARM


def test_margin_is_score_over_threshold() -> None:
    verdict = Verdict("any", 0, State.NORMAL, 3.0, 1.5, "")
    assert verdict.margin == pytest.approx(2.0)
