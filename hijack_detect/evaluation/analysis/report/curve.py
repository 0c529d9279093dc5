"""A quantity over time, as the figures draw it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """One quantity over time: seconds from the bag's first message, NaN where it is unknown."""

    time_s: Array
    value: Array
