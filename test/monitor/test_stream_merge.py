# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The released order depends on stamps alone, whatever arrives when."""

import itertools
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hijack_detect.monitor.graph import StreamMerge
from hijack_detect.streams.silence import SENSOR_PATIENCE_S

MS = 1_000_000
NAMES = ("a", "b", "c")
SILENCE_MS, SKEW_MS, RESTART_MS = 2000, 1000, 5000


@dataclass(frozen=True)
class Stamp:
    stamp_ns: int


Sent = tuple[str, int]
"""Input and stamp in milliseconds."""


def merge_of(*names: str) -> StreamMerge[Stamp]:
    return StreamMerge(dict.fromkeys(names, SENSOR_PATIENCE_S))


def deliver(merge: StreamMerge[Stamp], sent: list[Sent]) -> list[Sent]:
    """Push all in this order; return what was released, in order."""
    released = []
    for name, ms in sent:
        released += [(n, s.stamp_ns // MS) for n, s in merge.push(name, Stamp(ms * MS))]
    return released


def deliver_all(sent: list[Sent]) -> list[Sent]:
    return deliver(merge_of(*NAMES), sent)


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
    """Every sample arrives less than the allowed skew after its stamp, each input in order."""
    ties = draw(st.permutations(NAMES))
    arrivals = []
    for name, stamps in recording.items():
        now = 0
        for index, ms in enumerate(stamps):
            now = max(now, ms + draw(st.integers(0, SKEW_MS - 1)))
            arrivals.append((now, ties.index(name), index, name, ms))
    return [(name, ms) for *_, name, ms in sorted(arrivals)]


def accepted(stamps: list[int]) -> list[tuple[int, bool]]:
    """The documented rule for outages: stamps that count, and whether they are left in."""
    latest: int | None = None
    doubted, joins = -(10**9), -1
    kept = []
    for ms in stamps:
        if latest is not None and ms - latest > SILENCE_MS and ms - doubted > SILENCE_MS:
            doubted = ms
            continue
        if ms - (0 if latest is None else latest) > SILENCE_MS:
            joins = ms + SKEW_MS
        latest = ms
        kept.append((ms, ms >= joins))
    return kept


def left_in(recording: dict[str, list[int]]) -> list[Sent]:
    """What is left in of a whole recording."""
    return in_order(
        [(name, ms) for name, stamps in recording.items() for ms, kept in accepted(stamps) if kept]
    )


def certain(recording: dict[str, list[int]]) -> int:
    """Newest stamp that every input that still lives has passed at the end."""
    lasts = [accepted(stamps)[-1][0] if stamps else -1 for stamps in recording.values()]
    newest = max(lasts)
    return min(last for last in [*lasts, newest] if newest - max(last, 0) <= SILENCE_MS + SKEW_MS)


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


@settings(deadline=None, max_examples=300)
@given(st.data())
def test_to_know_that_nothing_comes_changes_only_how_early_it_is_released(
    data: st.DataObject,
) -> None:
    recording = data.draw(recordings(max_gap_ms=6000))
    sent = data.draw(interleavings(recording))
    plain, told = merge_of(*NAMES), merge_of(*NAMES)
    following = {name: iter(stamps[1:]) for name, stamps in recording.items()}
    usual: list[Sent] = []
    early: list[Sent] = []
    for name, ms in sent:
        usual += deliver(plain, [(name, ms)])
        early += deliver(told, [(name, ms)])
        coming = next(following[name], ms + 1)
        ready = told.advance(name, data.draw(st.integers(ms, coming - 1)) * MS)
        early += [(n, one.stamp_ns // MS) for n, one in ready]
        assert early[: len(usual)] == usual
    # A sample of a returning input can be too late for one and rejoining for the other: left out.
    assert told.refused.total() == plain.refused.total()


def test_an_input_that_will_bring_nothing_holds_nobody_up() -> None:
    merge = merge_of("a", "b")
    assert merge.advance("b", 5 * MS) == []  # it has not begun
    assert deliver(merge, [("a", 0), ("b", 0), ("a", 10)]) == [("a", 0), ("b", 0)]
    assert merge.certain_ns == 0
    assert merge.advance("b", 9 * MS) == []
    assert merge.advance("b", 10 * MS) == [("a", Stamp(10 * MS))]
    assert merge.certain_ns == 10 * MS
    assert deliver(merge, [("a", 20), ("b", 15)]) == [("b", 15)]


@settings(deadline=None)
@given(st.lists(st.tuples(st.sampled_from(NAMES), st.integers(0, 200_000)), max_size=60))
@example([("a", 0), ("a", 0), ("b", 0), ("a", 100_000), ("b", 1), ("a", 1)])
def test_released_stamps_increase_between_restarts_whatever_arrives(sent: list[Sent]) -> None:
    merge: StreamMerge[Stamp] = merge_of(*NAMES)
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


class Forgetful(StreamMerge[Stamp]):
    """Finds out anew with every sample which input is the slowest."""

    def _certain_until(self, heard: Any, stamp: int) -> int:
        self._slowest = None
        return super()._certain_until(heard, stamp)


steps = st.tuples(st.sampled_from(NAMES), st.integers(-3000, 6000) | st.integers(1, 400))


@settings(deadline=None, max_examples=400)
@given(st.lists(steps, max_size=120), st.sampled_from([(3.0,) * 3, (0.5, 3.0, 60.0)]))
def test_the_slowest_input_is_known_as_if_it_were_found_anew(
    moved: list[tuple[str, int]], patience_s: tuple[float, ...]
) -> None:
    """Each input has a clock of its own that runs, stops, leaps and falls behind."""
    waits = dict(zip(NAMES, patience_s, strict=True))
    usual, plain = StreamMerge[Stamp](waits), Forgetful(waits)
    clocks = dict.fromkeys(NAMES, 10_000)
    for name, step in moved:
        clocks[name] = max(0, clocks[name] + step)
        stamp = Stamp(clocks[name] * MS)
        assert usual.push(name, stamp) == plain.push(name, stamp)
        assert usual.refused == plain.refused


@settings(deadline=None, max_examples=400)
@given(st.data())
def test_runs_of_samples_are_taken_as_one_by_one(data: st.DataObject) -> None:
    """Whatever arrives within the skew, with gaps, repeated stamps and jumps among it."""
    recording = data.draw(recordings(max_gap_ms=6000))
    sent = data.draw(interleavings(recording))
    for at in data.draw(st.lists(st.integers(0, max(0, len(sent) - 1)), max_size=3)):
        name, ms = sent[at] if sent else ("a", 0)
        sent.insert(at, (name, max(0, ms + data.draw(st.integers(-20_000, 5_000)))))
    single, together = merge_of(*NAMES), merge_of(*NAMES)
    for name, group in itertools.groupby(sent, key=lambda one: one[0]):
        run = [Stamp(ms * MS) for _, ms in group]
        expected = [one for stamp in run for one in single.push(name, stamp)]
        released = []
        while run:
            taken, ready = together.push_run(name, run)
            released += ready or ([] if taken else together.push(name, run[0]))
            run = run[max(taken, 1) :]
        assert released == expected
        assert together.certain_ns == single.certain_ns
        assert together.refused == single.refused


def test_a_run_ends_before_a_stamp_that_does_not_follow() -> None:
    merge = merge_of("a")
    run = [Stamp(ms * MS) for ms in (10, 20, 30, 25, 40)]
    assert merge.push_run("a", run) == (0, [])  # the first of an input is not simple
    merge.push("a", run[0])
    assert merge.push_run("a", run[1:]) == (2, [("a", run[1]), ("a", run[2])])
    assert merge.push_run("a", run[3:]) == (0, [])
    assert merge.push("a", run[3]) == []
    assert merge.push_run("a", run[4:]) == (1, [("a", run[4])])


def test_equal_stamps_go_in_the_order_of_the_names() -> None:
    sent = [("c", 0), ("b", 0), ("a", 0), ("b", 100), ("a", 100), ("c", 100)]
    expected = [("a", 0), ("b", 0), ("c", 0), ("a", 100), ("b", 100), ("c", 100)]
    assert deliver_all(sent) == expected


def test_a_sample_waits_for_every_living_input() -> None:
    merge: StreamMerge[Stamp] = merge_of("a", "b")
    assert deliver(merge, [("a", 0), ("a", 10)]) == []
    assert deliver(merge, [("b", 5)]) == [("a", 0), ("b", 5)]
    assert deliver(merge, [("b", 10)]) == [("a", 10), ("b", 10)]


def test_an_absent_input_delays_only_the_start() -> None:
    merge: StreamMerge[Stamp] = merge_of("a", "absent")
    assert deliver(merge, [("a", ms) for ms in range(0, 3001, 100)]) == []
    released = deliver(merge, [("a", 3100)])
    assert released == [("a", ms) for ms in range(0, 3101, 100)]
    for ms in range(3200, 10_000, 100):
        assert deliver(merge, [("a", ms)]) == [("a", ms)]
    assert not merge.refused


def test_an_input_that_dies_and_returns() -> None:
    merge: StreamMerge[Stamp] = merge_of("a", "b")
    released = []
    for ms in range(0, 20_000, 100):
        released += deliver(merge, [("a", ms)])
        if ms < 5000 or ms >= 12_000:
            released += deliver(merge, [("b", ms)])
    assert released == in_order(released)
    assert [ms for name, ms in released if name == "a"] == list(range(0, 20_000, 100))
    back = [*range(0, 5000, 100), *range(13_100, 20_000, 100)]
    assert [ms for name, ms in released if name == "b"] == back
    assert merge.refused.total() == 11
    assert merge.refused["b: stamp jumps"] == 1


def test_a_pause_below_the_silence_loses_nothing() -> None:
    merge: StreamMerge[Stamp] = merge_of("a", "b")
    sent = [("b", 0), *(("a", ms) for ms in range(0, 2001, 100)), ("b", 2000), ("a", 2100)]
    assert deliver(merge, sent) == in_order(sent)[:-1]
    assert not merge.refused


def test_repeated_stamps_are_refused_and_counted() -> None:
    merge: StreamMerge[Stamp] = merge_of("a")
    assert deliver(merge, [("a", 1), ("a", 1), ("a", 1), ("a", 2)]) == [("a", 1), ("a", 2)]
    assert dict(merge.refused) == {"a: stamp does not increase": 2}


def test_a_stamp_that_runs_back_a_little_is_refused() -> None:
    merge: StreamMerge[Stamp] = merge_of("a")
    sent = [("a", 10_000), ("a", 10_000 - RESTART_MS), ("a", 10_001)]
    assert deliver(merge, sent) == [("a", 10_000), ("a", 10_001)]
    assert dict(merge.refused) == {"a: stamp does not increase": 1}
    assert not merge.restarted


def test_a_stamp_that_runs_back_a_lot_starts_afresh_for_that_call_only() -> None:
    merge: StreamMerge[Stamp] = merge_of("a", "b")
    deliver(merge, [("a", 10_000), ("b", 10_000), ("a", 10_500)])
    merge.push("a", Stamp(0))
    assert not merge.restarted
    assert merge.refused["a: stamp jumps"] == 1
    merge.push("a", Stamp(100 * MS))
    assert merge.restarted
    released = deliver(merge, [("b", 100), ("a", 200), ("b", 200)])
    assert not merge.restarted
    assert released == [("a", 100), ("b", 100), ("a", 200), ("b", 200)]


@pytest.mark.parametrize(("name", "restarts"), [("imu", True), ("attitude", True), ("fix", False)])
def test_the_imu_tells_that_a_clock_was_set_back_a_little(name: str, restarts: bool) -> None:
    merge = merge_of(name, "b")
    deliver(merge, [(name, 10_000), ("b", 10_000)])
    sent = [(name, 9_850), (name, 9_855), ("b", 9_860), (name, 9_865)]
    assert bool(deliver(merge, sent)) is restarts


def test_an_imu_sample_that_was_overtaken_is_refused() -> None:
    merge = merge_of("imu")
    sent = [("imu", ms) for ms in (10_000, 10_010, 10_005, 9_950, 9_955, 10_015)]
    assert deliver(merge, sent) == [("imu", 10_000), ("imu", 10_010), ("imu", 10_015)]


def test_one_stamp_far_in_the_past_changes_nothing() -> None:
    merge = merge_of("a", "b")
    deliver(merge, [("a", 10_000), ("b", 10_000), ("a", 0)])
    assert deliver(merge, [("a", 10_100), ("b", 10_100)]) == [("a", 10_100), ("b", 10_100)]
    assert not merge.restarted
    assert dict(merge.refused) == {"a: stamp jumps": 1}


def test_a_larger_patience_changes_nothing_but_the_waiting() -> None:
    sent = [("a", ms) for ms in range(0, 8000, 100)] + [("b", ms) for ms in range(0, 8000, 100)]
    patient: StreamMerge[Stamp] = StreamMerge({"a": 60.0, "b": 60.0})
    assert deliver(patient, sent) == in_order(sent)
    assert deliver(merge_of("a", "b"), sent) != in_order(sent)


def test_a_looped_recording_is_released_twice() -> None:
    """Of the second round the first sample of each input only announces it."""
    sent = [(name, ms) for ms in range(0, 10_000, 100) for name in ("a", "b", "c")]
    released = deliver_all(sent + sent)
    assert released == sent + sent[3:]


@pytest.mark.parametrize("ahead_ms", [4000, 6000, 3_600_000, 10**12])
@pytest.mark.parametrize("bad", ["a", "b"])
def test_one_stamp_in_the_future_never_silences_an_input(ahead_ms: int, bad: str) -> None:
    merge: StreamMerge[Stamp] = merge_of("a", "b")
    late = []
    for ms in range(0, 20_000, 100):
        for name in ("a", "b"):
            wrong = name == bad and ms == 5000
            released = deliver(merge, [(name, ms + (ahead_ms if wrong else 0))])
            late += [one for one in released if ms >= 12_000]
    assert {("a", ms) for ms in range(12_500, 19_500, 100)} <= set(late)
    assert {("b", ms) for ms in range(12_500, 19_500, 100)} <= set(late)
    assert merge.refused == {f"{bad}: stamp jumps": 1}


def test_stamps_from_zero() -> None:
    """A simulated clock starts at 0; the first stamp must not count as missing."""
    merge: StreamMerge[Stamp] = merge_of("a", "b")
    assert [n for n, _ in merge.push("a", Stamp(0))] == []
    assert [n for n, _ in merge.push("b", Stamp(0))] == ["a", "b"]
    assert [n for n, _ in merge.push("a", Stamp(1))] == []
    assert [n for n, _ in merge.push("b", Stamp(1))] == ["a", "b"]
    assert merge.push("a", Stamp(0)) == []
    assert merge.refused["a: stamp does not increase"] == 1


def test_an_input_that_is_about_to_join_again_holds_nothing_up() -> None:
    """Found by Hypothesis: what is left out of it anyway need not be waited for."""
    early = [("a", 0), ("b", 0), ("b", 2050), ("c", 2050), ("b", 2950), ("c", 3050)]
    late = [*early[:4], ("c", 3050), ("b", 2950)]
    assert deliver_all(early) == deliver_all(late) == [("a", 0), ("b", 0), ("c", 3050)]
