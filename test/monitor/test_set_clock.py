# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A clock that is set in flight is no attack, neither that behind all stamps nor the receiver's."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import pytest

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.replay.offline import outputs_of
from hijack_detect.streams.samples import NANOSECONDS, Sample

Sent = list[tuple[str, Sample]]
INPUTS = ("imu", "fix", "velocity", "mag")
SET_S, FLIGHT_S = 45.0, 60.0


def results(sent: Sent) -> list[FusionResult]:
    monitor = Monitor(policy_parameters("default"))
    return [output for part, output in outputs_of(sent, monitor) if part == "fusion"]


@pytest.fixture
def set_by(samples: Callable[..., Sent], flight: Callable[..., object]) -> Callable[..., Sent]:
    def shifted(seconds: float, *names: str) -> Sent:
        sent = samples(flight("curved", 8, FLIGHT_S), *INPUTS)
        at_ns = sent[0][1].stamp_ns + round(SET_S * NANOSECONDS)
        shift_ns = round(seconds * NANOSECONDS)
        return [
            (name, dataclasses.replace(sample, stamp_ns=sample.stamp_ns + shift_ns))
            if name in names and sample.stamp_ns >= at_ns
            else (name, sample)
            for name, sample in sent
        ]

    return shifted


@pytest.mark.parametrize("seconds", [-4.0, -1.0, -0.3, 1.0])
def test_the_clock_behind_all_stamps(set_by: Callable[..., Sent], seconds: float) -> None:
    said = results(set_by(seconds, *INPUTS))
    assert not any(one.alert for one in said)
    assert said[-1].state.name in ("NORMAL", "NOT_READY")  # 20 s of flight after the restart


@pytest.mark.parametrize("seconds", [-2.0, 0.5, 18.0])
def test_the_clock_of_the_receiver_alone(set_by: Callable[..., Sent], seconds: float) -> None:
    """It is named, and changes nothing else that is said."""
    usual, monitor = results(set_by(0.0)), Monitor(policy_parameters("default"))
    outputs = list(outputs_of(set_by(seconds, "fix", "velocity"), monitor))
    said = [output for part, output in outputs if part == "fusion"]
    assert [(one.stamp_ns, one.alert) for one in said] == [
        (one.stamp_ns, one.alert) for one in usual
    ]
    reasons = [output.reason for part, output in outputs if part == "gnss"]
    assert any(f"time stepped by {seconds:+.1f} s" in reason for reason in reasons)
