# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""What a vehicle's noise is taken for, by hand, and what an attacker cannot do to it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.estimation.learning import LearnedLevel, NoiseScale, Scatter

SECOND = 10**9
LOW, HIGH = 0.3, 3.0
SQUARES = st.lists(st.floats(0.0, 1e12), max_size=50)


def scale(**changed: float) -> NoiseScale:
    given_ = {
        "delay_s": 5.0,
        "memory_s": 1e9,
        "prior_s": 10.0,
        "clip": 3.0,
        "rise_per_s": 0.02,
        **changed,
    }
    return NoiseScale(LOW, HIGH, **given_)


def feed(one: NoiseScale, values: list[float], from_s: int = 0) -> NoiseScale:
    """A value a second."""
    for second, value in enumerate(values, from_s):
        one.add(second * SECOND, value)
    return one


def test_before_anything_is_learnt_it_is_the_prior() -> None:
    assert scale().value == 1.0
    assert scale(prior=0.5).value == 0.5


def test_the_mean_square_by_hand() -> None:
    """The prior of 1 weighs 10 s; 10 values of 4 over 1 s each: sqrt((10 + 40) / 20)."""
    assert feed(scale(), [4.0] * 17).value == pytest.approx(math.sqrt(50.0 / 20.0))


def test_the_mean_of_another_power_by_hand() -> None:
    """The prior of 1 weighs 10 s; 10 cubes of 2 over 1 s each: the cube root of (10 + 80) / 20."""
    assert feed(scale(power=3.0), [8.0] * 17).value == pytest.approx(4.5 ** (1.0 / 3.0))
    once = feed(scale(power=3.0), [1e12] + [0.0] * 17)
    assert once.value <= (10.0 + 27.0) ** (1.0 / 3.0) / 10.0 ** (1.0 / 3.0), "clipped at 3 scales"


def test_the_past_is_forgotten_by_hand() -> None:
    """Two values are learnt, over 1 s each; before each all that was loses e to its power."""
    one = feed(scale(memory_s=2.0), [4.0] * 9)
    kept = math.exp(-0.5)
    total = (10.0 * kept + 4.0) * kept + 4.0
    weight = (10.0 * kept + 1.0) * kept + 1.0
    assert one.value == pytest.approx(math.sqrt(total / weight))


@pytest.mark.parametrize("true", [0.5, 2.5])
def test_in_a_long_flight_it_becomes_the_root_mean_square(true: float) -> None:
    assert feed(scale(memory_s=30.0), [true**2] * 400).value == pytest.approx(true, rel=1e-3)


def test_the_rate_of_the_values_does_not_matter() -> None:
    """10 values in as many seconds, or 100."""
    one, other = scale(delay_s=0.0), scale(delay_s=0.0)
    for step in range(102):
        one.add(step * SECOND // 10, 4.0)
    for second in range(12):
        other.add(second * SECOND, 4.0)
    assert one.value == pytest.approx(other.value, rel=1e-9)


def test_a_gap_counts_as_a_second() -> None:
    """Of three values a minute apart two are learnt: sqrt((10 + 2 * 4) / 12)."""
    one = scale()
    for minute in range(4):
        one.add(60 * minute * SECOND, 4.0)
    assert one.value == pytest.approx(math.sqrt(18.0 / 12.0))


def test_what_is_younger_than_the_delay_is_not_learnt() -> None:
    assert feed(scale(), [1e6] * 6).value == 1.0


def test_what_is_held_is_never_learnt() -> None:
    one = scale()
    for second in range(100):
        one.add(second * SECOND, 1e6)
        one.hold()
    assert one.value == 1.0


def test_what_was_learnt_before_a_hold_stays() -> None:
    one = feed(scale(), [4.0] * 17)
    learnt = one.value
    one.hold()
    assert one.value == learnt
    assert feed(one, [4.0] * 5, 17).value == learnt


def test_a_single_value_counts_no_more_than_the_clip() -> None:
    """The second of two values is learnt: 1 s of 9 instead of a million."""
    one = scale()
    one.add(0, 1.0)
    one.add(SECOND, 1e6)
    one.add(7 * SECOND, 1.0)
    assert one.value == pytest.approx(math.sqrt(19.0 / 11.0))


@given(SQUARES)
def test_it_stays_within_its_bounds(values: list[float]) -> None:
    one = scale(prior_s=0.1, delay_s=0.0)
    for second, value in enumerate(values):
        one.add(second * SECOND, value)
        assert LOW <= one.value <= HIGH


@pytest.mark.parametrize(("value", "bound"), [(0.0, LOW), (1e12, HIGH)])
def test_it_reaches_its_bounds(value: float, bound: float) -> None:
    assert feed(scale(memory_s=30.0), [value] * 400).value == bound


@given(SQUARES, st.lists(st.floats(0.0, 1e12), min_size=5, max_size=5))
def test_an_attack_is_not_learnt_while_it_is_young(
    before: list[float], attack: list[float]
) -> None:
    """Whatever an attacker does in the newest 5 s, the scale is that of a calm flight."""
    calm, attacked = feed(scale(), [*before, *[1.0] * 5]), feed(scale(), before + attack)
    assert attacked.value == calm.value


@given(st.lists(st.floats(0.0, 1e12), min_size=1, max_size=30))
def test_an_attacker_raises_it_slowly(attack: list[float]) -> None:
    """A second at the clip of 3 weighs 8 more than at the scale: in n seconds (1 + 8/11)^(n/2)."""
    one = scale(delay_s=0.0)
    before = feed(one, [1.0] * 2).value
    for second, value in enumerate(attack, 2):
        one.add(second * SECOND, value)
        assert one.value <= before * math.sqrt(19.0 / 11.0) * (1.0 + 1e-12)
        before = one.value


@given(SQUARES)
def test_once_it_is_known_it_rises_by_2_percent_a_second(values: list[float]) -> None:
    """The first value of a series is not learnt: 32 make 31 s, one more than it takes."""
    one = feed(scale(delay_s=0.0), [1.0] * 33)
    assert one.value == pytest.approx(1.0)
    for second, value in enumerate(values, 33):
        before = one.value
        one.add(second * SECOND, value)
        assert one.value <= before * 1.02 * (1.0 + 1e-12)


def test_the_bound_on_its_rise_can_be_taken_off() -> None:
    one = feed(scale(delay_s=0.0, rise_per_s=math.inf), [1.0] * 33)
    assert feed(one, [9.0] * 3, 33).value > 1.05


def test_15_s_of_jamming_raise_it_by_a_third() -> None:
    one = feed(scale(memory_s=90.0, delay_s=8.0), [1.0] * 60)
    without = feed(scale(memory_s=90.0, delay_s=8.0, rise_per_s=math.inf), [1.0] * 60)
    raised = feed(one, [9.0] * 23, 60).value
    assert raised <= 1.02**15 * 1.001
    assert raised < feed(without, [9.0] * 23, 60).value


def test_what_goes_both_ways_is_learnt_faster_than_what_goes_one_way() -> None:
    """After 60 s of a quiet flight, 60 s with changes of one limit; 20 s pass until they count."""
    parts = {}
    for opposite in (0.0, 1.0):
        learned = LearnedLevel(0.5, 2.75, 2.0)
        for second in range(120):
            changing = 1.0 if second >= 60 else 0.0
            learned.add(second * SECOND, changing, moving=True, opposite=changing * opposite)
        parts[opposite] = learned.part
    assert parts[0.0] == pytest.approx(0.5 + 0.005 * 39, abs=0.02)
    assert parts[1.0] == pytest.approx(0.5 + 0.02 * 39, abs=0.05)


@pytest.mark.parametrize(("sigma", "scale"), [(0.1, 1.0), (0.25, 1.0), (0.5, 2.0), (2.0, 3.0)])
def test_a_scatter_becomes_that_of_the_innovations_within_its_bounds(
    sigma: float, scale: float
) -> None:
    innovations = np.random.default_rng(1).normal(0.0, sigma, 5000).tolist()
    one = Scatter(0.25, 3.0, delay_s=20.0, rise_s=200.0, fall_s=200.0)
    assert one.scale == 3.0
    for second, value in enumerate(innovations):
        one.add(second * SECOND, value, 1.0)
    assert one.scale == pytest.approx(scale, rel=0.1)


def test_a_scatter_grows_faster_than_it_shrinks_after_its_delay() -> None:
    """By hand: 0.25² to 1² with 40 s, one second at a time, and back with 200 s."""
    one = Scatter(0.25, 4.0, delay_s=20.0, rise_s=40.0, fall_s=200.0)
    for second in range(5000):
        one.add(second * SECOND, 0.25, 1.0)
    assert one.scale == pytest.approx(1.0, abs=1e-9)
    for second in range(5000, 5061):
        one.add(second * SECOND, 1.0, 1.0)
    grown = 1.0 - (1.0 - 0.0625) * (1.0 - 1.0 / 40.0) ** 40
    assert one.scale == pytest.approx(math.sqrt(grown) / 0.25)
    one.hold()
    for second in range(5061, 5082 + 40):
        one.add(second * SECOND, 0.0, 1.0)
    shrunk = grown * (1.0 - 1.0 / 200.0) ** 40
    assert one.scale == pytest.approx(math.sqrt(shrunk) / 0.25)
