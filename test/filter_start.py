# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How the filters of the tests start: level, and with these deviations and noises."""

from __future__ import annotations

import numpy as np

from hijack_detect.estimation.ekf import ProcessNoise

LEVEL = (0.0, 0.0, 0.0, 1.0)
SIGMAS = np.array([1.0] * 3 + [0.5] * 3 + [0.05, 0.05, 0.2] + [0.1] * 3 + [0.005] * 3)
NOISE = ProcessNoise(accel=0.1, gyro=0.003, accel_bias=0.005, gyro_bias=0.0007)
