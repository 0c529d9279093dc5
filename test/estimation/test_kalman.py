# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The Kalman update against least squares over the prior and all measurements at once."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from hijack_detect.estimation.kalman import update
from hijack_detect.estimation.rotation import Array


def covariance(rng: np.random.Generator, n: int) -> Array:
    """Of correlated states whose standard deviations lie between 0.01 and 100."""
    root = rng.normal(size=(n, 2 * n)) * 10.0 ** rng.uniform(-2.0, 2.0, (n, 1))
    return np.asarray(root @ root.T / (2 * n))


@given(
    n=st.integers(1, 8),
    sizes=st.lists(st.integers(1, 3), min_size=1, max_size=4),
    seed=st.integers(0, 2**32 - 1),
)
def test_updates_one_by_one_are_the_least_squares_over_all(
    n: int, sizes: list[int], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    prior = covariance(rng, n)
    sigmas = np.sqrt(np.diag(prior))
    rows = [rng.normal(size=(m, n)) / sigmas for m in sizes]
    variances = [10.0 ** rng.uniform(-2.0, 2.0, m) for m in sizes]
    measured = [rng.normal(size=m) for m in sizes]

    x, P = np.zeros(n), prior
    for H, z, R in zip(rows, measured, variances, strict=True):
        found, P = update(P, H, z - H @ x, R)
        x = x + found.correction

    # Prior and measurements as equations of unit variance; the prior says that x is 0.
    whiten = np.linalg.inv(np.linalg.cholesky(prior))
    noise = np.sqrt(np.concatenate(variances))
    equations = np.vstack([whiten, np.vstack(rows) / noise[:, None]])
    right = np.concatenate([np.zeros(n), np.concatenate(measured) / noise])
    expected = np.linalg.lstsq(equations, right, rcond=None)[0]
    inverse = np.linalg.pinv(equations)
    np.testing.assert_allclose(x / sigmas, expected / sigmas, atol=1e-6)
    scale = np.outer(sigmas, sigmas)
    np.testing.assert_allclose(P / scale, inverse @ inverse.T / scale, atol=1e-6)


@given(n=st.integers(1, 8), m=st.integers(1, 3), seed=st.integers(0, 2**32 - 1))
def test_the_innovation_is_as_likely_as_its_normal_density(n: int, m: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    P, H, R = covariance(rng, n), rng.normal(size=(m, n)), rng.uniform(0.1, 10.0, m)
    residual = rng.normal(size=m)
    before = P.copy()
    found, _ = update(P, H, residual, R)
    density = multivariate_normal(np.zeros(m), H @ P @ H.T + np.diag(R)).logpdf(residual)
    constant = -0.5 * m * np.log(2.0 * np.pi)
    assert np.isclose(found.log_likelihood() + constant, density, rtol=1e-6)
    np.testing.assert_array_equal(P, before)


def test_a_nearly_exact_measurement_leaves_a_valid_covariance() -> None:
    P = np.diag([1e8, 1e8]) + 9.9e7 * (1.0 - np.eye(2))
    for _ in range(100):
        _, P = update(P, np.array([[1.0, 1.0]]), np.zeros(1), np.array([1e-8]))
    np.testing.assert_allclose(P, P.T, rtol=1e-12)
    assert np.linalg.eigvalsh(P)[0] > 0.0
