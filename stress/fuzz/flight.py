# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A flight whose messages are tampered with on their way into the monitor."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hijack_detect.bags.encoding import encode_sample
from hijack_detect.bags.reader import typestore
from hijack_detect.bags.samples import CONVERT
from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.evaluation.trials.cases import flight_samples
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import outputs_of
from hijack_detect.simulation.flight import generate_flight
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.streams.messages import BadMessage
from hijack_detect.streams.samples import (
    NANOSECONDS,
    AttitudeSample,
    CourseSample,
    PhaseSample,
    Sample,
    SatelliteSample,
)

BEGIN_S, FLIGHT_S = 40.0, 60.0
MOST_APART = 64
"""Messages from one that is tampered with to the next."""
VALUES = (
    *(0.0, -0.0, 5e-324, -1e-310, 1e-300, 1e-30, -1e-9, 0.1, -1.0, 9.8, 89.99999, 90.0, -180.0),
    *(180.0, 254.0, 999.9, -1e4, 1.2e5, 1e17, 1e160, -1.7e308, math.inf, -math.inf, math.nan),
)
STAMPS_NS = (
    0,
    1,
    -1,
    10**6,
    -(10**8),
    4 * 10**8,
    -(10**9),
    3 * 10**9,
    -6 * 10**9,
    10**18,
    -(10**18),
)
XYZ = ("x", "y", "z")
FIELDS = {
    "imu": tuple(f"{one}.{a}" for one in ("angular_velocity", "linear_acceleration") for a in XYZ),
    "fix": ("latitude", "longitude", "altitude", "position_covariance"),
    "velocity": tuple(f"twist.linear.{axis}" for axis in XYZ),
    "mag": tuple(f"magnetic_field.{axis}" for axis in XYZ),
    "pressure": ("fluid_pressure",),
    "satellites": ("data",),
}
"""Fields that can be changed, by input."""


def flown() -> list[tuple[str, Sample]]:
    """Samples of a clean flight with every sensor, in order of stamp."""
    return list(flight_samples(generate_flight(FlightPlan("curved", duration_s=FLIGHT_S), 1)))


class Flown:
    """Goes on from the middle of a flight; three bytes tamper with one message.

    How many messages go by before it, which field of it, and what becomes of that.
    """

    def __init__(self, _: Path) -> None:
        """Fly the first part, once."""
        sent = flown()
        begin_ns = sent[0][1].stamp_ns + round(BEGIN_S * NANOSECONDS)
        self._monitor = Monitor(MonitorParameters())
        first = [one for one in sent if one[1].stamp_ns < begin_ns]
        self._rest = sent[len(first) :]
        for _output in outputs_of(first, self._monitor):
            pass

    def __call__(self, data: bytes) -> bool:
        """Whether every message was accepted; all outputs must be numbers."""
        monitor = copy.deepcopy(self._monitor)
        refused = False
        for name, sample in self._tampered(data):
            if sample is None:
                refused = True
            else:
                for part, output in monitor.push(name, [sample]):
                    _check(part, output)
        return not refused

    def _tampered(self, data: bytes) -> Iterator[tuple[str, Any]]:
        """Input and sample; None for one that was refused."""
        at = 0
        for gap, field, value in zip(data[0::3], data[1::3], data[2::3], strict=False):
            upto = min(at + gap % MOST_APART, len(self._rest) - 1)
            yield from self._rest[at:upto]
            yield _with(*self._rest[upto], field, value)
            at = upto + 1
            if at == len(self._rest):
                return
        yield from self._rest[at : at + MOST_APART]


def _with(name: str, sample: Any, field: int, value: int) -> tuple[str, Any]:
    kind, data = encode_sample(sample)
    message = typestore().deserialize_cdr(data, kind)
    fields = FIELDS[name]
    if name != "satellites" and field % (len(fields) + 1) == len(fields):
        stamp_ns = max(0, sample.stamp_ns + STAMPS_NS[value % len(STAMPS_NS)])
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, NANOSECONDS)
    else:
        *outer, last = fields[field % len(fields)].split(".")
        holder = message
        for one in outer:
            holder = getattr(holder, one)
        given: Any = VALUES[value % len(VALUES)]
        if last == "position_covariance":
            given = np.full(9, given)
        setattr(holder, last, given)
    try:
        converted = CONVERT[name](message)
    except BadMessage:
        return name, None
    if name == "satellites":
        converted = SatelliteSample(sample.stamp_ns, converted)
    return name, converted


def _check(part: str, output: Any) -> None:
    if isinstance(output, Verdict):
        numbers = (output.score, output.threshold)
    elif isinstance(output, FusionResult):
        numbers = (output.confidence,)
    elif isinstance(output, AttitudeSample):
        numbers = output.orientation or ()
    elif isinstance(output, PhaseSample):
        numbers = (output.imu_rate_hz,)
    else:
        assert isinstance(output, CourseSample)
        numbers = (output.qz, output.qw)
    if not all(map(math.isfinite, numbers)):
        raise AssertionError(f"{part} puts out {output}")


def monitor_seeds(_: Path) -> list[bytes]:
    """Each field of many messages, with each value."""
    return [
        bytes(byte for gap in range(8) for byte in (7 + gap % 40, field, value + gap % 3))
        for field in range(7)
        for value in range(0, len(VALUES), 3)
    ]


def message_seeds(_: Path) -> list[bytes]:
    """One message of each input, after its number."""
    samples: dict[str, Sample] = {}
    for name, sample in flown():
        samples.setdefault(name, sample)
    names = list(CONVERT)
    return [
        bytes([names.index(name)]) + encode_sample(sample)[1] for name, sample in samples.items()
    ]
