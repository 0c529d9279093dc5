# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How long who hears sensors waits for one that has gone silent: a parameter of each of them."""

from __future__ import annotations

from typing import Any

from hijack_detect.parameters import param
from hijack_detect.streams.merge import SENSOR_PATIENCE_S


def sensor_patience() -> Any:
    """Declare how long a part that hears sensors waits for one of them."""
    return param(
        SENSOR_PATIENCE_S,
        "How long to wait for a sensor that has gone silent, on the stamps of the others. For "
        "replays faster than real time far larger.",
        unit="s",
        low=SENSOR_PATIENCE_S,
        high=3600.0,
    )
