# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Outputs of the estimators over one flight, so that detectors can be run on it again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from hijack_detect.detectors.verdict import Verdict
from hijack_detect.evaluation.trials.cases import Case
from hijack_detect.monitor.graph import Component, Stage
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.truth import Attack
from hijack_detect.streams.samples import (
    NANOSECONDS,
    AttitudeSample,
    CourseSample,
    FixSample,
    Sample,
    VelocitySample,
)

ESTIMATORS = ("attitude", "course", "phase")


@dataclass(frozen=True)
class Recorded:
    """One flight as the detectors see it.

    Attributes:
        samples: Input name and sample, in order of arrival.
        attack: The attack on it, None if it is clean.
        start_ns: Stamp at which it starts, nanoseconds.
        end_ns: Stamp at which it ends, nanoseconds.
    """

    samples: list[tuple[str, Sample]]
    attack: Attack | None
    start_ns: int
    end_ns: int

    @property
    def hours(self) -> float:
        """Its length, hours."""
        return (self.end_ns - self.start_ns) / NANOSECONDS / 3600.0

    @property
    def attitudes(self) -> list[AttitudeSample]:
        """The attitudes, with the IMU's readings."""
        return [sample for _, sample in self.samples if isinstance(sample, AttitudeSample)]

    @property
    def courses(self) -> list[CourseSample]:
        """The courses."""
        return [sample for _, sample in self.samples if isinstance(sample, CourseSample)]


def record(case: Case, parameters: MonitorParameters) -> Recorded:
    """Run a flight through the monitor and keep what the detectors were given.

    Raises:
        ValueError: The flight cannot be read or made; the text names it.
    """
    samples: list[tuple[str, Sample]] = []

    def keep_input(sample: Sample) -> None:
        if isinstance(sample, FixSample):
            samples.append(("fix", sample))
        elif isinstance(sample, VelocitySample):
            samples.append(("velocity", sample))

    def keep_output(part: str, output: Any) -> None:
        if part in ESTIMATORS:
            samples.append((part, output))

    done = case.run(parameters, on_sample=keep_input, on_output=keep_output)
    return Recorded(samples, done.attack, done.run.start_ns, done.end_ns)


def judge(recorded: Recorded, make: Callable[[], Component]) -> list[Verdict]:
    """Run one detector over a recorded flight: as in the monitor, but for its last verdicts.

    Only the monitor knows that no input brings anything more.
    """
    stage = Stage(make)
    return [
        verdict
        for name, sample in recorded.samples
        if name in stage.component.inputs
        for verdict in stage.push(name, sample)
    ]
