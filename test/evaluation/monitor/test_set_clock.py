# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A clock that is set in flight is no attack; one of the receiver alone may be."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import pytest

from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.evaluation.monitor.graph import Monitor
from hijack_detect.evaluation.monitor.offline import outputs_of
from hijack_detect.evaluation.monitor.policies import policy_parameters
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


def test_the_clock_of_the_receiver_alone(set_by: Callable[..., Sent]) -> None:
    said = results(set_by(-2.0, "fix", "velocity"))
    assert not any(one.alert for one in said)  # by itself it is innocent
    assert any("stepped by -2.0 s" in one.detectors["gnss"].reason for one in said[100:])
