# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The Kullback-Leibler detector against sums done by hand with SciPy, and what it must not do."""

from __future__ import annotations

import dataclasses
import itertools
import math
import tracemalloc
from collections.abc import Callable, Iterable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import kl_div, rel_entr
from scipy.stats import poisson

from hijack_detect.detectors.kld import CODES, DistributionSeries, KldDetector, RowSeries
from hijack_detect.detectors.kld_values import NAMES, Changes, KldParameters, Table2Values
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.monitor.graph import Stage
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.streams.samples import FixSample, GpsSample, SatelliteSample, VelocitySample

SECOND = 10**9
N = 10
M_PER_DEG = 111_194.9
FAITHFUL = policy_parameters("paper").of(KldParameters)
Sample = tuple[str, GpsSample]


def flight(
    seconds: float,
    *,
    hz: float = 5.0,
    velocity: Callable[[float], tuple[float, float, float]] = lambda t: (0.0, 8.0, 0.0),
    satellites: Callable[[int], int] | None = lambda index: 12,
    change: Callable[[int, FixSample], FixSample] = lambda index, fix: fix,
    noise_m: float = 0.02,
    with_velocity: bool = True,
) -> list[Sample]:
    """Samples of a receiver on a vehicle that flies with a velocity (m/s, ENU)."""
    rng = np.random.default_rng(0)
    east = north = up = 0.0
    samples: list[Sample] = []
    for index in range(round(seconds * hz)):
        t = index / hz
        u, v, w = velocity(t)
        east, north, up = east + u / hz, north + v / hz, up + w / hz
        stamp = 1_700_000_000 * SECOND + round(t * SECOND)
        x, y, z = noise_m * rng.normal(size=3)
        place = (48.0 + (north + y) / M_PER_DEG, 11.0 + (east + x) / M_PER_DEG / math.cos(0.8378))
        if with_velocity:
            samples.append(("velocity", VelocitySample(stamp, (u, v, w))))
        if satellites is not None:
            samples.append(("satellites", SatelliteSample(stamp, satellites(index))))
        samples.append(("fix", change(index, FixSample(stamp, *place, 520.0 + up + z))))
    return samples


def verdicts(samples: Iterable[Sample], parameters: KldParameters) -> list[Verdict]:
    stage = Stage(lambda: KldDetector(parameters))
    return [verdict for name, sample in samples for verdict in stage.push(name, sample)]


def states(found: Iterable[Verdict]) -> list[State]:
    return [state for state, _ in itertools.groupby(verdict.state for verdict in found)]


# Series


def test_row_series_is_the_papers_sum() -> None:
    rng = np.random.default_rng(5)
    counts = rng.integers(0, 40, size=60).astype(float)
    series = RowSeries(N)
    found = [series.add(count) for count in counts]
    means = np.convolve(counts, np.ones(N) / N, "valid")
    pmf = poisson.pmf(counts[N - 1 :], means)
    first = 3 * N - 2
    assert found[:first] == [None] * first
    for index in range(first, len(counts)):
        last = index - (N - 1) + 1
        now, before = pmf[last - N : last], pmf[last - 2 * N : last - N]
        assert found[index] is not None
        assert found[index].forward == pytest.approx(rel_entr(now, before).sum(), abs=1e-12)
        assert found[index].backward == pytest.approx(rel_entr(before, now).sum(), abs=1e-12)


def test_distribution_series_is_the_divergence_of_whole_distributions() -> None:
    rng = np.random.default_rng(6)
    counts = rng.integers(0, 9, size=50).astype(float)
    series = DistributionSeries(N, 0.1, 2.0)
    found = [series.add(count) for count in counts]
    assert found[: 2 * N - 1] == [None] * (2 * N - 1)
    for index in range(2 * N - 1, len(counts)):
        now = counts[index + 1 - N : index + 1].mean() + 0.1
        before = counts[index + 1 - 2 * N : index + 1 - N].mean() + 0.1
        assert found[index] is not None
        expected = kl_div(now, before) - kl_div(now + 2.0, before + 2.0)
        assert found[index].forward == pytest.approx(expected, abs=1e-12)
        expected = kl_div(before, now) - kl_div(before + 2.0, now + 2.0)
        assert found[index].backward == pytest.approx(expected, abs=1e-12)


@given(st.lists(st.floats(0.0, 1e300), min_size=3 * N, max_size=5 * N))
def test_no_counts_make_a_divergence_infinite_or_nan(counts: list[float]) -> None:
    for series in (RowSeries(N), DistributionSeries(N, 0.1, 2.0)):
        for count in counts:
            found = series.add(count)
            assert found is None or (math.isfinite(found.total) and found.forward == found.forward)


# Values


def test_table_2_maps_values_into_its_ranges_and_units() -> None:
    values = Table2Values()
    assert values(FixSample(0, -35.0, 149.0, 58.44)) == {
        "altitude": 584.0,
        "latitude": 900_000_000.0,
        "longitude": 1_800_000_000.0,
    }
    assert values(FixSample(1, -35.0000003, 149.0000002, -3.0)) == {
        "altitude": 0.0,
        "latitude": 899_999_997.0,
        "longitude": 1_800_000_002.0,
    }
    assert values(FixSample(2, -35.0, 149.0, 2000.0))["altitude"] == 10_000.0
    assert values(VelocitySample(0, (3.0, 4.0, 9.0))) == {"speed": 50.0, "track": 217.0}
    assert values(VelocitySample(0, (-60.0, 0.0, 0.0))) == {"speed": 400.0, "track": 90.0}
    assert values(SatelliteSample(0, 40)) == {"satellites": 34.0}


def test_table_2_crosses_the_date_line() -> None:
    values = Table2Values()
    values(FixSample(0, 0.0, 179.9999999, 0.0))
    assert values(FixSample(1, 0.0, -179.9999999, 0.0))["longitude"] == 1_800_000_002.0


def test_changes_of_steady_motion_are_none_and_a_jump_counts_twice() -> None:
    values = Changes(KldParameters())
    counts = [
        values(sample)
        for name, sample in flight(
            4.0,
            noise_m=0.0,
            velocity=lambda t: (3.0, 4.0, -1.0),
            change=lambda index, fix: (
                fix
                if index < 10
                else FixSample(
                    fix.stamp_ns, fix.latitude_deg, fix.longitude_deg, fix.altitude_m + 5.0
                )
            ),
        )
        if name == "fix"
    ]
    assert counts[:2] == [dict.fromkeys(("altitude", "latitude", "longitude"))] * 2
    altitude = [count["altitude"] for count in counts[2:]]
    # A step at 5 Hz is 0.15 m + 2.5 m/s² · 0.04 s² = 0.25 m, so 5 m are 20 steps, there and back.
    assert altitude == [0.0] * 8 + [20.0, 20.0] + [0.0] * 8
    assert {count["latitude"] for count in counts[2:]} == {0.0}


def test_the_track_angle_changes_across_south_as_anywhere() -> None:
    values = Changes(KldParameters())
    values(VelocitySample(0, (0.1, -8.0, 0.0)))
    assert values(VelocitySample(SECOND // 5, (-0.1, -8.0, 0.0))) == {"speed": 0.0, "track": 0.0}
    slow = values(VelocitySample(2 * SECOND // 5, (0.0, -1.0, 0.0)))
    assert slow == {"speed": 14.0, "track": None}


# Detector


def test_a_clean_flight_is_normal_once_the_windows_are_full() -> None:
    found = verdicts(flight(30.0), KldParameters())
    assert len(found) == 150
    assert states(found) == [State.NOT_READY, State.NORMAL]
    assert {f"{name}.{way}" for name in NAMES for way in ("forward", "backward")} <= set(
        found[-1].values
    )


def test_forged_altitude_and_satellites_alarm_at_once_and_are_kept() -> None:
    rng = np.random.default_rng(1)
    forged = [4.2 * float(rng.normal()) for _ in range(50)]
    samples = flight(
        40.0,
        satellites=lambda index: int(rng.integers(9, 20)) if 100 <= index < 150 else 12,
        change=lambda index, fix: (
            fix
            if not 100 <= index < 150
            else FixSample(
                fix.stamp_ns,
                fix.latitude_deg,
                fix.longitude_deg,
                fix.altitude_m + forged[index - 100],
            )
        ),
    )
    found = verdicts(samples, KldParameters())
    alarms = [index for index, verdict in enumerate(found) if verdict.state is State.ALARM]
    assert 100 <= alarms[0] <= 104
    assert alarms == list(range(alarms[0], len(found)))
    assert "altitude" in found[alarms[0]].reason
    assert found[-1].reason.startswith("kept for ")
    assert found[-1].score < 1.0
    assert CODES[found[-1].state] == 111
    assert CODES[found[alarms[0] - 1].state] == 110

    passing = verdicts(samples, KldParameters(latched=False))
    assert passing[-1].state is State.NORMAL
    scores = [verdict.score for verdict in found]
    assert scores == [verdict.score for verdict in passing]


@pytest.mark.parametrize("hz", [1.0, 5.0, 10.0])
def test_hard_manoeuvres_do_not_alarm_at_any_rate(hz: float) -> None:
    def velocity(t: float) -> tuple[float, float, float]:
        """Stand, accelerate with 5 m/s² to 15 m/s, turn at 60°/s, climb, brake with 8 m/s²."""
        speed = min(max(0.0, 5.0 * (t - 30.0)), 15.0, max(0.0, 8.0 * (62.0 - t)))
        angle = math.radians(60.0) * max(0.0, min(t - 40.0, 6.0))
        return (speed * math.sin(angle), speed * math.cos(angle), 3.0 if 48.0 < t < 56.0 else 0.0)

    found = verdicts(flight(90.0, hz=hz, velocity=velocity), KldParameters())
    assert states(found) == [State.NOT_READY, State.NORMAL]
    assert max(verdict.score for verdict in found) < 0.75


@pytest.mark.parametrize("noise_m", [0.5, 2.0, 4.0])
def test_a_noisy_receiver_is_normal_as_long_as_it_stays_so(noise_m: float) -> None:
    found = verdicts(flight(600.0, noise_m=noise_m), KldParameters())
    assert states(found) == [State.NOT_READY, State.NORMAL]


@pytest.mark.parametrize("absent", ["velocity", "satellites", "both"])
def test_topics_that_are_absent_are_left_out(absent: str) -> None:
    samples = flight(
        20.0,
        satellites=None if absent != "velocity" else lambda index: 12,
        with_velocity=absent == "satellites",
    )
    found = verdicts(samples, KldParameters())
    assert states(found) == [State.NOT_READY, State.NORMAL]
    known = {name.partition(".")[0] for name in found[-1].values} & set(NAMES)
    assert known == {"altitude", "latitude", "longitude"} | (
        {"satellites"} if absent == "velocity" else set()
    ) | ({"speed", "track"} if absent == "satellites" else set())


def test_a_quorum_is_needed_and_fewer_claims_are_suspicious() -> None:
    samples = flight(20.0, satellites=lambda index: 12 if index < 60 else 9 + 10 * (index % 2))
    one = verdicts(samples, KldParameters(latched=False))
    two = verdicts(samples, KldParameters(latched=False, quorum=2))
    assert State.ALARM in states(one)
    assert states(two) == [State.NOT_READY, State.NORMAL, State.SUSPICIOUS, State.NORMAL]
    assert "2 parameters are needed" in next(v.reason for v in two if v.state is State.SUSPICIOUS)
    assert CODES[State.SUSPICIOUS] == 110


def test_too_few_parameters_for_the_quorum_are_said() -> None:
    samples = flight(20.0, satellites=None, with_velocity=False)
    found = verdicts(samples, KldParameters(quorum=4))
    assert states(found) == [State.NOT_READY]
    assert found[-1].reason == "3 parameters with full windows, 4 are needed"


def test_after_a_gap_the_windows_start_over() -> None:
    samples = [one for one in flight(30.0) if not 12.0 <= one[1].stamp_ns / SECOND % 100 < 16.0]
    found = verdicts(samples, KldParameters())
    assert states(found) == [
        State.NOT_READY,
        State.NORMAL,
        State.STALE,
        State.NOT_READY,
        State.NORMAL,
    ]


def test_a_clock_that_is_set_back_starts_the_windows_over() -> None:
    samples = flight(30.0)
    at_ns = samples[0][1].stamp_ns + 15 * SECOND
    set_back = [
        (name, dataclasses.replace(one, stamp_ns=one.stamp_ns - SECOND))
        if one.stamp_ns >= at_ns
        else (name, one)
        for name, one in samples
    ]
    stage = Stage(lambda: KldDetector(KldParameters()))
    found = [verdict for name, one in set_back for verdict in stage.push(name, one)]
    assert states(found) == [State.NOT_READY, State.NORMAL, State.NOT_READY, State.NORMAL]


def test_a_receiver_without_fix_is_not_observable() -> None:
    def lost(index: int, fix: FixSample) -> FixSample:
        return fix if not 60 <= index < 75 else FixSample(fix.stamp_ns, 0.0, 0.0, 0.0, False)

    found = verdicts(flight(30.0, change=lost), KldParameters())
    assert State.NOT_OBSERVABLE in states(found)
    assert State.ALARM not in states(found)
    assert State.NOT_OBSERVABLE not in CODES


def test_silence_of_the_fixes_is_told() -> None:
    samples = [one for one in flight(30.0) if one[0] != "fix" or one[1].stamp_ns / SECOND % 100 < 9]
    found = verdicts(samples, KldParameters())
    assert found[-1].state is State.STALE
    assert "no fix for" in found[-1].reason


def test_reset_takes_the_alarm_back_and_a_restart_does_not() -> None:
    jumped = flight(
        20.0,
        change=lambda index, fix: FixSample(
            fix.stamp_ns, fix.latitude_deg, fix.longitude_deg, fix.altitude_m + 60.0 * (index > 50)
        ),
    )
    detector = KldDetector(KldParameters())
    last = [detector.update(*one) for one in jumped][-1]
    assert last is not None
    assert last.state is State.ALARM
    afresh = KldDetector(KldParameters())
    afresh.inherit(detector)
    assert [afresh.update(*one) for one in jumped[:3]][-1].state is State.ALARM
    detector.reset()
    later = FixSample(last.stamp_ns + SECOND // 5, 48.0, 11.0, 580.0)
    assert detector._evaluate(later.stamp_ns).state is State.NORMAL


def test_the_faithful_mode_sees_a_jump_of_the_number_of_satellites_and_the_altitude() -> None:
    rng = np.random.default_rng(3)
    samples = flight(
        30.0,
        satellites=lambda index: 12 if index < 75 else int(rng.integers(9, 20)),
        change=lambda index, fix: FixSample(
            fix.stamp_ns,
            fix.latitude_deg,
            fix.longitude_deg,
            fix.altitude_m + (4.2 * float(rng.normal()) if index >= 75 else 0.0),
        ),
    )
    found = verdicts(samples, FAITHFUL)
    assert [state for state in states(found) if state is not State.SUSPICIOUS] == [
        State.NOT_READY,
        State.NORMAL,
        State.ALARM,
    ]


finite = st.floats(allow_nan=False, allow_infinity=False)


@settings(max_examples=50)
@given(
    st.lists(
        st.tuples(
            st.floats(-90.0, 90.0),
            st.floats(-180.0, 180.0),
            st.floats(-1000.0, 50_000.0),
            st.floats(-1000.0, 1000.0),
            st.integers(0, 200),
            st.integers(1, 3 * SECOND),
        ),
        max_size=60,
    ),
    st.sampled_from([KldParameters(), FAITHFUL]),
)
def test_no_sample_breaks_it(
    rows: list[tuple[float, float, float, float, int, int]], parameters: KldParameters
) -> None:
    detector = KldDetector(parameters)
    stamp = 0
    for latitude, longitude, altitude, speed, count, wait in rows:
        stamp += wait
        detector.update("velocity", VelocitySample(stamp, (speed, -speed, speed)))
        detector.update("satellites", SatelliteSample(stamp, count))
        verdict = detector.update("fix", FixSample(stamp, latitude, longitude, altitude))
        assert verdict is not None
        assert math.isfinite(verdict.score)
        assert all(math.isfinite(value) for value in verdict.values.values())


def test_memory_stays_flat() -> None:
    detector = KldDetector(KldParameters())
    rng = np.random.default_rng(2)
    sizes = []
    tracemalloc.start()
    for index in range(6000):
        stamp = index * SECOND // 5
        detector.update("velocity", VelocitySample(stamp, (8.0, 0.1, 0.0)))
        detector.update("satellites", SatelliteSample(stamp, int(rng.integers(11, 13))))
        detector.update("fix", FixSample(stamp, 48.0, 11.0 + 1e-6 * index, 500.0))
        if index in (2000, 5999):
            sizes.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert sizes[1] - sizes[0] < 10_000


def test_two_parameters_at_a_share_of_their_thresholds_are_as_much_as_one() -> None:
    """Satellites that change by two with every fix, and a step of the altitude by six metres."""
    samples = flight(
        20.0,
        satellites=lambda index: 12 + 2 * (index % 2) * (index >= 60),
        change=lambda index, fix: FixSample(
            fix.stamp_ns,
            fix.latitude_deg,
            fix.longitude_deg,
            fix.altitude_m + 6.0 * (index >= 62),
        ),
    )
    shared = verdicts(samples, KldParameters(latched=False))
    alone = verdicts(samples, KldParameters(latched=False, together=1))
    assert State.ALARM not in states(alone)
    first = next(verdict for verdict in shared if verdict.state is State.ALARM)
    assert "satellites by" in first.reason
    assert "altitude by" in first.reason
    values, parameters = first.values, KldParameters()
    margins = [
        (values[f"{name}.forward"] + values[f"{name}.backward"]) / parameters.threshold(name)
        for name in ("altitude", "satellites")
    ]
    assert 0.5 < min(margins) <= max(margins) < 1.0
    assert first.score == pytest.approx(2.0 * min(margins))


def test_the_faithful_quorum_is_not_shared() -> None:
    found = verdicts(flight(30.0, satellites=lambda index: 12 + 3 * (index % 2)), FAITHFUL)
    for verdict in found:
        if "claims" in verdict.values and verdict.state is State.ALARM:
            assert verdict.values["claims"] >= 2.0
