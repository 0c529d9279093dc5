"""The released order depends on stamps alone, whatever arrives when."""

from dataclasses import dataclass

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hijack_detect.streams.merge import StreamMerge

MS = 1_000_000
NAMES = ("a", "b", "c")
SILENCE_MS, SKEW_MS, RESTART_MS = 2000, 1000, 5000


@dataclass(frozen=True)
class Stamp:
    stamp_ns: int


Sent = tuple[str, int]
"""Input and stamp in milliseconds."""


def deliver(merge: StreamMerge[Stamp], sent: list[Sent]) -> list[Sent]:
    """Push all in this order; return what was released, in order."""
    released = []
    for name, ms in sent:
        released += [(n, s.stamp_ns // MS) for n, s in merge.push(name, Stamp(ms * MS))]
    return released


def deliver_all(sent: list[Sent]) -> list[Sent]:
    return deliver(StreamMerge(NAMES), sent)


def in_order(sent: list[Sent]) -> list[Sent]:
    return sorted(sent, key=lambda one: (one[1], NAMES.index(one[0])))


@st.composite
def recordings(draw: st.DrawFn, max_gap_ms: int) -> dict[str, list[int]]:
    """Stamps of each input; `a` starts at 0, and any other input may be absent."""
    gaps = st.lists(st.integers(1, max_gap_ms // 50), max_size=25)
    recording = {}
    for name in NAMES:
        steps = draw(gaps)
        stamps, now = [], 0 if name == "a" else draw(st.integers(0, 60)) * 50
        for step in steps:
            stamps.append(now)
            now += step * 50
        recording[name] = stamps
    recording["a"] = recording["a"] or [0]
    return recording


@st.composite
def interleavings(draw: st.DrawFn, recording: dict[str, list[int]]) -> list[Sent]:
    """Every sample arrives less than the allowed skew after its stamp, each input in order.

    The first sample of the recording arrives first.
    """
    ties = draw(st.permutations(NAMES))
    arrivals = [(0, -1, 0, "a", 0)]
    for name, stamps in recording.items():
        now = 0
        for index, ms in enumerate(stamps):
            now = max(now, ms + draw(st.integers(0, SKEW_MS - 1)))
            if (name, index) != ("a", 0):
                arrivals.append((now, ties.index(name), index, name, ms))
    return [(name, ms) for *_, name, ms in sorted(arrivals)]


def left_in(recording: dict[str, list[int]]) -> list[Sent]:
    """The documented rule for outages, computed from the whole recording at once."""
    kept = []
    for name, stamps in recording.items():
        before, joins = 0, -1
        for ms in stamps:
            if ms - before > SILENCE_MS:
                joins = ms + SKEW_MS
            before = ms
            if ms >= joins:
                kept.append((name, ms))
    return in_order(kept)


def certain(recording: dict[str, list[int]]) -> int:
    """Newest stamp that every input that still lives has passed at the end."""
    newest = max(max(stamps) for stamps in recording.values() if stamps)
    until = newest
    for stamps in recording.values():
        last = stamps[-1] if stamps else -1
        if newest - max(last, 0) <= SILENCE_MS + SKEW_MS:
            until = min(until, last)
    return until


@settings(deadline=None, max_examples=300)
@given(st.data())
def test_without_outages_the_output_is_the_sorted_input(data: st.DataObject) -> None:
    recording = data.draw(recordings(max_gap_ms=SILENCE_MS))
    merged = in_order([(name, ms) for name, stamps in recording.items() for ms in stamps])
    if any(stamps and stamps[0] > SILENCE_MS for stamps in recording.values()):
        return
    released = deliver_all(data.draw(interleavings(recording)))
    assert released == merged[: len(released)]
    assert len(released) >= len([one for one in merged if one[1] <= certain(recording)])


@settings(deadline=None, max_examples=400)
@given(st.data())
def test_output_is_independent_of_the_interleaving(data: st.DataObject) -> None:
    recording = data.draw(recordings(max_gap_ms=6000))
    first = deliver_all(data.draw(interleavings(recording)))
    second = deliver_all(data.draw(interleavings(recording)))
    assert first == second


@settings(deadline=None, max_examples=300)
@given(st.data())
def test_outages_leave_out_the_first_second_after_the_return(data: st.DataObject) -> None:
    recording = data.draw(recordings(max_gap_ms=6000))
    released = deliver_all(data.draw(interleavings(recording)))
    expected = left_in(recording)
    assert released == expected[: len(released)]
    assert len(released) >= len([one for one in expected if one[1] <= certain(recording)])


@settings(deadline=None)
@given(st.lists(st.tuples(st.sampled_from(NAMES), st.integers(0, 200_000)), max_size=60))
@example([("a", 0), ("a", 0), ("b", 0), ("a", 100_000), ("b", 1), ("a", 1)])
def test_released_stamps_increase_between_restarts_whatever_arrives(sent: list[Sent]) -> None:
    merge: StreamMerge[Stamp] = StreamMerge(NAMES)
    last: dict[str, int] = {}
    newest = -1
    for name, ms in sent:
        released = merge.push(name, Stamp(ms * MS))
        if merge.restarted:
            last, newest = {}, -1
        for source, sample in released:
            assert sample.stamp_ns >= newest
            assert sample.stamp_ns > last.get(source, -1)
            newest = last[source] = sample.stamp_ns


def test_equal_stamps_go_in_the_order_of_the_names() -> None:
    sent = [("c", 0), ("b", 0), ("a", 0), ("b", 100), ("a", 100), ("c", 100)]
    expected = [("a", 0), ("b", 0), ("c", 0), ("a", 100), ("b", 100), ("c", 100)]
    assert deliver_all(sent) == expected


def test_a_sample_waits_for_every_living_input() -> None:
    merge: StreamMerge[Stamp] = StreamMerge(("a", "b"))
    assert deliver(merge, [("a", 0), ("a", 10)]) == []
    assert deliver(merge, [("b", 5)]) == [("a", 0), ("b", 5)]
    assert deliver(merge, [("b", 10)]) == [("a", 10), ("b", 10)]


def test_an_absent_input_delays_only_the_start() -> None:
    merge: StreamMerge[Stamp] = StreamMerge(("a", "absent"))
    assert deliver(merge, [("a", ms) for ms in range(0, 3001, 100)]) == []
    released = deliver(merge, [("a", 3100)])
    assert released == [("a", ms) for ms in range(0, 3101, 100)]
    for ms in range(3200, 10_000, 100):
        assert deliver(merge, [("a", ms)]) == [("a", ms)]
    assert not merge.refused


def test_an_input_that_dies_and_returns() -> None:
    merge: StreamMerge[Stamp] = StreamMerge(("a", "b"))
    released = []
    for ms in range(0, 20_000, 100):
        released += deliver(merge, [("a", ms)])
        if ms < 5000 or ms >= 12_000:
            released += deliver(merge, [("b", ms)])
    assert released == in_order(released)
    assert [ms for name, ms in released if name == "a"] == list(range(0, 20_000, 100))
    back = [*range(0, 5000, 100), *range(13_000, 20_000, 100)]
    assert [ms for name, ms in released if name == "b"] == back
    assert merge.refused.total() == 10
    assert merge.refused["b: rejoining after an outage"] >= 9


def test_a_pause_below_the_silence_loses_nothing() -> None:
    merge: StreamMerge[Stamp] = StreamMerge(("a", "b"))
    sent = [("b", 0), *(("a", ms) for ms in range(0, 2001, 100)), ("b", 2000), ("a", 2100)]
    assert deliver(merge, sent) == in_order(sent)[:-1]
    assert not merge.refused


def test_repeated_stamps_are_refused_and_counted() -> None:
    merge: StreamMerge[Stamp] = StreamMerge(("a",))
    assert deliver(merge, [("a", 1), ("a", 1), ("a", 1), ("a", 2)]) == [("a", 1), ("a", 2)]
    assert dict(merge.refused) == {"a: stamp does not increase": 2}


def test_a_stamp_that_runs_back_a_little_is_refused() -> None:
    merge: StreamMerge[Stamp] = StreamMerge(("a",))
    sent = [("a", 10_000), ("a", 10_000 - RESTART_MS), ("a", 10_001)]
    assert deliver(merge, sent) == [("a", 10_000), ("a", 10_001)]
    assert dict(merge.refused) == {"a: stamp does not increase": 1}
    assert not merge.restarted


def test_a_stamp_that_runs_back_a_lot_starts_afresh_for_that_call_only() -> None:
    merge: StreamMerge[Stamp] = StreamMerge(("a", "b"))
    deliver(merge, [("a", 10_000), ("b", 10_000), ("a", 10_500)])
    merge.push("a", Stamp(0))
    assert merge.restarted
    assert merge.refused["a: clock ran backwards, started afresh"] == 1
    released = deliver(merge, [("b", 0), ("a", 100), ("b", 100)])
    assert not merge.restarted
    assert released == [("a", 0), ("b", 0), ("a", 100), ("b", 100)]


def test_a_looped_recording_is_released_twice() -> None:
    sent = [(name, ms) for ms in range(0, 10_000, 100) for name in ("a", "b", "c")]
    released = deliver_all(sent + sent)
    assert released == sent + sent


@pytest.mark.parametrize("ahead_ms", [4000, 6000, 3_600_000, 10**12])
@pytest.mark.parametrize("bad", ["a", "b"])
def test_one_stamp_in_the_future_never_silences_an_input(ahead_ms: int, bad: str) -> None:
    merge: StreamMerge[Stamp] = StreamMerge(("a", "b"))
    late = []
    for ms in range(0, 20_000, 100):
        for name in ("a", "b"):
            wrong = name == bad and ms == 5000
            released = deliver(merge, [(name, ms + (ahead_ms if wrong else 0))])
            late += [one for one in released if ms >= 12_000]
    assert {("a", ms) for ms in range(12_500, 19_500, 100)} <= set(late)
    assert {("b", ms) for ms in range(12_500, 19_500, 100)} <= set(late)


def test_stamps_from_zero() -> None:
    """A simulated clock starts at 0; the first stamp must not count as missing."""
    merge: StreamMerge[Stamp] = StreamMerge(("a", "b"))
    assert [n for n, _ in merge.push("a", Stamp(0))] == []
    assert [n for n, _ in merge.push("b", Stamp(0))] == ["a", "b"]
    assert [n for n, _ in merge.push("a", Stamp(1))] == []
    assert [n for n, _ in merge.push("b", Stamp(1))] == ["a", "b"]
    assert merge.push("a", Stamp(0)) == []
    assert merge.refused["a: stamp does not increase"] == 1
