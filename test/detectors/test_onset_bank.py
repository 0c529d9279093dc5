# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The bank of onsets against the Kalman filter itself: once clean, and once with an offset."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hijack_detect.detectors.onset_bank import OnsetBank
from hijack_detect.estimation.kalman import update

STEPS = 8


@given(
    states=st.integers(1, 4),
    offsets=st.integers(1, 3),
    begins=st.integers(0, 3),
    seed=st.integers(0, 2**32 - 1),
)
def test_sizes_are_those_of_the_filter_that_was_deceived(
    states: int, offsets: int, begins: int, seed: int
) -> None:
    """The clean filter sees no innovation, so all that shows is the offset, and it is exact."""
    rng = np.random.default_rng(seed)
    size = rng.normal(size=offsets)
    begun, growing = rng.normal(size=(2, states, offsets))
    bank, x, P = OnsetBank(begun, growing), np.zeros(states), np.eye(states)
    m = 3
    for step in range(STEPS):
        phi = np.eye(states) + 0.1 * rng.normal(size=(states, states))
        H, shape = rng.normal(size=(m, states)), rng.normal(size=(m, offsets))
        dt, since = float(rng.uniform(0.1, 1.0)), step > begins
        P = phi @ P @ phi.T + 0.1 * np.eye(states)
        x = phi @ x + since * dt * growing @ size
        bank.propagate(dt, phi)
        # The true state is 0 and the measurement has no noise: the clean filter stays at 0.
        found, P = update(P, H, since * shape @ size - H @ x, np.full(m, 0.5))
        x = x + found.correction
        bank.measure(found, np.repeat(shape[:, None], len(bank.age_s), axis=1))
        if step == begins:
            x = x + begun @ size
            bank.begin()
    assert len(bank.age_s) == 1
    np.testing.assert_allclose(bank.c[0] @ size, bank.d[0], rtol=1e-6, atol=1e-9)


def test_onsets_beyond_an_age_are_forgotten() -> None:
    bank = OnsetBank(np.zeros((2, 1)), np.zeros((2, 1)))
    for _ in range(5):
        bank.begin()
        bank.propagate(1.0, np.eye(2))
    bank.forget(3.0)
    np.testing.assert_array_equal(bank.age_s, [3.0, 2.0, 1.0])
    bank.propagate(0.5, np.eye(2), oldest_s=3.0)
    np.testing.assert_array_equal(bank.age_s, [2.5, 1.5])
    assert (bank.d.shape, bank.c.shape) == ((2, 1), (2, 1, 1))
