# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The bank of onsets: against filters that were really deceived, least squares and chance."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from filter_start import ERRORS, LEVEL, NOISE, SIGMAS
from scipy.linalg import block_diag
from scipy.stats import chi2

from hijack_detect.detectors.coast_bank import Change, CoastBank, Offsets
from hijack_detect.estimation.ekf import GRAVITY, POSITION, VELOCITY, ImuBlock, Observation, Source
from hijack_detect.estimation.kalman import Innovation
from hijack_detect.estimation.lag_ekf import SIZE, LagEkf, Measured, Propagated

Array = npt.NDArray[np.float64]
Step = Propagated | Measured
BLOCKS = {Source.POSITION: POSITION, Source.VELOCITY: VELOCITY}
START = Propagated(0.0, np.eye(SIZE))
"""Begins the first onset."""


def follow(bank: CoastBank, steps: Iterable[Step]) -> Offsets:
    for step in steps:
        if isinstance(step, Propagated):
            bank.propagate(step)
        else:
            bank.measure(step)
    return bank.offsets()


def random_steps(seed: int, count: int = 20) -> list[Step]:
    """Steps of 0.2 s of a linear filter with random matrices, and another sensor among them."""
    rng = np.random.default_rng(seed)
    made: list[Step] = []
    for _ in range(count):
        made.append(Propagated(0.2, np.eye(SIZE) + 0.02 * rng.normal(size=(SIZE, SIZE))))
        for source in (Source.POSITION, Source.VELOCITY, Source.FIELD):
            h = 0.1 * rng.normal(size=(3, SIZE))
            if source in BLOCKS:
                h += np.eye(SIZE)[BLOCKS[source]]
            root = rng.normal(size=(3, 3))
            precision = root @ root.T + np.eye(3)
            gain = 0.1 * rng.normal(size=(SIZE, 3))
            made.append(Measured(source, True, Innovation(h, np.zeros(3), precision, gain)))
    return made


def innovations(
    steps: list[Step],
    acceleration: Array,
    onset_s: float = 0.0,
    *,
    step: float = 0.0,
    ramp: float = 0.0,
) -> list[Array]:
    """What an offset acceleration from an onset on shows in a filter whose innovations were 0.

    From the start on state 7 may step and ramp: it is wrong by as much as it has changed, and the
    filter mends what it can.
    """
    error, now, shown = np.zeros(SIZE), 0.0, []
    error[7] = step
    for one in steps:
        if isinstance(one, Propagated):
            error, now = one.transition @ error, now + one.dt_s
            error[7] += ramp * one.dt_s
            continue
        offset, age = np.zeros(3), max(0.0, now - onset_s)
        if one.source in BLOCKS:
            offset[:2] = acceleration * (0.5 * age**2 if one.source is Source.POSITION else age)
        innovation = offset - one.innovation.H @ error
        error = error + one.innovation.K @ innovation
        shown.append(innovation)
    return shown


def with_innovations(steps: list[Step], shown: Iterable[Array]) -> list[Step]:
    left = iter(shown)
    return [
        step
        if isinstance(step, Propagated)
        else replace(step, innovation=replace(step.innovation, residual=next(left)))
        for step in steps
    ]


def design(steps: list[Step]) -> tuple[Array, Array]:
    """Innovations per unit acceleration, shape (m, 2), and the inverse of their covariance."""
    columns = [np.concatenate(innovations(steps, axis)) for axis in np.eye(2)]
    precision = [step.innovation.precision for step in steps if isinstance(step, Measured)]
    return np.stack(columns, axis=1), block_diag(*precision)


@pytest.mark.parametrize("seed", range(5))
def test_an_offset_is_found_exactly_whatever_the_filter_did_with_it(seed: int) -> None:
    steps, acceleration = random_steps(seed), np.array([0.7, -1.2])
    deceived = with_innovations(steps, innovations(steps, acceleration))
    found = follow(CoastBank(SIZE, 1.0, 9.0, 100.0), [START, *deceived])
    assert found.age_s == pytest.approx([4.0])
    np.testing.assert_allclose(found.acceleration[0], acceleration, rtol=1e-6)


def test_of_many_onsets_the_true_one_finds_it_exactly() -> None:
    """Onsets every 0.4 s, the true one after 2 s: the other ages find something else."""
    steps, acceleration = random_steps(8), np.array([-0.4, 0.9])
    deceived = with_innovations(steps, innovations(steps, acceleration, 2.0))
    found = follow(CoastBank(SIZE, 1.19, 2.81, 0.4 - 1e-9), [START, *deceived])
    np.testing.assert_allclose(found.age_s, [2.8, 2.4, 2.0, 1.6, 1.2])
    error = np.linalg.norm(found.acceleration - acceleration, axis=1)
    assert error[2] < 1e-6
    assert np.all(np.delete(error, 2) > 0.01)


@pytest.mark.parametrize("seed", range(3))
def test_it_is_the_generalised_least_squares_solution(seed: int) -> None:
    steps = random_steps(seed)
    rng = np.random.default_rng(100 + seed)
    noise = [rng.normal(size=3) for step in steps if isinstance(step, Measured)]
    found = follow(CoastBank(SIZE, 1.0, 9.0, 100.0), [START, *with_innovations(steps, noise)])

    g, precision = design(steps)
    root = np.linalg.cholesky(precision).T
    expected, *_ = np.linalg.lstsq(root @ g, root @ np.concatenate(noise), rcond=None)
    covariance = np.linalg.inv(g.T @ precision @ g)
    np.testing.assert_allclose(found.acceleration[0], expected, rtol=1e-5)
    assert found.sigma[0] == pytest.approx(math.sqrt(0.5 * np.trace(covariance)), rel=1e-6)
    squared = expected @ np.linalg.solve(covariance, expected)
    assert found.whitened[0] == pytest.approx(0.5 * squared, rel=1e-5)


def test_by_chance_it_finds_what_its_deviation_says() -> None:
    """Over runs with white innovations; twice `whitened` follows χ² with 2 degrees of freedom."""
    rng, steps, runs = np.random.default_rng(1), random_steps(4, count=10), 300
    roots = [
        np.linalg.cholesky(np.linalg.inv(step.innovation.precision))
        for step in steps
        if isinstance(step, Measured)
    ]
    found = [
        follow(
            CoastBank(SIZE, 1.0, 9.0, 100.0),
            [START, *with_innovations(steps, [root @ rng.normal(size=3) for root in roots])],
        )
        for _ in range(runs)
    ]
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], 2 * runs)
    assert low < sum(2.0 * one.whitened[0] for one in found) < high
    accelerations = np.array([one.acceleration[0] for one in found])
    spread = np.mean(np.square(accelerations), axis=0).sum() / 2.0
    assert math.sqrt(spread) == pytest.approx(found[0].sigma[0], rel=0.15)
    assert np.all(abs(accelerations.mean(axis=0)) < 5.0 * found[0].sigma[0] / math.sqrt(runs))


def flown(acceleration: Array, onset_s: float, seconds: float) -> list[Step]:
    """Steps of a real filter in a noiseless flight in circles, deceived from an onset on."""
    ekf = LagEkf(LEVEL, SIGMAS, NOISE, ERRORS)
    radius, rate = 15.0, 0.4
    ekf.velocity = np.array([0.0, radius * rate, 0.0])
    compass = np.zeros((1, SIZE))
    compass[0, 8] = 1.0
    for step in range(round(seconds / 0.2)):
        angles = rate * (0.2 * step + 0.01 * (np.arange(20) + 0.5))
        felt = -radius * rate**2 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
        ekf.propagate(
            ImuBlock(np.full(20, 0.01), np.zeros((20, 3)), felt + np.array([0.0, 0.0, GRAVITY]))
        )
        t = 0.2 * (step + 1)
        age, angle = max(0.0, t - onset_s), rate * t
        offset = np.array([*acceleration, 0.0])
        position = radius * np.array([math.cos(angle) - 1.0, math.sin(angle), 0.0])
        velocity = radius * rate * np.array([-math.sin(angle), math.cos(angle), 0.0])
        for source, measured, variance in (
            (Source.POSITION, position + 0.5 * age**2 * offset, 0.49),
            (Source.VELOCITY, velocity + age * offset, 0.01),
        ):
            ekf.update(ekf.gps(source, measured, np.full(3, variance)))
        # The heading is held by another sensor, which nobody deceives.
        turned = 2.0 * math.atan2(ekf.attitude[2], ekf.attitude[3])
        ekf.update(Observation(Source.FIELD, compass, np.array([-turned]), np.array([0.25])))
    return list(ekf.steps)


@pytest.mark.parametrize("onset_s", [8.0, 14.0, 17.0])
def test_a_real_filter_shows_what_the_bank_says(onset_s: float) -> None:
    """The innovations with and without a slight offset differ by g a."""
    acceleration = np.array([2e-4, -1e-4])
    clean, spoofed = flown(np.zeros(2), 0.0, 20.0), flown(acceleration, onset_s, 20.0)
    pairs = zip(clean, spoofed, strict=True)
    differences = [
        after.innovation.residual - before.innovation.residual
        for before, after in pairs
        if isinstance(before, Measured) and isinstance(after, Measured)
    ]
    age_s = 20.0 - onset_s
    bank = CoastBank(SIZE, age_s - 0.01, age_s + 0.01, 0.2 - 1e-9)
    found = follow(bank, [START, *with_innovations(clean, differences)])
    assert found.age_s == pytest.approx([age_s])
    np.testing.assert_allclose(found.acceleration[0], acceleration, rtol=0.01)


def test_a_real_filter_that_was_deceived_tells_by_how_much() -> None:
    """Nothing is known of the clean flight, and the filter has followed for 4 s."""
    acceleration = np.array([0.8, -0.5])
    bank = CoastBank(SIZE, 3.99, 4.01, 0.2 - 1e-9)
    found = follow(bank, [START, *flown(acceleration, 16.0, 20.0)])
    np.testing.assert_allclose(found.acceleration[0], acceleration, rtol=0.1)


def test_nothing_is_said_before_an_age_is_reached() -> None:
    bank = CoastBank(SIZE, 0.99, 3.01, 0.5)
    assert len(bank.offsets().age_s) == 0
    for k in range(1, 20):
        found = follow(bank, random_steps(k, count=1))
        n = len(found.age_s)
        shapes = [part.shape for part in (found.acceleration, found.sigma, found.whitened)]
        assert shapes == [(n, 2), (n,), (n,)]
        # The first onset began at 0.2 s and the next ones every 0.6 s, with the second fix after
        # the spacing.
        expected = [0.2 * k - begun for begun in np.arange(0.2, 4.0, 0.6)]
        np.testing.assert_allclose(found.age_s, [age for age in expected if 0.99 < age < 3.01])


@pytest.mark.parametrize("dt_s", [0.05, 0.2, 0.21, 0.3])
def test_onsets_lie_between_two_ages_with_the_spacing_or_a_step_more(dt_s: float) -> None:
    bank = CoastBank(SIZE, 0.9, 8.0, 0.35)
    for k in range(400):
        bank.propagate(Propagated(dt_s, np.eye(SIZE)))
        if k * dt_s > 10.0:
            found = bank.offsets().age_s
            assert np.all((found >= 0.9) & (found <= 8.0))
            gaps = -np.diff(found)
            assert np.all((gaps > 0.35 - 1e-9) & (gaps < 0.35 + dt_s + 1e-9))
            assert found[-1] < 0.9 + 0.35 + dt_s
            assert found[0] > 8.0 - 0.35 - 2.0 * dt_s


def test_what_was_before_the_oldest_onset_is_forgotten() -> None:
    """Two flights with another beginning and the same last 5 s; the oldest age is 3 s."""
    last = with_innovations(random_steps(3, 25), np.random.default_rng(1).normal(size=(75, 3)))
    found = []
    for size in (0.0, 1e3):
        first = random_steps(2, 50)
        shown = size * np.random.default_rng(2).normal(size=(150, 3))
        bank = CoastBank(SIZE, 1.0, 3.0, 0.5)
        found.append(follow(bank, [*with_innovations(first, shown), *last]))
    np.testing.assert_array_equal(found[0].age_s, found[1].age_s)
    np.testing.assert_array_equal(found[0].acceleration, found[1].acceleration)
    np.testing.assert_array_equal(found[0].whitened, found[1].whitened)


def test_it_does_not_grow() -> None:
    bank = CoastBank(SIZE, 1.0, 8.0, 0.5)
    steps = [Propagated(0.2, np.eye(SIZE)), *random_steps(1, 1)[1:]]
    sizes = []
    for _ in range(500):
        follow(bank, steps)
        sizes.append(len(pickle.dumps(bank)))
    assert max(sizes[100:]) == max(sizes[50:100])


def test_asking_changes_nothing() -> None:
    bank = CoastBank(SIZE, 1.0, 2.0, 0.5)
    rng = np.random.default_rng(5)
    steps = with_innovations(random_steps(6, 30), rng.normal(size=(90, 3)))
    other = copy.deepcopy(bank)
    for step in steps:
        follow(other, [step])
    follow(bank, steps)
    np.testing.assert_array_equal(bank.offsets().acceleration, other.offsets().acceleration)


def test_a_copy_of_the_steps_says_the_same() -> None:
    """A filter with steps in it is copied when the heading is looked for in all directions."""
    steps = with_innovations(random_steps(7), np.random.default_rng(7).normal(size=(60, 3)))
    found, of_copy = (
        follow(CoastBank(SIZE, 1.0, 9.0, 100.0), [START, *some])
        for some in (steps, copy.deepcopy(steps))
    )
    np.testing.assert_array_equal(found.acceleration, of_copy.acceleration)


def test_an_assumption_in_place_of_the_gps_holds_no_offset() -> None:
    """What is taken for still shows the same as another sensor that no spoofer reaches."""
    steps = with_innovations(random_steps(8), np.random.default_rng(8).normal(size=(60, 3)))
    still, other = (
        [replace(one, **change) if isinstance(one, Measured) else one for one in steps]
        for change in ({"horizontal": False}, {"source": Source.FIELD})
    )
    found, expected = (
        follow(CoastBank(SIZE, 1.0, 9.0, 100.0), [START, *some]) for some in (still, other)
    )
    np.testing.assert_array_equal(found.acceleration, expected.acceleration)


def test_an_error_of_the_height_is_no_offset() -> None:
    """The vertical is another detector's: without coupling it moves nothing here."""
    h, no_gain = np.eye(SIZE)[POSITION], np.zeros((SIZE, 3))
    said = Innovation(h, np.array([0.0, 0.0, 50.0]), np.eye(3), no_gain)
    high = Measured(Source.POSITION, True, said)
    steps: list[Step] = []
    for _ in range(10):
        steps += [Propagated(0.2, np.eye(SIZE)), high]
    found = follow(CoastBank(SIZE, 1.0, 9.0, 100.0), [START, *steps])
    np.testing.assert_array_equal(found.acceleration, np.zeros((1, 2)))


@pytest.mark.parametrize("seed", range(3))
def test_a_state_that_may_change_is_no_offset(seed: int) -> None:
    steps, acceleration = random_steps(seed), np.array([0.7, -1.2])
    changed = with_innovations(steps, innovations(steps, acceleration, step=2.0, ramp=-0.5))
    bank = CoastBank(SIZE, 1.0, 9.0, 100.0, {7: Change(1e3, 1e3)})
    still = follow(bank, [START, *changed])
    free = bank.offsets(changed=True)
    np.testing.assert_allclose(free.acceleration[0], acceleration, rtol=1e-4)
    assert np.linalg.norm(still.acceleration[0] - acceleration) > 1e-3
    assert free.sigma[0] > still.sigma[0]
    # Who knows that the state does not change hears nothing of it.
    sure = CoastBank(SIZE, 1.0, 9.0, 100.0, {7: Change(1e-6, 1e-6)})
    follow(sure, [START, *changed])
    same = sure.offsets(changed=True)
    np.testing.assert_allclose(same.acceleration, still.acceleration, rtol=1e-6)
