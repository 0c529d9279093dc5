# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The Poisson distribution in log space, exact to rounding from 0 to 1e15 and beyond.

`x ln λ - λ - lgamma(x + 1)` loses digits as x grows: nine of them at the 1e9 of a longitude in
1e-7 degrees. Loader's form (Fast and accurate computation of binomial probabilities, 2000) has
no large terms that cancel.
"""

from __future__ import annotations

import math
import sys

LOG_SMALLEST = math.log(5e-324)
"""Logarithm of the smallest positive number: no probability is taken as smaller."""
_STIRLING = (1 / 12, -1 / 360, 1 / 1260, -1 / 1680, 1 / 1188)


def log_pmf(x: float, mean: float) -> float:
    """Logarithm of `λ^x e^(-λ) / Γ(x + 1)`, not below `LOG_SMALLEST` (Basan 2022, Eqs. 1-6).

    Args:
        x: Value, real and not negative; whole numbers give the Poisson distribution.
        mean: λ, not negative.
    """
    if x == 0.0:
        return max(-mean, LOG_SMALLEST)
    if mean == 0.0:
        return LOG_SMALLEST
    exponent = -_stirling_error(x) - divergence(x, mean)
    return max(exponent - 0.5 * (math.log(math.tau) + math.log(x)), LOG_SMALLEST)


def divergence(mean: float, other: float) -> float:
    """Kullback-Leibler divergence of Poisson(mean) from Poisson(other), in nats.

    `D = λ ln(λ / λ') + λ' - λ`, the sum of `P ln(P / P')` over all counts.

    Args:
        mean: λ, not negative.
        other: λ', above 0.
    """
    difference, total = mean - other, mean + other
    if mean == 0.0:
        return other
    if abs(difference) < 0.1 * total < math.inf:
        return _near(mean, difference, difference / total)
    found = mean * (math.log(mean) - math.log(other)) - difference
    return min(max(found, 0.0), sys.float_info.max)  # near the largest numbers, rounding is all


def mixed_divergence(mean: float, other: float, shape: float) -> float:
    """The same of negative binomial distributions, nats: Poisson with a mean that itself scatters.

    `D = λ ln(λ (λ' + k) / (λ' (λ + k))) + k ln((λ' + k) / (λ + k))`; the variance of the counts is
    λ + λ² / k. For a large k it is the divergence of the Poisson distributions.

    Args:
        mean: λ, not negative.
        other: λ', above 0.
        shape: k, above 0, the same for both.
    """
    mixed = divergence(mean, other) - divergence(mean + shape, other + shape)
    return max(mixed, 0.0)  # rounding of two nearly equal numbers


def _near(mean: float, difference: float, ratio: float) -> float:
    """The divergence of two means that are close, as a series in their relative difference."""
    result, term, square = difference * ratio, 2.0 * (mean * ratio), ratio * ratio
    for order in range(3, 1000, 2):
        term *= square
        before, result = result, result + term / order
        if result == before:
            break
    return result


def _stirling_error(x: float) -> float:
    """`ln Γ(x + 1) - ((x + 1/2) ln x - x + ln(2π) / 2)`."""
    if x < 16.0:
        approximation = (x + 0.5) * math.log(x) - x + 0.5 * math.log(math.tau)
        return math.lgamma(x + 1.0) - approximation
    square = x * x
    result = 0.0
    for coefficient in reversed(_STIRLING):
        result = result / square + coefficient
    return result / x
