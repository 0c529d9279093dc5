# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What is told and commanded on an alert, and how often; without a link."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.mavlink.alarm import HEARD, OVER, SILENT, Alarm, Cause
from hijack_detect.mavlink.commands import Delivery, Kind, Order, Outcome, order
from hijack_detect.mavlink.vehicle import Rates

mavlink = pytest.importorskip(
    "pymavlink.dialects.v20.ardupilotmega", reason="the extra mavlink is not installed"
)
SECOND = 1_000_000_000
CAUSE = Cause("123", "coast alarm margin 1.46", ("coast", "date"))


@dataclasses.dataclass
class Kept:
    since: str | None = None

    def read(self) -> str | None:
        return self.since

    def write(self, since: str) -> None:
        self.since = since

    def forget(self) -> None:
        self.since = None


class Flight:
    """An alarm, what it told, and how often it wanted to act."""

    def __init__(self, kept: Kept | None = None) -> None:
        self.kept = kept or Kept()
        self.alarm = Alarm(self.kept, 10 * SECOND, 0)
        self.now_ns, self.told, self.acts = 0, list[str](), 0

    def wait(self, seconds: float, alert: bool | None = None, cause: Cause | None = None) -> None:
        """Let time pass; the monitor repeats an alert each second if it is given."""
        for tick in range(round(seconds * 10)):
            self.now_ns += SECOND // 10
            if alert is not None and tick % 10 == 0:
                self.told += [one.text for one in self.alarm.update(self.now_ns, alert=alert)]
                self.alarm.explain(cause if alert else None)
            texts, act = self.alarm.due(self.now_ns)
            self.told += [one.text for one in texts]
            if act:
                self.acts += 1
                self.alarm.acted()


def test_an_alert_is_told_again_and_acted_on_once() -> None:
    flight = Flight()
    flight.wait(3.0, alert=False)
    flight.wait(25.0, alert=True, cause=CAUSE)
    flight.wait(1.0, alert=False)
    assert flight.told == ["GPS SPOOFED? coast alarm margin 1.46"] * 3 + [OVER]
    assert (flight.acts, flight.kept.since) == (1, None)
    flight.wait(2.0, alert=True, cause=dataclasses.replace(CAUSE, since="456"))
    assert (flight.acts, flight.kept.since) == (2, "456")


def test_a_silent_monitor_is_told_once_and_its_alert_goes_on_after_it() -> None:
    flight = Flight()
    flight.wait(2.0, alert=True, cause=CAUSE)
    flight.wait(30.0)
    flight.wait(2.0, alert=True, cause=CAUSE)
    text = flight.alarm.text().text
    assert flight.told == [text, SILENT, HEARD, text]
    assert flight.acts == 1


def test_a_monitor_that_never_says_anything_is_missed_after_half_a_minute() -> None:
    flight = Flight()
    flight.wait(29.5)
    assert flight.told == []
    flight.wait(10.0)
    assert (flight.told, flight.acts) == ([SILENT], 0)


@pytest.mark.parametrize(
    ("before", "cause", "acts"),
    [("123", CAUSE, 0), ("122", CAUSE, 1), ("", CAUSE, 0), ("123", None, 0), (None, None, 1)],
)
def test_a_process_that_is_started_in_an_alert_knows_whether_it_was_acted_on(
    before: str | None, cause: Cause | None, acts: int
) -> None:
    flight = Flight(Kept(before))
    flight.wait(2.0, alert=True, cause=cause)
    assert flight.acts == acts
    assert len(flight.told) == 1


@given(st.lists(st.tuples(st.sampled_from((True, False, None)), st.integers(1, 60)), max_size=20))
def test_there_is_never_more_than_one_act_an_alert(said: list[tuple[bool | None, int]]) -> None:
    flight, alerts, on = Flight(), 0, False
    for alert, tenths in said:
        alerts += bool(alert and not on)
        on = on if alert is None else alert
        flight.wait(tenths / 10, alert=alert, cause=CAUSE)
    assert flight.acts <= alerts


@given(st.text(min_size=1, max_size=80), st.lists(st.sampled_from(("coast", "gnss", "kld"))))
def test_a_text_fits_and_says_as_much_as_it_can(words: str, names: list[str]) -> None:
    alarm = Alarm(Kept(), SECOND, 0)
    alarm.explain(Cause("1", words, tuple(names)))
    text = alarm.text().text
    assert len(text) <= 50 and text.startswith("GPS SPOOFED?")
    if len(words) <= 37 and words.rstrip() == words:
        assert text.endswith(words)


@given(st.lists(st.sampled_from((None, 0, 1, 2, 3, 4, 5, 6, 99)), max_size=12), st.integers(1, 6))
def test_a_command_is_sent_a_bounded_number_of_times(
    answers: list[int | None], attempts: int
) -> None:
    delivery = Delivery(Order("land", 21, (0.0,) * 7), attempts, SECOND)
    confirmations = []
    now_ns = 1
    for answer in [*answers, *[None] * 12]:
        if (confirmation := delivery.due(now_ns)) is not None:
            confirmations.append(confirmation)
        if answer is not None:
            assert not delivery.acknowledge(20, answer, now_ns), "another command"
            delivery.acknowledge(21, answer, now_ns)
        now_ns += 31 * SECOND
    assert confirmations == list(range(len(confirmations)))
    assert 1 <= len(confirmations) <= attempts
    final = [one for one in answers[: len(confirmations)] if one not in (None, 1, 5)]
    expected = Outcome.DONE if final[:1] == [0] else Outcome.REFUSED if final else Outcome.LOST
    assert delivery.outcome is expected


def test_each_autopilot_gets_its_own_command() -> None:
    px4, ardupilot = mavlink.MAV_AUTOPILOT_PX4, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    quad, plane = mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_TYPE_FIXED_WING
    for name, kind, command, first in (
        ("land", Kind(px4, quad), 21, (0, 0, 0)),
        ("land", Kind(ardupilot, quad), 21, (0, 0, 0)),
        ("rtl", Kind(px4, plane), 20, (0, 0, 0)),
        ("user_1", Kind(ardupilot, plane), 31010, (1, 0, 0)),
        ("hold", Kind(px4, quad), 176, (1, 4, 3)),
        ("hold", Kind(ardupilot, quad), 176, (1, 2, 0)),
        ("hold", Kind(ardupilot, plane), 176, (1, 1, 0)),
        ("hold", Kind(ardupilot, mavlink.MAV_TYPE_GROUND_ROVER), 176, (1, 4, 0)),
    ):
        made = order(name, kind, mavlink)
        assert (made.command, made.params[:3], len(made.params)) == (command, first, 7)
        follows = name in ("land", "rtl") or (name == "hold" and kind.autopilot == px4)
        assert bool(made.danger) == follows
    for name, kind in (
        ("land", Kind(ardupilot, plane)),
        ("hold", Kind(ardupilot, mavlink.MAV_TYPE_SUBMARINE)),
        ("hold", Kind(0, quad)),
    ):
        with pytest.raises(ValueError, match="choose"):
            order(name, kind, mavlink)


def test_the_next_imu_is_asked_for_where_one_is_refused() -> None:
    rates = Rates(50.0, 5.0, mavlink)
    rates.restart()
    asked, now_ns = [], 1
    while rates.busy:
        if (due := rates.due(now_ns)) is not None:
            message = mavlink.mavlink_map[int(due[0].params[0])].msgname
            asked.append((message, due[0].params[1]))
            refused = mavlink.MAV_RESULT_UNSUPPORTED if message == "HIGHRES_IMU" else 0
            rates.acknowledge(511, refused, now_ns)
        rates.news()
        now_ns += SECOND
    assert asked == [
        ("HIGHRES_IMU", 20_000.0),
        ("SCALED_IMU", 20_000.0),
        ("GPS_RAW_INT", 200_000.0),
        ("SCALED_PRESSURE", 200_000.0),
    ]
    rates = Rates(0.0, 0.0, mavlink)
    rates.restart()
    assert rates.due(1) is None
