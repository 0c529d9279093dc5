# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""All parts together: the order of arrival decides nothing, and an attack is found."""

import math
import random
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import pytest

from hijack_detect.detectors.verdict import State
from hijack_detect.monitor.graph import Monitor, Stage
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.simulation.flight import Flight
from hijack_detect.streams.samples import FixSample, Sample, VelocitySample

SECOND = 10**9
Sent = list[tuple[str, Sample]]
ALL = ("imu", "fix", "velocity", "mag")


def run(sent: Sent) -> tuple[dict[str, list[Any]], Monitor]:
    monitor = Monitor(MonitorParameters())
    outputs: dict[str, list[Any]] = {name: [] for name in monitor.stages}
    for name, sample in sent:
        for part, output in monitor.push(name, [sample]):
            outputs[part].append(output)
    return outputs, monitor


def delayed(sent: Sent, delay_s: Callable[[str], float]) -> Sent:
    """Every sample arrives some time after its stamp, the samples of an input in order."""
    arrivals = []
    last: dict[str, float] = {}
    for index, (name, sample) in enumerate(sent):
        last[name] = max(last.get(name, 0.0), sample.stamp_ns + delay_s(name) * SECOND)
        arrivals.append((last[name], index))
    return [sent[index] for _, index in sorted(arrivals)]


def jitter() -> Callable[[str], float]:
    rng = random.Random(1)
    return lambda name: rng.uniform(0.0, 0.9)


def test_the_order_of_arrival_decides_nothing(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    sent = samples(flight("curved", 5, 60.0), *ALL)
    expected, monitor = run(sent)
    assert len(expected["fusion"]) > 400
    assert {one.state for one in expected["date"]} >= {State.NOT_READY, State.NORMAL}
    assert not any(stage.refused for stage in monitor.stages.values())
    for delay_s in (
        jitter(),
        lambda name: 0.9 if name == "imu" else 0.0,
        lambda name: 0.0 if name == "imu" else 0.9,
        lambda name: 0.9 if name == "fix" else 0.0,
    ):
        outputs, _ = run(delayed(sent, delay_s))
        assert outputs == expected


@pytest.mark.parametrize(
    ("inputs", "dies", "returns_s"),
    [
        (ALL, "velocity", 1e9),
        (ALL, "mag", 50.0),
        (("imu", "fix", "velocity"), "nothing", 1e9),
        (("imu", "fix", "velocity"), "fix", 50.0),
        (("imu", "fix"), "nothing", 1e9),
    ],
)
def test_the_order_of_arrival_decides_nothing_in_an_outage(
    inputs: tuple[str, ...],
    dies: str,
    returns_s: float,
    flight: Callable[..., Flight],
    samples: Callable[..., Sent],
) -> None:
    one = flight("curved", 5, 60.0)
    sent = [
        (name, sample)
        for name, sample in samples(one, *inputs)
        if name != dies or not 40.0 <= (sample.stamp_ns - one.plan.start_ns) / SECOND < returns_s
    ]
    expected, _ = run(sent)
    for delay_s in (jitter(), lambda name: 0.9 if name == "imu" else 0.0):
        outputs, _ = run(delayed(sent, delay_s))
        assert outputs == expected


def test_a_recording_that_is_looped_gives_the_same_again(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    sent = samples(flight("curved", 5, 60.0), *ALL)
    once, _ = run(sent)
    twice, monitor = run(sent + sent)
    for part in ("attitude", "course"):
        assert twice[part][: len(once[part])] == once[part]
        assert len(twice[part]) >= 2 * len(once[part]) - 2
    assert monitor.stages["attitude"].restarts == 1
    last, again = once["attitude"][-1], twice["attitude"][-1]
    assert again.stamp_ns == last.stamp_ns
    assert again.orientation == pytest.approx(last.orientation, abs=1e-3)


def test_a_clock_that_is_set_back_takes_no_alert_back(
    flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    one = flight("curved", 3)
    sent = samples(one, *ALL)
    onset = one.plan.start_ns + 55 * SECOND
    outputs, monitor = run(turned_away(sent, onset, 1.0) + sent)
    assert monitor.stages["fusion"].restarts >= 1
    assert outputs["fusion"][-1].alert


def test_a_stage_makes_its_component_afresh_when_the_clock_runs_back() -> None:
    class Counter:
        inputs: Mapping[str, float] = {"a": 3.0}

        def __init__(self) -> None:
            self.count = 0

        def update(self, name: str, sample: FixSample) -> int:
            self.count += 1
            return self.count

    stage = Stage(Counter)
    stamps = [10, 11, 12, 2, 3]
    outputs = [stage.push("a", FixSample(t * SECOND, 0.0, 0.0, 0.0)) for t in stamps]
    assert outputs == [[1], [2], [3], [], [1]]
    assert stage.restarts == 1
    stage.restart()
    assert stage.push("a", FixSample(4 * SECOND, 0.0, 0.0, 0.0)) == [1]
    assert stage.restarts == 1


@pytest.mark.parametrize("route", ["curved", "straight"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_clean_flight_raises_no_alert(
    route: str, seed: int, flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    outputs, _ = run(samples(flight(route, seed), *ALL))
    assert not any(one.alert for one in outputs["fusion"])
    assert {one.state for one in outputs["fusion"]} >= {State.NORMAL}


def turned_away(sent: Sent, onset_ns: int, angle: float) -> Sent:
    """From the onset on, the reported track turns away by an angle about where it was."""
    cosine, sine = math.cos(angle), math.sin(angle)
    pivot: FixSample | None = None
    spoofed: Sent = []
    for name, one in sent:
        reported = one
        if isinstance(one, FixSample) and one.stamp_ns >= onset_ns:
            pivot = pivot or one
            stretch = math.cos(math.radians(pivot.latitude_deg))
            east = (one.longitude_deg - pivot.longitude_deg) * stretch
            north = one.latitude_deg - pivot.latitude_deg
            reported = replace(
                one,
                longitude_deg=pivot.longitude_deg + (cosine * east - sine * north) / stretch,
                latitude_deg=pivot.latitude_deg + sine * east + cosine * north,
            )
        elif isinstance(one, VelocitySample) and one.stamp_ns >= onset_ns:
            east, north, up = one.velocity
            turned = (cosine * east - sine * north, sine * east + cosine * north, up)
            reported = replace(one, velocity=turned)
        spoofed.append((name, reported))
    return spoofed


@pytest.mark.parametrize("route", ["curved", "straight"])
@pytest.mark.parametrize("angle_deg", [60.0, -60.0])
def test_a_track_that_turns_away_raises_the_alert(
    route: str, angle_deg: float, flight: Callable[..., Flight], samples: Callable[..., Sent]
) -> None:
    """The reported velocity jumps by 8 m/s within a fix; the vehicle flies on."""
    one = flight(route, 3)
    onset = one.plan.start_ns + 55 * SECOND
    outputs, _ = run(turned_away(samples(one, *ALL), onset, math.radians(angle_deg)))
    alert = next(result for result in outputs["fusion"] if result.alert)
    assert 0.0 <= (alert.stamp_ns - onset) / SECOND < 5.0
    assert alert.alert_since_ns == alert.stamp_ns
    assert all(result.alert for result in outputs["fusion"] if result.stamp_ns > alert.stamp_ns)
