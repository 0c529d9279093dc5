# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Which messages get into a snapshot: decided on stamps, in the order of arrival."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest
from recorded import SECOND, SOURCES, START_NS, fix, flag, fusion, imu

from hijack_detect.recording.black_box import LATE_S, QUIET_S, SLACK_S, BlackBox, snapshot_name
from hijack_detect.recording.parameters import RecorderParameters
from hijack_detect.recording.snapshots import Snapshot


class Flight:
    """A black box and its inputs."""

    def __init__(self, **parameters: Any) -> None:
        self.box = BlackBox(RecorderParameters(before_s=10.0, after_s=5.0, **parameters))
        self.stamp_ns = START_NS
        self.wall_s = 0.0

    def receive(self, name: str, data: bytes) -> int | None:
        one = SOURCES[name]
        return self.box.push(
            name, one.topic, one.msgtype, data, stamped=one.stamped, wall_s=self.wall_s
        )

    def fly(self, seconds: float, *, judged: bool = True) -> None:
        for _ in range(round(seconds * 10)):
            self.stamp_ns += SECOND // 10
            self.receive("imu", imu(self.stamp_ns))
            self.receive("fix", fix(self.stamp_ns))
            self.receive("hijack_alert", flag(False))
            if judged:
                self.receive("fusion", fusion(self.stamp_ns, alert=False))

    def alert(self) -> int:
        """Alert now; returns the stamp."""
        self.receive("fusion", fusion(self.stamp_ns, alert=True))
        self.box.alert(self.stamp_ns)
        return self.stamp_ns

    def due(self) -> list[Snapshot]:
        return self.box.due(self.wall_s)


def span(snapshot: Snapshot) -> tuple[int, int]:
    assert all(a.log_ns <= b.log_ns for a, b in pairwise(snapshot.messages))
    return snapshot.messages[0].log_ns, snapshot.messages[-1].log_ns


def test_a_part_at_once_and_the_whole_when_the_time_is_over() -> None:
    flight = Flight()
    flight.fly(60)
    alert = flight.alert()
    (part,) = flight.due()
    assert part.directory == f"{snapshot_name(alert)}.part1"
    assert span(part) == (alert - 10 * SECOND, alert)
    assert part.messages[-1].topic == "/fusion/verdict"
    flight.fly(7)
    assert flight.due() == []
    flight.fly(0.1)
    (whole,) = flight.due()
    assert whole.directory == snapshot_name(alert)
    assert span(whole) == (alert - 10 * SECOND, alert + 5 * SECOND)
    assert tuple(whole.messages[: len(part.messages)]) == tuple(part.messages)
    assert flight.due() == []


def test_messages_without_a_header_have_the_time_of_the_one_before() -> None:
    flight = Flight()
    assert flight.receive("hijack_alert", flag(False)) is None
    assert len(flight.box.ring) == 0
    flight.fly(1)
    assert flight.receive("satellites", b"\0\1\0\0\7\0\0\0") is None
    assert list(flight.box.ring)[-1].log_ns == flight.stamp_ns


def test_a_topic_that_arrives_late_gives_the_same_snapshot() -> None:
    made = []
    for late_s in (0, 1, 15):
        flight = Flight()
        for index in range(1, 400 + late_s * 10):
            now, late = (
                START_NS + index * SECOND // 10,
                START_NS + (index - late_s * 10) * SECOND // 10,
            )
            if index < 400:
                flight.receive("fix", fix(now))
            if late > START_NS:
                flight.receive("imu", imu(late))
                alert = late == START_NS + 20 * SECOND
                flight.receive("fusion", fusion(late, alert=alert))
                if alert:
                    flight.box.alert(late)
        flight.box.finish()
        (whole,) = flight.due()
        made.append([(one.topic, one.log_ns) for one in whole.messages])
    assert sorted(made[0]) == sorted(made[1])
    assert len(made[0]) == 3 * 151
    fixes = [[one for one in found if one[0] == "/gps/fix"] for found in made]
    assert fixes[0] == fixes[2]


@pytest.mark.parametrize(("late_s", "from_s"), [(25, 10), (LATE_S, 10), (LATE_S + SLACK_S + 5, 15)])
def test_what_a_late_fusion_has_not_judged_is_kept(late_s: float, from_s: float) -> None:
    flight = Flight()
    flight.receive("fusion", fusion(START_NS, alert=False))
    for index in range(round(10 * (20 + late_s))):
        flight.receive("fix", fix(START_NS + index * SECOND // 10))
        judged = START_NS + index * SECOND // 10 - round(late_s * SECOND)
        if judged > START_NS:
            flight.receive("fusion", fusion(judged, alert=False))
    flight.stamp_ns = START_NS + 20 * SECOND
    flight.alert()
    flight.box.finish()
    (whole,) = flight.due()
    fixes = [one.log_ns for one in whole.messages if one.topic == "/gps/fix"]
    assert (fixes[0] - START_NS) / SECOND == pytest.approx(from_s, abs=0.2)
    assert fixes[-1] - START_NS == 25 * SECOND
    assert not flight.box.ring.short


def test_a_verdict_with_a_broken_stamp_is_not_taken_for_a_fusion_in_time() -> None:
    flight = Flight()
    flight.fly(20)
    alert = flight.alert()
    flight.due()
    flight.fly(20, judged=False)
    flight.receive("fusion", fusion(alert + 10**6 * SECOND, alert=True))
    assert flight.due() == []
    flight.receive("fusion", fusion(alert + SECOND, alert=True))
    flight.box.finish()
    (whole,) = flight.due()
    assert whole.messages[-1].log_ns == alert + 5 * SECOND


def test_a_fusion_that_died_leaves_the_ring_bounded_and_ends_a_snapshot() -> None:
    flight = Flight()
    flight.fly(20)
    flight.alert()
    flight.due()
    flight.fly(60, judged=False)
    (whole,) = flight.due()
    assert whole.complete
    flight.fly(600, judged=False)
    assert flight.box.ring.seconds == pytest.approx(LATE_S + SLACK_S + 10.0, abs=0.2)


def test_a_sensor_with_a_clock_of_its_own_is_kept_in_its_place() -> None:
    flight = Flight()
    for index in range(300):
        now = index * SECOND // 10
        flight.receive("fix", fix(START_NS + now))
        flight.receive("imu", imu(5 * SECOND + now))
    flight.box.alert(START_NS + 20 * SECOND)
    flight.box.finish()
    (whole,) = flight.due()
    topics = [one.topic for one in whole.messages]
    assert topics == ["/gps/fix", "/imu/data_raw"] * (len(topics) // 2)


def test_silence_ends_a_snapshot() -> None:
    flight = Flight()
    flight.fly(20)
    flight.alert()
    flight.due()
    flight.wall_s += QUIET_S
    assert flight.due() == []
    flight.wall_s += 0.1
    (whole,) = flight.due()
    assert whole.complete


def test_an_alert_in_the_time_after_makes_the_snapshot_longer() -> None:
    flight = Flight()
    flight.fly(20)
    first = flight.alert()
    flight.due()
    flight.fly(3)
    second = flight.alert()
    (part,) = flight.due()
    assert (part.name, part.part) == (snapshot_name(first), 2)
    assert span(part) == (first - 10 * SECOND, second)
    flight.fly(8)
    (whole,) = flight.due()
    assert whole.alerts_ns == (first, second)
    assert span(whole) == (first - 10 * SECOND, second + 5 * SECOND)


def test_an_alert_after_it_has_a_snapshot_of_its_own() -> None:
    flight = Flight()
    flight.fly(20)
    flight.alert()
    flight.fly(8)
    second = flight.alert()
    flight.fly(8)
    assert [one.complete for one in flight.due()] == [True, True]
    assert not flight.box.collecting
    assert snapshot_name(second).endswith("28.000Z")


def test_a_part_waits_while_the_disk_is_busy() -> None:
    flight = Flight()
    flight.fly(20)
    flight.alert()
    assert flight.box.due(0.0, busy=True) == []
    assert [one.part for one in flight.due()] == [1]


def test_one_broken_stamp_changes_neither_window_nor_order() -> None:
    flight = Flight()
    flight.fly(20)
    assert flight.receive("fix", fix(START_NS + 10**8 * SECOND)) is None
    alert = flight.alert()
    flight.fly(2)
    assert flight.receive("fix", fix(0)) is None
    flight.fly(6)
    (whole,) = flight.due()
    assert span(whole) == (alert - 10 * SECOND, alert + 5 * SECOND)


def test_a_looped_bag_ends_the_snapshot_and_begins_afresh() -> None:
    flight = Flight()
    flight.fly(60)
    alert = flight.alert()
    flight.due()
    flight.fly(1)
    flight.stamp_ns = START_NS
    flight.fly(2)
    (whole,) = flight.due()
    assert span(whole) == (alert - 10 * SECOND, alert + SECOND)
    assert next(iter(flight.box.ring)).log_ns < START_NS + SECOND


@pytest.mark.parametrize("hz", [50, 2000])
def test_memory_stays_in_its_bound_however_much_arrives(hz: int) -> None:
    flight = Flight(ring_max_mb=1)
    most = 0
    for index in range(12 * hz):
        if index == 8 * hz:
            flight.alert()
        flight.stamp_ns += SECOND // hz
        flight.receive("imu", imu(flight.stamp_ns))
        most = max(most, flight.box.size)
    assert most <= 1_000_000
    assert flight.box.ring.short == (hz == 2000)


def test_nothing_is_collected_before_the_first_stamp() -> None:
    box = BlackBox(RecorderParameters())
    box.alert(None)
    assert box.due(0.0) == []


def test_a_name_tells_the_time_of_the_alert() -> None:
    assert snapshot_name(1_795_613_710_123_999_999) == "alert_20261125T133510.123Z"
