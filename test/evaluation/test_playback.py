"""What a replay publishes, and when; without ROS."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_bags import (
    SPOOF_TEXT,
    START_NS,
    STEP_NS,
    damage_last_chunk,
    flight,
    raw,
    write,
)

from hijack_detect.bags.encoding import encode_sample
from hijack_detect.bags.errors import BagError
from hijack_detect.bags.reader import BagReader, RawMessage, typestore
from hijack_detect.bags.topics import PRESETS
from hijack_detect.evaluation.playback import Outgoing, Playback, moved_stamp, stamp_ns
from hijack_detect.evaluation.playback_parameters import ReplayParameters
from hijack_detect.evaluation.playback_topics import routes
from hijack_detect.evaluation.player import Player, State, Tick
from hijack_detect.spoofing.scenario import ScenarioError, load_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.messages import CONVERTERS
from hijack_detect.streams.samples import FixSample, ImuSample, MagneticSample

HEADED = {
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/NavSatFix",
    "sensor_msgs/msg/MagneticField",
    "geometry_msgs/msg/TwistStamped",
    "mavros_msgs/msg/GPSRAW",
}
PLAIN = {"std_msgs/msg/UInt32", "std_msgs/msg/Bool", "diagnostic_msgs/msg/DiagnosticArray"}
SECOND = 1_000_000_000


class Headed:
    @staticmethod
    def get_fields_and_field_types() -> dict[str, str]:
        return {"header": "std_msgs/Header", "rest": "double"}


class Plain:
    @staticmethod
    def get_fields_and_field_types() -> dict[str, str]:
        return {"data": "uint32"}


def find(msgtype: str) -> object:
    return Headed if msgtype in HEADED else Plain if msgtype in PLAIN else None


@pytest.fixture(scope="session")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("replay") / "flight", flight())


@pytest.fixture(scope="session")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scenario") / "jump.yaml"
    path.write_text(SPOOF_TEXT)
    return path


Open = Callable[..., Playback]


@pytest.fixture
def playback() -> Iterator[Open]:
    """Opens bags, and closes them with the test."""
    made: list[Playback] = []

    def opened(path: Path, **parameters: object) -> Playback:
        made.append(Playback(ReplayParameters(bag=str(path), **parameters), find))
        return made[-1]

    yield opened
    for one in made:
        one.close()


def of_topic(messages: list[Outgoing], topic: str) -> list[Outgoing]:
    return [message for message in messages if message.topic == topic]


# Which topics ------------------------------------------------------------------------------------

IMU, FIX = "sensor_msgs/msg/Imu", "sensor_msgs/msg/NavSatFix"


def test_names_of_mavros_become_ours_and_others_stay() -> None:
    topics = {
        "/mavros/imu/data_raw": IMU,
        "/mavros/global_position/raw/fix": FIX,
        "/mavros/global_position/global": FIX,
        "/mavros/imu/data": IMU,
        "/mavros/gpsstatus/gps1/raw": "mavros_msgs/msg/GPSRAW",
    }
    chosen = routes(topics, PRESETS["mavros"], find, spoofing=False)
    assert {topic: route.topic for topic, route in chosen.published.items()} == {
        "/mavros/imu/data_raw": "imu/data_raw",
        "/mavros/global_position/raw/fix": "gps/fix",
        "/mavros/global_position/global": "mavros/global_position/global",
        "/mavros/imu/data": "mavros/imu/data",
        "/mavros/gpsstatus/gps1/raw": "mavros/gpsstatus/gps1/raw",
    }
    assert chosen.topic_of("fix") == "/mavros/global_position/raw/fix"
    assert not chosen.skipped


@pytest.mark.parametrize(
    ("topic", "msgtype", "reason"),
    [
        ("/hijack_alert", "std_msgs/msg/Bool", "answer of the monitor"),
        ("/drone1/hijack_alert", "std_msgs/msg/Bool", "answer of the monitor"),
        ("/kld/verdict", "diagnostic_msgs/msg/DiagnosticArray", "answer of the monitor"),
        ("/date/delta_ax", "std_msgs/msg/Bool", "answer of the monitor"),
        ("/imu/data", IMU, "answer of the monitor"),
        ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", "running system"),
        ("/clock", "rosgraph_msgs/msg/Clock", "running system"),
        ("/drone1/rosout", "rcl_interfaces/msg/Log", "running system"),
        ("/camera", "nowhere_msgs/msg/Image", "'nowhere_msgs/msg/Image' is not installed"),
        ("/gps/vel", "geometry_msgs/msg/Vector3Stamped", "the input needs geometry_msgs/msg/Twist"),
        ("/a b", "std_msgs/msg/Bool", "no name that can be published"),
        ("/a__b", "std_msgs/msg/Bool", "no name that can be published"),
        ("", "std_msgs/msg/Bool", "no name that can be published"),
        ("//gps/fix", FIX, "'gps/fix' is taken by /gps/fix"),
    ],
)
def test_left_out_with_a_reason(topic: str, msgtype: str, reason: str) -> None:
    topics = {"/imu/data_raw": IMU, "/gps/fix": FIX, topic: msgtype}
    chosen = routes(topics, PRESETS["default"], find, spoofing=False)
    assert set(chosen.published) == {"/imu/data_raw", "/gps/fix"}
    assert reason in chosen.skipped[topic]


@pytest.mark.parametrize("spoofing", [True, False])
def test_a_recorded_ground_truth_is_kept_unless_attacks_are_injected(spoofing: bool) -> None:
    topics = {"/imu/data_raw": IMU, "/gps/fix": FIX, "/spoof_active": "std_msgs/msg/Bool"}
    chosen = routes(topics, PRESETS["default"], find, spoofing=spoofing)
    assert chosen.has_truth is not spoofing


# Which messages ----------------------------------------------------------------------------------


def test_every_message_is_published_byte_for_byte(playback: Open, bag: Path) -> None:
    published = list(playback(bag).messages())
    with BagReader(bag) as reader:
        recorded = list(reader.messages())
    assert [(one.log_ns, "/" + one.topic, one.data) for one in published] == [
        (one.log_ns, one.topic, one.data) for one in recorded
    ]
    assert {one.topic for one in published if one.headed} == {
        "imu/data_raw", "gps/fix", "gps/vel", "truth/fix"
    }  # fmt: skip
    assert {one.spoofed for one in of_topic(published, "gps/fix")} == {False}
    assert {one.spoofed for one in published if one.topic != "gps/fix"} == {None}


def test_attacks_change_fix_and_velocity_and_nothing_else(
    playback: Open, bag: Path, scenario: Path
) -> None:
    published = list(playback(bag, scenario=str(scenario)).messages())
    spoofer = Spoofer(load_scenario(scenario), START_NS)
    with BagReader(bag) as reader:
        for sent, recorded in zip(published, reader.messages(), strict=True):
            name = {"/gps/fix": "fix", "/gps/vel": "velocity"}.get(recorded.topic)
            if name is None:
                assert sent.data == recorded.data
                continue
            sample = CONVERTERS[name](reader.deserialize(recorded))
            reported = getattr(spoofer, name)(sample)
            message = typestore().deserialize_cdr(sent.data, recorded.msgtype)
            assert CONVERTERS[name](message) == reported
            if name == "fix":
                assert sent.spoofed == spoofer.active(sample.stamp_ns)
                assert sent.spoofed == (sent.data != recorded.data)
    active = [one.spoofed for one in of_topic(published, "gps/fix")]
    assert active == [False] * 5 + [True] * 10 + [False] * 6


@pytest.mark.parametrize("start_s", [0.5, 1.0, 2.02, 3.0])
def test_the_same_fix_is_spoofed_alike_wherever_the_replay_starts(
    playback: Open, bag: Path, scenario: Path, start_s: float
) -> None:
    whole = list(playback(bag, scenario=str(scenario)).messages())
    part = list(playback(bag, scenario=str(scenario), start_s=start_s).messages())
    assert part == [one for one in whole if one.log_ns >= START_NS + round(start_s * SECOND)]


def test_start_and_duration_select_a_window(playback: Open, bag: Path) -> None:
    times = [one.log_ns - START_NS for one in playback(bag, start_s=1.0, duration_s=0.5).messages()]
    assert (min(times), max(times)) == (SECOND, 3 * SECOND // 2 - STEP_NS)


def test_every_pass_is_spoofed_alike(playback: Open, bag: Path, scenario: Path) -> None:
    made = playback(bag, scenario=str(scenario))
    assert list(made.messages()) == list(made.messages())


def test_a_message_that_cannot_be_decoded_is_counted_and_named(
    playback: Open, tmp_path: Path
) -> None:
    messages = list(flight(1.0))
    bad = RawMessage("/gps/fix", FIX, START_NS + 7, b"\0\1\0\0broken")
    empty = RawMessage("/imu/data_raw", IMU, START_NS + 8, b"")
    path = write(tmp_path / "bad", [*messages[:5], bad, empty, *messages[5:]])
    made = playback(path)
    assert len(list(made.messages())) == len(messages)
    assert made.rejected.total == 2
    line = made.rejected.lines()[0]
    assert str(path) in line and "/gps/fix" in line and str(START_NS + 7) in line
    assert "malformed sensor_msgs/msg/NavSatFix of 10 bytes" in line


def test_a_type_that_rosbags_does_not_know_passes_with_a_look_at_its_head(
    playback: Open, bag: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = playback(bag)
    route = made.routes.published["/gps/fix"]._replace(msgtype="mavros_msgs/msg/GPSRAW")
    made.routes.published["/gps/fix"] = route  # type: ignore[index]
    good = bytes([0, 1, 0, 0]) + struct.pack("<iI", 5, 6)
    for data in (b"", good[:11], b"\x09\x09" + good[2:], good):
        message = RawMessage("/gps/fix", route.msgtype, START_NS, data)
        monkeypatch.setattr(made.reader, "messages", lambda *_, one=message, **__: iter([one]))
        assert [one.data for one in made.messages()] == ([good] if data == good else [])
    assert made.rejected.total == 3


def test_stamps_that_do_not_increase_are_named_and_published(
    playback: Open, tmp_path: Path
) -> None:
    extra = [
        raw("/mag", MagneticSample(START_NS + stamp, (0.0, 0.0, 0.0)), START_NS + log)
        for log, stamp in ((0, 50), (1, 50), (2, 40), (3, 60))
    ]
    path = write(tmp_path / "stamps", [*flight(1.0), *extra])
    made = playback(path)
    assert len(of_topic(list(made.messages()), "mag")) == 4
    assert made.rejected.counts == {("/mag", "stamp"): 2}
    text = str(made.rejected.first["/mag", "stamp"])
    assert str(path) in text and f"{START_NS + 50} ns: stamp repeats" in text


@pytest.mark.parametrize("with_scenario", [True, False])
def test_an_impossible_fix_passes_as_it_is(
    playback: Open, tmp_path: Path, scenario: Path, with_scenario: bool
) -> None:
    odd = raw("/gps/fix", FixSample(START_NS + 1_100_000_000, 91.0, 11.0, 500.0))
    made = playback(
        write(tmp_path / "odd", [*flight(), odd]), scenario=str(scenario) if with_scenario else ""
    )
    fixes = of_topic(list(made.messages()), "gps/fix")
    assert [one.spoofed for one in fixes if one.data == odd.data] == [with_scenario]
    assert made.rejected.total == with_scenario


def test_errors_at_the_start(playback: Open, bag: Path, scenario: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="'bag' is empty"):
        ReplayParameters()
    with pytest.raises(ValueError, match=r"'start_s' is 5, the bag lasts 4 s"):
        playback(bag, start_s=5.0)
    late = tmp_path / "late.yaml"
    late.write_text(SPOOF_TEXT.replace("3.0", "5.0"))
    with pytest.raises(ScenarioError, match=r"late\.yaml.*end: 5\.0 is outside the flight"):
        playback(bag, scenario=str(late))
    with pytest.raises(BagError, match=r"no sensor_msgs/msg/Imu on topic /mavros/imu/data_raw"):
        playback(bag, preset="mavros")
    blind = [one for one in flight(1.0) if one.msgtype != FIX]
    with pytest.raises(BagError, match=r"blind: the bag has no sensor_msgs/msg/NavSatFix topic"):
        playback(write(tmp_path / "blind", blind))


# Stamps ------------------------------------------------------------------------------------------


@given(st.integers(1, 2**31 * SECOND - 1), st.integers(-(2**60), 2**60))
def test_a_moved_stamp_changes_nothing_else(stamp: int, offset: int) -> None:
    _, data = encode_sample(ImuSample(stamp, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)))
    moved = moved_stamp(data, offset)
    fits = 0 <= stamp + offset < 2**31 * SECOND
    assert stamp_ns(moved) == (stamp + offset if fits else stamp)
    assert moved[:4] + moved[12:] == data[:4] + data[12:]


def test_big_endian_and_unset_stamps() -> None:
    data = bytes([0, 0, 0, 0]) + struct.pack(">iI", 7, 9) + b"rest"
    assert moved_stamp(data, SECOND + 1) == data[:4] + struct.pack(">iI", 8, 10) + b"rest"
    assert moved_stamp(bytes([0, 1, *bytes(10)]), SECOND) == bytes([0, 1, *bytes(10)])


# Times -------------------------------------------------------------------------------------------


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
    made = Playback(parameters, find)
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
    stamps = [stamp_ns(one.data) for one in messages_in(events) if one.topic == "imu/data_raw"]
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
    stamps = [stamp_ns(one.data) for one in messages_in(events) if one.topic == "imu/data_raw"]
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
