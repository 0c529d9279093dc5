"""The coast detector on simulated flights, and its bank against a least-squares reference."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from hijack_detect.detectors.coast import CoastDetector
from hijack_detect.detectors.coast_bank import CoastBank
from hijack_detect.detectors.coast_parameters import CoastParameters
from hijack_detect.detectors.verdict import State, Verdict
from hijack_detect.estimation.ekf import POSITION, VELOCITY
from hijack_detect.estimation.lag_ekf import SIZE, Measured, Propagated
from hijack_detect.estimation.rotation import Array
from hijack_detect.evaluation.trials.cases import flight_samples
from hijack_detect.simulation.flight import generate_flight
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.spoofing.scenario import parse_scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import FixSample, ImuSample, Sample, VelocitySample

SECOND = 10**9
ONSET_S = 45.0
PLAN = FlightPlan("curved", duration_s=60.0)
Sent = list[tuple[str, Sample]]


@pytest.fixture(scope="module")
def clean() -> Sent:
    return list(flight_samples(generate_flight(PLAN, 5)))


def run(sent: Sent, *, without: tuple[str, ...] = (), **parameters: float) -> list[Verdict]:
    detector = CoastDetector(CoastParameters.from_mapping(parameters))
    said = (
        detector.update(name, sample)  # type: ignore[arg-type]
        for name, sample in sent
        if name in detector.inputs and name not in without
    )
    return [one for one in said if one is not None]


def seconds(verdict: Verdict) -> float:
    return (verdict.stamp_ns - PLAN.start_ns) / SECOND


def drifted(sent: Sent, acceleration: float) -> Sent:
    """The flight with a carry-off to the East put in: the IMU did not feel it."""
    model = {
        "type": "drift",
        "speed_m_s": 4.0,
        "onset_acceleration_m_s2": acceleration,
        "bearing_deg": 90.0,
    }
    segment = {"name": "east", "start": ONSET_S, "end": 60.0, "model": model}
    spoofer = Spoofer(parse_scenario({"segments": [segment]}, "east"), PLAN.start_ns)

    def spoofed(sample: Sample) -> Sample:
        if isinstance(sample, FixSample):
            return spoofer.fix(sample)
        return spoofer.velocity(sample) if isinstance(sample, VelocitySample) else sample

    return [(name, spoofed(sample)) for name, sample in sent]


def test_a_clean_flight_is_normal_once_its_noise_is_known(clean: Sent) -> None:
    verdicts = run(clean)
    states = [one.state for one in verdicts]
    assert states[0] is State.NOT_READY
    assert State.ALARM not in states
    assert {one.state for one in verdicts if seconds(one) > 30.0} <= {
        State.NORMAL,
        State.SUSPICIOUS,
    }
    last = verdicts[-1].values
    assert 0.05 < last["smallest_visible"] < 2.0
    assert 0.3 <= last["noise_scale"] <= 3.0


@pytest.mark.parametrize(("acceleration", "within_s"), [(1.0, 5.0), (2.0, 3.0)])
def test_a_carry_off_alarms_and_its_direction_is_told(
    clean: Sent, acceleration: float, within_s: float
) -> None:
    verdicts = run(drifted(clean, acceleration))
    alarms = [one for one in verdicts if one.state is State.ALARM]
    assert ONSET_S < seconds(alarms[0]) < ONSET_S + within_s
    assert math.degrees(abs(alarms[0].values["direction"])) < 30.0
    assert alarms[0].values["acceleration"] == pytest.approx(acceleration, rel=0.5)


def test_without_an_imu_it_is_stale(clean: Sent) -> None:
    cut = [
        (name, sample)
        for name, sample in clean
        if name != "imu" or sample.stamp_ns < PLAN.start_ns + 40 * SECOND
    ]
    late = [one for one in run(cut) if seconds(one) > 42.0]
    assert {one.state for one in late} == {State.STALE}


def test_without_a_heading_it_is_not_ready(clean: Sent) -> None:
    early = [one for one in run(clean, without=("mag",)) if seconds(one) < 10.0]
    assert {one.state for one in early} == {State.NOT_READY}
    assert "heading" in early[-1].reason


def test_after_a_crash_it_cannot_tell(clean: Sent) -> None:
    at = next(
        i
        for i, (n, s) in enumerate(clean)
        if n == "imu" and s.stamp_ns >= PLAN.start_ns + 40 * SECOND
    )
    sample = clean[at][1]
    assert isinstance(sample, ImuSample)
    hit = list(clean)
    hit[at] = ("imu", ImuSample(sample.stamp_ns, sample.angular_velocity, (0.0, 0.0, 90.0)))
    late = [one for one in run(hit) if 41.0 < seconds(one) < 59.0]
    assert {one.state for one in late} == {State.NOT_OBSERVABLE}


def test_a_vehicle_that_is_too_noisy_is_not_judged(clean: Sent) -> None:
    late = [
        one for one in run(clean, max_noise_scale=0.5, velocity_sigma=0.01) if seconds(one) > 35
    ]
    assert {one.state for one in late} <= {State.NOT_OBSERVABLE}


def test_it_works_on_fixes_alone(clean: Sent) -> None:
    verdicts = run(clean, without=("velocity",))
    assert verdicts[-1].state is State.NORMAL


def steps(seed: int) -> tuple[list[Propagated | Measured], Callable[[Array], list[Array]]]:
    """Steps of a linear filter with random matrices, and how an offset since 0 s shows in it."""
    rng = np.random.default_rng(seed)
    made: list[Propagated | Measured] = []
    for _ in range(20):
        made.append(Propagated(0.2, np.eye(SIZE) + 0.02 * rng.normal(size=(SIZE, SIZE))))
        for block in (POSITION, VELOCITY):
            h = np.eye(SIZE)[block] + 0.1 * rng.normal(size=(3, SIZE))
            gain = 0.1 * rng.normal(size=(SIZE, 3))
            root = rng.normal(size=(3, 3))
            made.append(Measured(block, h, gain, root @ root.T + np.eye(3), np.zeros(3)))

    def shown(acceleration: Array) -> list[Array]:
        error, age, innovations = np.zeros(SIZE), 0.0, []
        for step in made:
            if isinstance(step, Propagated):
                error, age = step.transition @ error, age + step.dt_s
                continue
            offset = np.zeros(3)
            offset[:2] = acceleration * (0.5 * age**2 if step.block is POSITION else age)
            innovation = offset - step.h @ error
            error = error + step.gain @ innovation
            innovations.append(innovation)
        return innovations

    return made, shown


@pytest.mark.parametrize("seed", range(5))
def test_the_bank_finds_an_offset_exactly_whatever_the_filter_did_with_it(seed: int) -> None:
    made, shown = steps(seed)
    acceleration = np.array([0.7, -1.2])
    innovations = iter(shown(acceleration))
    bank = CoastBank([4.0], 100.0)
    bank.propagate(Propagated(0.0, np.eye(SIZE)))
    for step in made:
        if isinstance(step, Propagated):
            bank.propagate(step)
        else:
            bank.measure(Measured(step.block, step.h, step.gain, step.precision, next(innovations)))
    found = bank.offsets()
    assert found.age_s == pytest.approx([4.0])
    assert found.acceleration[0] == pytest.approx(acceleration, rel=1e-6)


def test_the_deviation_is_that_of_generalised_least_squares() -> None:
    made, shown = steps(3)
    bank = CoastBank([4.0], 100.0)
    bank.propagate(Propagated(0.0, np.eye(SIZE)))
    for step in made:
        bank.propagate(step) if isinstance(step, Propagated) else bank.measure(step)
    columns = [np.concatenate(shown(axis)) for axis in np.eye(2)]
    design = np.stack(columns, axis=1)
    precision = [step.precision for step in made if isinstance(step, Measured)]
    information = sum(
        design[3 * k : 3 * k + 3].T @ one @ design[3 * k : 3 * k + 3]
        for k, one in enumerate(precision)
    )
    expected = math.sqrt(0.5 * np.trace(np.linalg.inv(information)))
    assert bank.offsets().sigma[0] == pytest.approx(expected, rel=1e-6)
