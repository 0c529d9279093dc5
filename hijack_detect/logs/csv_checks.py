# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Whether a reading of a table can be true: a wrong unit or column shows here."""

from __future__ import annotations

from collections.abc import Iterator

from hijack_detect.streams.messages import Limited, limited
from hijack_detect.streams.samples import Quaternion, Sample

WORDS = {
    "angular_velocity": "gyro",
    "linear_acceleration": "accel",
    "magnetic_field": "field",
    "fluid_pressure": "pressure",
    "satellites": "count",
}
"""What a column map calls the fields of messages, where it is another word."""


def impossible(reading: Sample | Quaternion) -> str:
    """What no sensor can mean in a reading, empty if there is nothing."""
    for field, value, unit, low, high in _numbers(reading):
        if not low <= value <= high:
            name = field.split(".")[0]
            shown = f"{value:g} {unit}, beyond {low:g} to {high:g}"
            return f"{WORDS.get(name, name)} would be {shown}"
    return ""


def _numbers(reading: Sample | Quaternion) -> Iterator[Limited]:
    if not isinstance(reading, tuple):
        yield from limited(reading)
        return
    for value in reading:
        yield Limited("quaternion", value, "", -1.001, 1.001)
