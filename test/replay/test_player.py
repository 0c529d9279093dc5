# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""When a replay publishes; with clocks that the test moves."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_bags import (
    START_NS,
    STEP_NS,
    damage_last_chunk,
    flight,
    raw,
    stand_in,
    write,
)

from hijack_detect.replay.playback import Outgoing, Playback, ReplayParameters
from hijack_detect.replay.player import Player, State, Tick
from hijack_detect.streams.cdr import stamp_from_bytes
from hijack_detect.streams.samples import MagneticSample

SECOND = 1_000_000_000
Open = Callable[..., Playback]


class FakeTime:
    """Both clocks of a player."""

    def __init__(self) -> None:
        self.now = 77 * SECOND
        self.wall_ns = 1_800_000_000 * SECOND

    def pass_by(self, seconds: float) -> None:
        self.now += round(seconds * SECOND)
        self.wall_ns += round(seconds * SECOND)


def player_of(playback: Playback, parameters: ReplayParameters) -> tuple[Player, FakeTime]:
    clock = FakeTime()
    player = Player(
        playback,
        parameters,
        monotonic_ns=lambda: clock.now,
        wall_ns=lambda: clock.wall_ns,
    )
    return player, clock


Make = Callable[..., tuple[Player, FakeTime]]


@pytest.fixture
def make(bag: Path, playback: Open) -> Make:
    def made(**parameters: object) -> tuple[Player, FakeTime]:
        made = playback(bag, **parameters)
        return player_of(made, ReplayParameters(bag=str(bag), **parameters))

    return made


def taken(player: Player) -> list[Tick | Outgoing]:
    """Everything that is due now."""
    events = []
    while (event := player.due()) is not None:
        player.advance(event)
        events.append(event)
    return events


def run_through(player: Player, clock: FakeTime, step_s: float = 0.001) -> list[Tick | Outgoing]:
    events = []
    while player.state is not State.ENDED:
        events += taken(player)
        clock.pass_by(step_s)
    return events


def messages_in(events: list[Tick | Outgoing]) -> list[Outgoing]:
    return [event for event in events if isinstance(event, Outgoing)]


@pytest.mark.parametrize("rate", [0.5, 1.0, 20.0])
def test_each_message_is_due_at_its_time_and_not_before(make: Make, rate: float) -> None:
    player, clock = make(rate=rate, clock_hz=0.0)
    assert taken(player) == []
    player.play()
    began, times = clock.now, []
    while player.state is not State.ENDED:
        for event in taken(player):
            assert isinstance(event, Outgoing)
            times.append((event.log_ns - START_NS, clock.now - began))
        wait_s = player.wait_s()
        clock.pass_by(wait_s if wait_s < 1e9 else 0.0)
    assert len(times) == 201 + 4 * 21
    assert all(abs(log - rate * now) <= 2 * max(rate, 1.0) for log, now in times)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("wait"), st.floats(0.0, 2.0)),
            st.tuples(st.just("rate"), st.floats(0.1, 50.0)),
            st.tuples(st.sampled_from(["pause", "play", "step", "step"]), st.just(0.0)),
        ),
        max_size=25,
    )
)
def test_whatever_is_asked_every_message_comes_once_and_in_order(
    bag: Path, actions: list[tuple[str, float]]
) -> None:
    parameters = ReplayParameters(bag=str(bag), restamp=True)
    made = Playback(parameters, stand_in)
    player, clock = player_of(made, parameters)
    events: list[Tick | Outgoing] = []
    for action, value in actions:
        if action == "wait":
            clock.pass_by(value)
        elif action == "rate":
            player.set_rate(value)
        else:
            getattr(player, action)()
        new = taken(player)
        if action == "step":
            assert len(messages_in(new)) >= (player.state is State.PAUSED)
        events += new
    player.play()
    events += run_through(player, clock, 0.1)
    assert [one.log_ns for one in messages_in(events)] == [one.log_ns for one in made.messages()]
    ticks = [event.ns for event in events if isinstance(event, Tick)]
    assert ticks == sorted(ticks)
    stamps = [
        stamp_from_bytes(one.data) for one in messages_in(events) if one.topic == "imu/data_raw"
    ]
    assert all(later - earlier >= STEP_NS for earlier, later in itertools.pairwise(stamps))
    made.close()


@pytest.mark.parametrize(("clock_hz", "step_s"), [(100.0, 0.001), (100.0, 0.3), (30.0, 0.004)])
def test_the_clock_is_never_behind_and_at_most_a_period_ahead(
    make: Make, clock_hz: float, step_s: float
) -> None:
    player, clock = make(clock_hz=clock_hz)
    player.play()
    events = run_through(player, clock, step_s)
    ticks = [event.ns for event in events if isinstance(event, Tick)]
    assert len(set(ticks)) == len(ticks) and ticks == sorted(ticks)
    latest = 0
    for event in events:
        if isinstance(event, Tick):
            latest = event.ns
        else:
            assert event.log_ns <= latest <= event.log_ns + round(SECOND / clock_hz)
    if step_s == 0.001:
        assert len(ticks) == 4 * clock_hz + 1


def test_pause_holds_the_position_and_resume_goes_on_from_it(make: Make) -> None:
    player, clock = make(clock_hz=0.0)
    player.play()
    clock.pass_by(1.0)
    taken(player)
    player.pause()
    clock.pass_by(5.0)
    assert taken(player) == []
    assert player.position_s == pytest.approx(1.0)
    assert player.where() == "paused at 1.000 s of 4.000 s"
    player.play()
    assert taken(player) == []
    clock.pass_by(0.02)
    assert [one.log_ns - START_NS for one in messages_in(taken(player))] == [SECOND + STEP_NS]


def test_step_publishes_one_message(make: Make) -> None:
    player, clock = make(start_paused=True)
    clock.pass_by(9.0)
    assert taken(player) == []
    assert player.step() == f"imu/data_raw stamped {START_NS} ns"
    assert [one.topic for one in messages_in(taken(player))] == ["imu/data_raw"]
    assert [player.step(), player.step()] == [f"gps/fix stamped {START_NS} ns"] * 2
    assert [one.topic for one in messages_in(taken(player))] == ["gps/fix", "gps/vel"]
    player.play()
    assert player.step() == ""


def test_a_late_player_says_so_and_keeps_everything(make: Make) -> None:
    player, clock = make(rate=2.0, clock_hz=0.0)
    player.play()
    clock.pass_by(1.5)
    assert player.behind_s == pytest.approx(1.5)
    assert player.position_s == 0.0
    assert messages_in(taken(player))[-1].log_ns == START_NS + 3 * SECOND
    assert player.behind_s == 0.0
    assert player.report()["published gps/fix"] == "16"


def test_an_event_comes_again_until_it_was_sent(make: Make) -> None:
    player, clock = make()
    player.play()
    clock.pass_by(0.1)
    assert isinstance(player.due(), Tick)
    assert player.due() == player.due()


def test_loop_begins_again(make: Make) -> None:
    player, clock = make(loop=True, duration_s=1.0, clock_hz=0.0)
    player.play()
    sent: list[Outgoing] = []
    while player.passes < 4:
        sent += messages_in(taken(player))
        clock.pass_by(0.01)
    one_pass = 50 + 4 * 5
    assert sent[:one_pass] == sent[one_pass : 2 * one_pass] == sent[2 * one_pass : 3 * one_pass]


@pytest.mark.parametrize("rate", [0.5, 10.0])
def test_restamped_loops_never_run_backwards(make: Make, rate: float) -> None:
    player, clock = make(loop=True, duration_s=1.0, restamp=True, rate=rate)
    clock.pass_by(3.0)
    player.play()
    now, events = clock.wall_ns, []
    while player.passes < 4:
        events += taken(player)
        clock.pass_by(0.01)
    stamps = [
        stamp_from_bytes(one.data) for one in messages_in(events) if one.topic == "imu/data_raw"
    ]
    assert stamps[0] == now
    assert all(earlier < later for earlier, later in itertools.pairwise(stamps))
    assert [b - a for a, b in itertools.pairwise(stamps[:50])] == [STEP_NS] * 49
    ticks = [event.ns for event in events if isinstance(event, Tick)]
    assert ticks == sorted(ticks)


def test_nothing_in_the_window_is_an_error(playback: Open, tmp_path: Path) -> None:
    late = raw("/mag", MagneticSample(START_NS + 9 * SECOND, (0.0, 0.0, 0.0)))
    path = write(tmp_path / "gap", [*flight(1.0), late])
    window = {"start_s": 2.0, "duration_s": 1.0}
    with pytest.raises(ValueError, match="no message between start and end"):
        player_of(playback(path, **window), ReplayParameters(bag=str(path), **window))


def test_a_bag_that_turns_out_damaged_ends_the_replay(playback: Open, tmp_path: Path) -> None:
    path = write(tmp_path / "damaged", flight(60.0))
    damage_last_chunk(path)
    player, clock = player_of(playback(path), ReplayParameters(bag=str(path), loop=True))
    player.play()
    sent = messages_in(run_through(player, clock, 1.0))
    assert len(sent) > 1000
    assert player.state is State.ENDED
    assert str(path) in player.error
