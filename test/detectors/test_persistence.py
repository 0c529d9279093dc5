# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A condition becomes an alarm once it has held long enough; an excursion is waited for."""

import pytest

from hijack_detect.detectors.persistence import Excursion, Persistence
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


def test_a_wait_ends_its_time_after_the_last_sample_beyond() -> None:
    one = Excursion(3.0, 3.0)
    assert not one.lasts(0)
    for tenth in range(20):
        one.see(tenth * SECOND // 10, 5 <= tenth <= 10)
    assert one.lasts(4 * SECOND)
    assert not one.lasts(4 * SECOND + 1)


def test_a_longer_excursion_is_waited_for_longer_by_hand() -> None:
    """2 s, and 12 for each second beyond: 0.05 s a sample, and 0.1 s at most after a gap."""
    for count, wait_s in ((1, 2.0 + 12.0 * 0.05), (10, 2.0 + 12.0 * 0.5), (100, 30.0)):
        one = Excursion(30.0, 2.0, 12.0)
        one.see(-SECOND // 20, False)
        for sample in range(count):
            one.see(sample * SECOND // 20, True)
        end = (count - 1) * SECOND // 20 + round(wait_s * SECOND)
        assert one.lasts(end)
        assert not one.lasts(end + 1)
    one = Excursion(30.0, 2.0, 12.0)
    one.see(0, False)
    one.see(5 * SECOND, True)
    assert one.lasts(5 * SECOND + round(3.2 * SECOND))
    assert not one.lasts(5 * SECOND + round(3.2 * SECOND) + 1)
