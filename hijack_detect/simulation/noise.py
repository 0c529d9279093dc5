# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Random signals with memory."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def gauss_markov(white: Array, time_constant_s: float, rate_hz: float) -> Array:
    """Turn unit white noise into a first-order Gauss-Markov process of unit deviation.

    x[k] = c x[k-1] + sqrt(1 - c²) white[k], c = exp(-1 / (time_constant_s rate_hz)), and x[0] =
    white[0], so the process is stationary from its first sample on.

    Args:
        white: Independent samples of unit deviation, shape (n, m).
        time_constant_s: Time after which the correlation has fallen to 1/e, seconds.
        rate_hz: Samples a second.

    Returns:
        The process, shape (n, m).
    """
    keep = math.exp(-1.0 / (time_constant_s * rate_hz))
    add = math.sqrt(1.0 - keep * keep)
    columns = []
    for column in white.T.tolist():
        value = column[0]
        signal = [value]
        for sample in column[1:]:
            value = keep * value + add * sample
            signal.append(value)
        columns.append(signal)
    return np.array(columns).T


def random_walk(white: Array, per_root_second: float, rate_hz: float) -> Array:
    """Sum unit white noise (n, m) to a walk from zero with this deviation after one second."""
    steps = white * (per_root_second / math.sqrt(rate_hz))
    steps[0] = 0.0
    return np.cumsum(steps, axis=0)
