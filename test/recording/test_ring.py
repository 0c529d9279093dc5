# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The ring holds what was last, and never more than its seconds and bytes."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.bags.reader import RawMessage
from hijack_detect.recording.black_box import OVERHEAD_BYTES, Ring, size_of

SECOND = 1_000_000_000
STEPS = st.lists(st.tuples(st.integers(0, 3 * SECOND), st.integers(0, 2000)), max_size=80)


def messages(steps: list[tuple[int, int]]) -> list[RawMessage]:
    """Messages, each so long after the one before and so large."""
    made, log_ns = [], 0
    for step, size in steps:
        log_ns += step
        made.append(RawMessage("/imu", "sensor_msgs/msg/Imu", log_ns, bytes(size)))
    return made


@given(STEPS, st.floats(0.0, 20.0), st.integers(0, 20_000))
def test_what_is_held_is_the_longest_end_within_both_bounds(
    steps: list[tuple[int, int]], seconds: float, max_bytes: int
) -> None:
    ring, heard = Ring(seconds, max_bytes), messages(steps)
    for index, message in enumerate(heard):
        ring.push(message)
        held = list(ring)
        assert ring.size == sum(map(size_of, held)) <= max_bytes
        assert held == heard[index + 1 - len(held) : index + 1]
        young = [one for one in heard[: index + 1] if message.log_ns - one.log_ns <= seconds * 1e9]
        if len(held) < len(young):
            assert ring.short
            assert ring.size + size_of(young[-len(held) - 1]) > max_bytes


@given(STEPS)
def test_with_enough_bytes_nothing_is_short(steps: list[tuple[int, int]]) -> None:
    ring = Ring(5.0, 80 * (2000 + OVERHEAD_BYTES))
    for message in messages(steps):
        ring.push(message)
        assert not ring.short
        assert ring.seconds <= 5.0


def test_short_ends_when_what_was_lost_would_be_too_old_anyway() -> None:
    ring = Ring(2.0, 3 * OVERHEAD_BYTES)
    for index in range(10):
        ring.push(RawMessage("/fix", "sensor_msgs/msg/NavSatFix", index * SECOND // 2, b""))
    assert ring.short
    ring.push(RawMessage("/fix", "sensor_msgs/msg/NavSatFix", 60 * SECOND, b""))
    assert not ring.short
