# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Numbers of satellites find their fix by the order of publication, whatever overtakes what."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.streams.samples import SatelliteSample
from hijack_detect.streams.satellites import SatelliteStamps

Event = tuple[int, str, int]
"""Published, topic, stamp or count."""


def run(events: list[Event]) -> list[SatelliteSample]:
    stamps = SatelliteStamps()
    found = []
    for published, topic, value in events:
        found += getattr(stamps, topic)(published, value)
    return found


def test_a_count_is_of_the_fix_before_it_once_the_next_is_there() -> None:
    stamps = SatelliteStamps()
    assert stamps.fix(10, 1000) == []
    assert stamps.count(11, 12) == []
    assert stamps.fix(20, 2000) == [SatelliteSample(1000, 12)]
    assert stamps.count(21, 13) == []
    assert stamps.fix(30, 3000) == [SatelliteSample(2000, 13)]


def test_a_count_that_arrives_after_the_next_fix_is_certain_at_once() -> None:
    stamps = SatelliteStamps()
    stamps.fix(10, 1000)
    stamps.fix(20, 2000)
    assert stamps.count(11, 12) == [SatelliteSample(1000, 12)]


def test_a_count_before_any_fix_is_dropped() -> None:
    assert run([(1, "count", 9), (2, "fix", 1000), (3, "count", 10), (4, "fix", 2000)]) == [
        SatelliteSample(1000, 10)
    ]


def test_memory_is_bounded_when_one_topic_stops() -> None:
    stamps = SatelliteStamps()
    for published in range(5000):
        assert stamps.count(published, 9) == []
    assert len(stamps._counts) == 1000


@st.composite
def flights(draw: st.DrawFn) -> tuple[list[Event], list[Event]]:
    """Events as published, and as they arrive: each topic in order, the topics mixed anyhow."""
    kinds = draw(st.lists(st.sampled_from(["fix", "count"]), max_size=40))
    published: list[Event] = [(n, kind, 100 * n) for n, kind in enumerate(kinds)]
    queues = {kind: [e for e in published if e[1] == kind] for kind in ("fix", "count")}
    arrived = []
    while any(queues.values()):
        kind = draw(st.sampled_from([kind for kind, queue in queues.items() if queue]))
        arrived.append(queues[kind].pop(0))
    return published, arrived


@given(flights())
def test_the_order_of_arrival_changes_nothing(flight: tuple[list[Event], list[Event]]) -> None:
    published, arrived = flight
    assert run(arrived) == run(published)
