# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Parameters of the nodes composed in one process."""

from __future__ import annotations

from dataclasses import dataclass

from hijack_detect.parameters import Parameters, param


@dataclass(frozen=True)
class CompositionParameters(Parameters):
    """What composed nodes publish beside hijack_alert."""

    publish_rate: float = param(
        50.0,
        "Intermediate topics (imu/data, verdicts, figures, hijack_confidence) are published at "
        "most so often, by stamp, and at every change of state; 0 publishes every output.",
        unit="Hz",
        low=0.0,
        high=10_000.0,
    )
