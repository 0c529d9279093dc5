# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Flights as samples in order of stamp, and carry-offs to put into them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hijack_detect.bags.samples import read_samples
from hijack_detect.logs.formats import opened
from hijack_detect.spoofing.scenario import Scenario, parse_scenario
from hijack_detect.streams.samples import Sample

ORDER = ("pressure", "imu", "velocity", "mag", "fix")
Samples = Sequence[tuple[str, Sample]]


def samples_of(path: Path, order: Sequence[str] = ORDER) -> tuple[int, Samples]:
    """Start (ns) and samples of a flight in order of stamp.

    Args:
        path: A bag, or a log of any format of `analyze`.
        order: The inputs that are read, as those of one stamp follow each other.

    Raises:
        BagError: It cannot be read.
    """
    with opened(path) as (reader, _):
        samples = [one for one in read_samples(reader, reader.inputs("auto")) if one[0] in order]
        start_ns = reader.start_ns
    return start_ns, sorted(samples, key=lambda one: (one[1].stamp_ns, order.index(one[0])))


def drift(acceleration: float, speed: float, bearing_deg: float, onset_s: float) -> Scenario:
    """A carry-off that builds up to a speed, from an onset to the flight's end."""
    model = {
        "type": "drift",
        "speed_m_s": speed,
        "onset_acceleration_m_s2": acceleration,
        "bearing_deg": bearing_deg,
    }
    return parse_scenario(
        {"segments": [{"name": "away", "start": onset_s, "model": model}]}, "away"
    )
