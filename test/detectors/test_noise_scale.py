"""What a vehicle's noise is taken for, by hand."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.detectors.noise_scale import NoiseScale

SECOND = 10**9


def scale(**changed: float) -> NoiseScale:
    given_ = {"delay_s": 5.0, "memory_s": 1e9, "prior_s": 10.0, "clip": 3.0, **changed}
    return NoiseScale(0.3, 3.0, **given_)


def test_the_mean_square_by_hand() -> None:
    """The prior of 1 weighs 10 s; 10 values of 4 over 1 s each: sqrt((10 + 40) / 20)."""
    one = scale()
    for second in range(17):
        one.add(second * SECOND, 4.0)
    assert one.value == pytest.approx(math.sqrt(50.0 / 20.0))


def test_what_is_younger_than_the_delay_is_not_learnt() -> None:
    one = scale()
    for second in range(5):
        one.add(second * SECOND, 1e6)
    assert one.value == 1.0


def test_what_is_held_is_never_learnt() -> None:
    one = scale()
    for second in range(100):
        one.add(second * SECOND, 1e6)
        one.hold()
    assert one.value == 1.0


def test_a_single_value_counts_no_more_than_the_clip() -> None:
    """The second of two values is learnt: 1 s of 9 instead of a million."""
    one = scale()
    one.add(0, 1.0)
    one.add(SECOND, 1e6)
    one.add(7 * SECOND, 1.0)
    assert one.value == pytest.approx(math.sqrt(19.0 / 11.0))


@given(st.lists(st.floats(0.0, 1e12), max_size=50))
def test_it_stays_within_its_bounds(values: list[float]) -> None:
    one = scale(prior_s=0.1)
    for second, value in enumerate(values):
        one.add(second * SECOND, value)
        assert 0.3 <= one.value <= 3.0
