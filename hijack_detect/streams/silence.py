# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""How long an input may be silent, on stamps: what an outage is, and how long it is waited for."""

from __future__ import annotations

from typing import Any

from hijack_detect.parameters import param

SILENCE_S = 2.0
"""An input without a sample for this long, on its own stamps, has had an outage.
Chosen, not swept."""
SKEW_S = 1.0
"""After an outage the samples of this time are left out: whether they arrive before the other
inputs have moved on is a matter of luck. Chosen, not swept."""
RESTART_S = 5.0
"""A clock that runs back by more than this is that of a new recording. Chosen, not swept."""
SENSOR_PATIENCE_S = SILENCE_S + SKEW_S
"""How long to wait for a sensor that has gone silent, on the stamps of the other inputs."""


def sensor_patience() -> Any:
    """Declare how long a part waits for a sensor that is silent."""
    return param(
        SENSOR_PATIENCE_S,
        "How long to wait for a sensor that has gone silent, on the stamps of the others. For "
        "replays faster than real time far larger.",
        source="what counts as an outage (2 s), and the skew of what comes after it (1 s)",
        unit="s",
        low=SENSOR_PATIENCE_S,
        high=3600.0,
    )
