# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The Poisson distribution against SciPy, and against exact arithmetic where SciPy loses digits."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.special import kl_div
from scipy.stats import nbinom, poisson

from hijack_detect.detectors.poisson import LOG_SMALLEST, divergence, log_pmf, mixed_divergence

COUNTS = st.integers(0, 10_000)
MEANS = st.floats(1e-3, 10_000.0)
FINITE = st.floats(0.0, 1.7e308)


@given(COUNTS, MEANS)
@example(0, 0.5)
@example(15, 15.0)
@example(16, 16.0)
def test_pmf_is_that_of_scipy(count: int, mean: float) -> None:
    assert math.exp(log_pmf(count, mean)) == pytest.approx(poisson.pmf(count, mean), abs=1e-12)


@pytest.mark.parametrize("mean", [0.1, 3.0, 15.0, 200.0, 5840.0])
def test_probabilities_add_up_to_one(mean: float) -> None:
    top = int(mean + 40.0 * math.sqrt(mean) + 40)
    total = math.fsum(math.exp(log_pmf(count, mean)) for count in range(top))
    assert total == pytest.approx(1.0, abs=1e-12)


@given(st.floats(1e-6, 1e9), st.floats(1e-6, 1e9))
def test_divergence_is_that_of_scipy(mean: float, other: float) -> None:
    # SciPy's own form cancels when the means are close: it has no digits below 1e-15 of them.
    tolerance = 4e-15 * (mean + other)
    assert divergence(mean, other) == pytest.approx(
        float(kl_div(mean, other)), rel=1e-13, abs=tolerance
    )


@pytest.mark.parametrize(("mean", "other"), [(3.0, 4.5), (0.1, 2.0), (15.0, 9.0)])
def test_divergence_is_the_sum_over_all_counts(mean: float, other: float) -> None:
    p, q = (poisson.pmf(np.arange(400), one) for one in (mean, other))
    kept = (p > 0.0) & (q > 0.0)
    total = math.fsum((p[kept] * np.log(p[kept] / q[kept])).tolist())
    assert divergence(mean, other) == pytest.approx(total, abs=1e-12)


@pytest.mark.parametrize(("mean", "other"), [(3.0, 4.5), (0.1, 2.0), (15.0, 9.0)])
@pytest.mark.parametrize("shape", [0.5, 2.0, 40.0])
def test_mixed_divergence_is_the_sum_over_all_counts(
    mean: float, other: float, shape: float
) -> None:
    counts = np.arange(3000)
    p, q = (nbinom.pmf(counts, shape, shape / (shape + one)) for one in (mean, other))
    kept = (p > 0.0) & (q > 0.0)
    total = math.fsum((p[kept] * np.log(p[kept] / q[kept])).tolist())
    assert mixed_divergence(mean, other, shape) == pytest.approx(total, abs=1e-12)


def test_a_mixture_that_does_not_scatter_is_poisson() -> None:
    assert mixed_divergence(3.0, 4.5, 1e12) == pytest.approx(divergence(3.0, 4.5), rel=1e-9)


@pytest.mark.parametrize("count", [900_000_000, 900_001_234, 1_800_000_000])
@pytest.mark.parametrize("away", [-30_000, -7, 0, 450, 100_000])
def test_pmf_of_a_longitude_is_exact(count: int, away: int) -> None:
    """In 1e-7 degrees counts are 1e9, where `x ln λ - λ - lgamma(x + 1)` has lost nine digits."""
    mean = count + away
    with localcontext() as context:
        context.prec = 60
        x, big = Decimal(count), Decimal(mean)
        pi = Decimal("3.14159265358979323846264338327950288419716939937510582097494")
        gamma = (x + Decimal("0.5")) * x.ln() - x + (2 * pi).ln() / 2
        gamma += 1 / (12 * x) - 1 / (360 * x**3) + 1 / (1260 * x**5)
        exact = x * big.ln() - big - gamma
    assert log_pmf(count, mean) == pytest.approx(float(exact), rel=1e-12)


@given(FINITE, FINITE)
@example(1.7e308, 5e-324)
@example(0.0, 1.7e308)
@example(5e-324, 0.0)
@example(1.6999997363084444e308, 1.699999999869202e308)
def test_no_input_overflows(x: float, mean: float) -> None:
    assert LOG_SMALLEST <= log_pmf(x, mean) <= 0.0 or x < 1.0
    assert math.isfinite(log_pmf(x, mean))


@given(FINITE, st.floats(1e-300, 1.7e308))
def test_a_divergence_is_finite_and_not_negative(mean: float, other: float) -> None:
    found = divergence(mean, other)
    assert 0.0 <= found < math.inf
    assert divergence(other, other) == 0.0
