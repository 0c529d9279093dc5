# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What the page is told: states with cause and time, histories, and nothing that JSON has not."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shown import START_NS, Flown

from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.live.handlers import Feed, event
from hijack_detect.live.picture import KEPT_S, MOST, Frame, Picture
from hijack_detect.monitor.parts import DETECTORS
from hijack_detect.streams.samples import FixSample


def told(flown: Flown) -> Frame:
    return flown.picture.frame(None)[0]


def test_before_anything_is_heard_the_monitor_is_silent_and_not_normal() -> None:
    frame = told(Flown())
    assert (frame["state"], frame["silent"], frame["time"]) == ("silent", None, None)
    assert {one["state"] for one in frame["detectors"]} == {"silent"}


@pytest.mark.parametrize(
    ("given", "state", "why"),
    [
        ({}, "normal", "nearest to its limit"),
        ({"state": State.SUSPICIOUS, "reason": "Δa 2 m/s²"}, "suspicious", "coast: Δa 2 m/s²"),
        ({"alert": True, "reason": "coast alarm"}, "alarm", "coast alarm"),
        ({"degraded": ("kld", "drag")}, "degraded", "without kld, drag"),
        (
            {"state": State.STALE, "reason": "all inputs had stopped"},
            "degraded",
            "all inputs had stopped",
        ),
        ({"state": State.NOT_OBSERVABLE}, "not_observable", "no detector can tell"),
        ({"state": State.NOT_READY}, "not_ready", "getting ready"),
        ({"alert": True, "degraded": ("kld",), "reason": "coast"}, "alarm", "coast"),
    ],
)
def test_a_state_is_told_with_its_cause(given: dict[str, Any], state: str, why: str) -> None:
    flown = Flown()
    flown.fly(2.0, **given)
    frame = told(flown)
    assert (frame["state"], frame["said"]) == (state, state)
    assert why in frame["why"]


def test_silence_goes_by_the_wall_clock_and_says_what_was_said_last() -> None:
    flown = Flown()
    flown.fly(2.0, alert=True)
    flown.now += 2.4
    assert told(flown)["state"] == "alarm"
    flown.now += 0.2
    frame = told(flown)
    assert (frame["state"], frame["said"], frame["probability"]) == ("silent", "alarm", None)
    assert frame["silent"] == pytest.approx(2.6)
    flown.now += 3.0
    assert {one["why"] for one in told(flown)["detectors"]} == {"no verdict for 6 s"}


def test_a_fusion_that_can_say_nothing_is_degraded_until_it_can() -> None:
    flown = Flown()
    flown.fly(1.0)
    flown.picture.receive_stale("DEGRADED, nothing can be said for 5 s")
    assert told(flown)["state"] == "degraded"
    assert "for 5 s" in told(flown)["why"]
    flown.fly(0.2)
    assert told(flown)["state"] == "normal"


def test_an_alarm_lasts_since_the_stamp_that_the_fusion_names_and_changes_are_kept() -> None:
    flown = Flown()
    flown.fly(4.0)
    flown.fly(0.2, alert=True)
    frame = told(flown)
    assert frame["since"] == pytest.approx(4.0)
    assert [state for _, state in frame["states"]] == ["silent", "normal", "alarm"]
    assert frame["states"][2][0] == pytest.approx(4.0)


def test_an_alert_without_its_verdict_is_told_at_once_and_kept_with_a_stamp_when_there_is_one() -> (
    None
):
    flown = Flown()
    flown.fly(4.0)
    flown.picture.receive_alert(True)
    assert told(flown)["state"] == "alarm"
    assert told(flown)["states"][-1][1] == "normal"
    flown.now += 1.1
    assert told(flown)["states"][-1][1] == "alarm"


def test_the_track_is_in_metres_about_the_first_fix_with_gaps_where_there_was_none() -> None:
    flown = Flown()
    flown.fly(10.0)
    first, last = told(flown)["track"][0], told(flown)["track"][-1]
    assert first[1:] == (0.0, 0.0)
    metres_per_degree = 111_200.0
    assert last[2] == pytest.approx(9.8e-4 * metres_per_degree, rel=0.025)
    assert last[1] / last[2] == pytest.approx(math.cos(math.radians(48.0)), rel=0.01)
    for _ in range(3):
        flown.time_s += 0.2
        flown.picture.receive_fix(FixSample(flown.stamp_ns, 0.0, 0.0, 0.0, has_fix=False))
    assert told(flown)["position"] is None
    assert [len(one) for one in told(flown)["track"][-2:]] == [3, 1]


def test_memory_is_bounded_and_minutes_are_kept() -> None:
    flown = Flown()
    flown.fly(KEPT_S + 120.0)
    frame = told(flown)
    assert len(frame["track"]) <= MOST
    assert frame["time"] - frame["track"][0][0] >= KEPT_S - 1.0
    assert all(len(points) <= MOST for points in frame["margins"].values())
    assert len(event(frame)) < 500_000


def test_a_reader_is_told_what_is_new_and_a_new_flight_begins_afresh() -> None:
    flown = Flown()
    flown.fly(20.0)
    first, cursor = flown.picture.frame(None)
    assert first["reset"]
    flown.fly(1.0)
    news, cursor = flown.picture.frame(cursor)
    assert not news["reset"]
    assert 2 <= len(news["track"]) <= 5
    assert news["track"][0][0] > first["track"][-1][0]
    nothing, cursor = flown.picture.frame(cursor)
    assert (nothing["track"], nothing["margins"]) == ([], {})
    flown.time_s = 0.0
    flown.fly(1.0)
    again, _ = flown.picture.frame(cursor)
    assert again["reset"]
    assert again["time"] == pytest.approx(0.8)
    assert len(again["track"]) < 6


def test_a_complaint_is_shown_until_it_is_taken_back_or_old() -> None:
    flown = Flown()
    flown.picture.receive_complaint("fusion: publishers", "2 publishers on /hijack_alert")
    flown.picture.receive_complaint("coast: inputs", "left out")
    assert told(flown)["complaints"] == [
        "coast: inputs: left out",
        "fusion: publishers: 2 publishers on /hijack_alert",
    ]
    flown.picture.receive_complaint("coast: inputs", "")
    assert len(told(flown)["complaints"]) == 1
    flown.now += 6.0
    assert told(flown)["complaints"] == []


def test_readers_that_are_equally_far_share_an_event_until_the_next_tick() -> None:
    flown = Flown()
    feed = Feed(flown.picture)
    made, cursor = feed.next(None)
    assert feed.next(None)[0] is made
    flown.fly(1.0)
    assert feed.next(None)[0] is made
    feed.tick()
    assert feed.next(None)[0] != made
    assert json.loads(feed.next(cursor)[0].removeprefix(b"data: "))["state"] == "normal"


STATES = st.sampled_from(list(State))
NUMBERS = st.floats(allow_nan=True, allow_infinity=True)


@given(
    st.lists(
        st.tuples(st.sampled_from(DETECTORS), STATES, NUMBERS, st.text(max_size=40)), max_size=30
    ),
    NUMBERS,
    st.text(),
)
def test_whatever_is_heard_every_event_is_one_line_of_strict_json(
    verdicts: list[tuple[str, State, float, str]], confidence: float, text: str
) -> None:
    picture = Picture(DETECTORS)
    picture.receive_confidence(confidence)
    picture.receive_stale(text)
    picture.receive_complaint(text, text)
    for index, (name, state, score, reason) in enumerate(verdicts):
        stamp = START_NS + index * 100_000_000
        picture.receive_verdict(name, Verdict(name, stamp, state, score, 1.0, reason))
    made = event(picture.frame(None)[0])
    lines = made.split(b"\n")
    assert lines[1:] == [b"", b""]
    assert made.startswith(b"data: {")
    json.loads(lines[0][6:], parse_constant=pytest.fail)
