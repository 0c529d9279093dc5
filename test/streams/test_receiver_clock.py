# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A step of the receiver's time is taken off; holes, delays and set clocks are left alone."""

from __future__ import annotations

import dataclasses
import random
from functools import lru_cache
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hijack_detect.streams.receiver_clock import ReceiverClock
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    ImuSample,
    SatelliteSample,
    VelocitySample,
)

ZERO = (0.0, 0.0, 0.0)
STEP_AT_S, LAST_S = 20.0, 40.0
STEPS_S = (0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 18.0, 37.0, 3600.0, 604800.0, -0.5, -1.0, -3.0, -18.0)
START_NS = 1_700_000_000 * NANOSECONDS

Sent = list[tuple[str, Any, int]]
"""Input, sample as it is stamped, and the stamp that it should have."""


def nanoseconds(seconds: float) -> int:
    return round(seconds * NANOSECONDS)


def flight(step_s: float = 0.0, at_s: float = STEP_AT_S, period_s: float = 0.2) -> Sent:
    """IMU at 50 Hz; the receiver's time steps by `step_s`."""
    sent: Sent = []
    for tick in range(round(LAST_S * 50)):
        now_s = tick / 50
        true_ns = START_NS + nanoseconds(now_s)
        sent.append(("imu", ImuSample(true_ns, ZERO, ZERO), true_ns))
        if tick % round(period_s * 50) == 0:
            shown_ns = true_ns + nanoseconds(step_s if now_s >= at_s else 0.0)
            sent.append(("fix", FixSample(shown_ns, now_s, 0.0, 0.0), true_ns))
            sent.append(("velocity", VelocitySample(shown_ns, (now_s, 0.0, 0.0)), true_ns))
            sent.append(("satellites", SatelliteSample(shown_ns, 9), true_ns))
    return sent


def delivered(sent: Sent, jitter_s: float, seed: int) -> Sent:
    """Every sample late by up to `jitter_s`, each input in order."""
    rng, last = random.Random(seed), dict[str, int]()
    arrivals = []
    for index, (name, _, true_ns) in enumerate(sent):
        after_ns = last.get("fix" if name == "satellites" else name, 0)
        last[name] = max(true_ns + nanoseconds(rng.uniform(0.0, jitter_s)), after_ns)
        arrivals.append((last[name], index))
    return [sent[index] for _, index in sorted(arrivals)]


@lru_cache
def with_truth(kind: type[Any]) -> type[Any]:
    """A sample of a kind that keeps the stamp that it should have."""
    truth = [("true_ns", int, 0)]
    return dataclasses.make_dataclass(kind.__name__, truth, bases=(kind,), frozen=True, slots=True)


def known(sample: Any, true_ns: int) -> Any:
    """A sample with the stamp that it should have."""
    given = {field.name: getattr(sample, field.name) for field in dataclasses.fields(sample)}
    return with_truth(type(sample))(**given, true_ns=true_ns)


def let_through(sent: Sent) -> tuple[list[tuple[str, Any, int]], ReceiverClock]:
    clock, passed = ReceiverClock(), list[tuple[str, Any, int]]()
    sources = {}
    for name, sample, true_ns in sent:
        one = known(sample, true_ns)
        sources[id(one)] = one, sample
        for of, found in clock.push(name, one):
            passed.append((of, sources.get(id(found), (None, found))[1], found.true_ns))
    return passed, clock


def errors_s(passed: list[tuple[str, Any, int]]) -> set[float]:
    return {(sample.stamp_ns - true_ns) / NANOSECONDS for _, sample, true_ns in passed}


@pytest.mark.parametrize("step_s", STEPS_S)
@pytest.mark.parametrize("period_s", [0.1, 0.2, 1.0])
def test_a_step_is_taken_off_from_its_first_sample_on(step_s: float, period_s: float) -> None:
    if step_s == -period_s:
        pytest.skip("the stamp before it repeats, as a copy's would")
    passed, clock = let_through(flight(step_s, period_s=period_s))
    assert errors_s(passed) == {0.0}
    assert len(passed) == len(flight(step_s, period_s=period_s))
    assert [text.split(" s;")[0] for text in clock.findings] == [
        f"{name}: the receiver's time stepped by {step_s:+.1f}" for name in ("fix", "velocity")
    ]
    for name, sample, true_ns in passed:
        if name == "fix":
            stepped = true_ns - START_NS >= nanoseconds(STEP_AT_S)
            assert sample.clock_offset_ns == (nanoseconds(step_s) if stepped else 0)


@settings(deadline=None, max_examples=15)
@given(
    st.sampled_from([s for s in STEPS_S if abs(s) >= 2.0]),
    st.integers(0, 1000),
    st.integers(0, 1000),
)
def test_every_delivery_leads_to_the_same_stamps(step_s: float, one: int, other: int) -> None:
    sent = flight(step_s)
    first, second = (
        {(name, true): sample for name, sample, true in let_through(delivered(sent, 0.3, seed))[0]}
        for seed in (one, other)
    )
    assert first == second
    assert {sample.stamp_ns - true for (_, true), sample in first.items()} == {0}


@settings(deadline=None, max_examples=25)
@given(
    st.sampled_from(["all", "gps", "fix", "imu"]),
    st.floats(0.3, 10.0),
    st.floats(3.0, 35.0),
    st.floats(0.0, 0.1),
    st.integers(0, 1000),
)
@example("all", 4.0, 17.0, 0.0, 0)
@example("gps", 0.5, 17.0, 0.1, 0)
def test_a_hole_changes_nothing(
    which: str, length_s: float, at_s: float, jitter_s: float, seed: int
) -> None:
    lost = {"all": ("imu", "fix", "velocity", "satellites"), "gps": ("fix", "velocity")}
    sent = [
        (name, sample, true)
        for name, sample, true in flight()
        if name not in lost.get(which, (which,))
        or not at_s <= (true - START_NS) / NANOSECONDS < at_s + length_s
    ]
    arrived = delivered(sent, jitter_s, seed)
    passed, clock = let_through(arrived)
    assert clock.findings == []
    assert not clock.refused
    assert all(any(sample is one for _, one, _ in arrived[-400:]) for _, sample, _ in passed[-100:])
    assert errors_s(passed) == {0.0}
    assert len(passed) >= len(arrived) - 3 * 13  # what came last may still be held


@pytest.mark.parametrize("set_s", [-3600.0, -4.0, -0.3, 1.0, 37.0])
def test_a_clock_behind_all_stamps_that_is_set_is_left_alone(set_s: float) -> None:
    sent = []
    for name, _, true in flight():
        moved = nanoseconds(set_s if (true - START_NS) >= nanoseconds(STEP_AT_S) else 0.0)
        kinds: dict[str, Any] = {"imu": ImuSample(true + moved, ZERO, ZERO)}
        kinds["fix"] = FixSample(true + moved, 0.0, 0.0, 0.0)
        kinds["velocity"] = VelocitySample(true + moved, ZERO)
        kinds["satellites"] = SatelliteSample(true + moved, 9)
        sent.append((name, kinds[name], true + moved))
    passed, clock = let_through(sent)
    assert clock.findings == []
    assert errors_s(passed) == {0.0}


@pytest.mark.parametrize("off_s", [18.0, -18.0, 3.0, 37.0, -3600.0, 604800.0])
def test_a_constant_offset_is_found_from_arrival(off_s: float) -> None:
    passed, clock = let_through(flight(off_s, at_s=-1.0))
    assert errors_s(passed) == {0.0}
    assert [text.split(":")[0] for text in clock.findings] == ["fix", "velocity"]


def test_a_step_after_an_outage_of_the_receiver() -> None:
    """What came while it was found out is left out: no merge waits for so long."""
    sent = [
        one
        for one in flight(18.0)
        if one[0] == "imu" or not 16.0 <= (one[2] - START_NS) / NANOSECONDS < STEP_AT_S
    ]
    passed, clock = let_through(sent)
    assert errors_s(passed) == {0.0}
    assert 0 < clock.refused["fix: stamp unclear while the receiver's time stepped"] < 10


def test_one_broken_stamp_is_no_step() -> None:
    sent = flight()
    at = next(i for i, one in enumerate(sent) if one[0] == "fix" and i > 900)
    broken = FixSample(sent[at][2] + 18 * NANOSECONDS, 0.0, 0.0, 0.0)
    sent[at] = ("fix", broken, broken.stamp_ns)
    passed, clock = let_through(sent)
    assert clock.findings == []
    assert {id(one[1]) for one in passed} == {id(one[1]) for one in sent}


def test_without_an_imu_everything_goes_through() -> None:
    sent = [one for one in flight(18.0) if one[0] != "imu"]
    passed, clock = let_through(sent)
    assert [one[1] for one in passed] == [one[1] for one in sent]
    assert clock.findings == []


def test_runs_are_taken_as_one_by_one() -> None:
    sent = flight(-5.0)
    clock, alone = ReceiverClock(), ReceiverClock()
    by_runs = []
    run: list[Any] = []
    for index, (name, sample, _) in enumerate(sent):
        run.append(sample)
        if index + 1 == len(sent) or sent[index + 1][0] != name:
            by_runs += [(of, one) for of, some in clock.push_run(name, run) for one in some]
            run = []
    assert by_runs == [one for name, sample, _ in sent for one in alone.push(name, sample)]
