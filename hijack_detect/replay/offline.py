# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""A bag through the monitor without ROS: the verdicts of the nodes, to the bit."""

from __future__ import annotations

import bisect
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.truth import TruthTrack
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.messages import Absence
from hijack_detect.streams.samples import NANOSECONDS, FixSample, Sample

LONGEST_RUN_NS = NANOSECONDS // 2
"""Longest run of one input that is pushed at once. Chosen: far below the timeout of any other."""


@dataclass
class FlightNotes:
    """Notes on the samples of one bag."""

    start_ns: int
    """Log time of the bag's first message; scenario times count from here."""
    rejected: Rejected = field(default_factory=Rejected)
    absence: Absence = field(default_factory=Absence, compare=False)
    """Which components of the inputs were not measured."""
    separations: list[tuple[int, float]] = field(default_factory=list)
    """Stamp of each fix and metres between the true and the reported position."""

    def separation_at(self, stamp_ns: int) -> float:
        """Metres between true and reported position at the last fix up to a stamp."""
        index = bisect.bisect_right(self.separations, stamp_ns, key=lambda pair: pair[0])
        return self.separations[index - 1][1] if index else 0.0


@dataclass
class OfflineRun(FlightNotes):
    """All verdicts on one bag."""

    verdicts: dict[str, list[Verdict]] = field(default_factory=dict)
    """Verdicts of each detector, in order of stamp."""
    results: list[FusionResult] = field(default_factory=list)


def spoofed_samples(
    reader: BagReader,
    scenario: Scenario | None,
    flight: FlightNotes,
    *,
    preset: str = "auto",
    truth: TruthTrack | None = None,
) -> Iterator[tuple[str, Sample]]:
    """Samples of a bag with a scenario applied; fills the notes.

    Separations are those of the scenario; without one, those from the true track, if it is given.

    Raises:
        BagError: The bag cannot be read, or has no Imu or NavSatFix.
        ScenarioError: A segment lies outside the flight.
    """
    topics = reader.inputs(preset)
    spoofer = None
    if scenario is not None:
        scenario.check_within(reader.duration_s)
        spoofer = Spoofer(scenario, reader.start_ns)
    seen = Absence()  # what a node makes of the messages that were spoofed
    for name, sample in read_samples(
        reader, topics, on_rejected=flight.rejected.add, absence=flight.absence
    ):
        if spoofer is None:
            if truth is not None and isinstance(sample, FixSample) and sample.has_fix:
                flight.separations.append((sample.stamp_ns, truth.separation_m(sample)))
            yield name, sample
            continue
        reported = seen(spoofer.report(sample))
        assert reported is not None
        if isinstance(sample, FixSample):
            flight.separations.append((sample.stamp_ns, spoofer.offset_m))
        yield name, reported


def outputs_of(
    samples: Iterable[tuple[str, Sample]],
    monitor: Monitor,
    *,
    on_sample: Callable[[Sample], None] | None = None,
) -> Iterator[tuple[str, Any]]:
    """Part and output of everything that the parts of a monitor put out.

    Args:
        samples: Input name and sample, in order of arrival.
        monitor: A fresh monitor.
        on_sample: Called with every sample before it is pushed.
    """
    for name, some in runs_of(samples):
        if on_sample is not None:
            for sample in some:
                on_sample(sample)
        yield from monitor.push(name, some)


def runs_of(samples: Iterable[tuple[str, Sample]]) -> Iterator[tuple[str, list[Sample]]]:
    """Successive samples of one input together, over less than LONGEST_RUN_NS."""
    run: list[Sample] = []
    of = ""
    for name, sample in samples:
        if run and (name != of or not 0 < sample.stamp_ns - run[0].stamp_ns < LONGEST_RUN_NS):
            yield of, run
            run = []
        of = name
        run.append(sample)
    if run:
        yield of, run


def run_samples(
    samples: Iterable[tuple[str, Sample]],
    monitor: Monitor,
    run: OfflineRun,
    *,
    on_sample: Callable[[Sample], None] | None = None,
    on_output: Callable[[str, Any], None] | None = None,
) -> OfflineRun:
    """Feed samples to a monitor and keep in `run` the verdicts of its detectors and fusion.

    Args:
        samples: See `outputs_of`.
        monitor: A fresh monitor.
        run: Where to keep it; also returned.
        on_sample: See `outputs_of`.
        on_output: Called with part and output of everything that any part puts out.
    """
    run.verdicts = {name: [] for name in monitor.detectors}
    for part, output in outputs_of(samples, monitor, on_sample=on_sample):
        if part in run.verdicts:
            run.verdicts[part].append(output)
        elif part == "fusion":
            run.results.append(output)
        if on_output is not None:
            on_output(part, output)
    return run


def run_offline(
    reader: BagReader,
    parameters: MonitorParameters,
    scenario: Scenario | None = None,
    *,
    preset: str = "auto",
    truth: TruthTrack | None = None,
    on_sample: Callable[[Sample], None] | None = None,
    on_output: Callable[[str, Any], None] | None = None,
) -> OfflineRun:
    """Run a bag through the monitor.

    Args:
        reader: The bag.
        parameters: Parameters of every part.
        scenario: Attacks to inject, if any.
        preset: Topic names, see `bags.topics`.
        truth: Where the vehicle was, for the separations of an attack that is in the bag.
        on_sample: See `outputs_of`.
        on_output: See `run_samples`.

    Raises:
        BagError: The bag cannot be read, or has no Imu or NavSatFix.
        ScenarioError: A segment lies outside the flight.
    """
    run = OfflineRun(reader.start_ns)
    samples = spoofed_samples(reader, scenario, run, preset=preset, truth=truth)
    monitor = Monitor(parameters)
    return run_samples(samples, monitor, run, on_sample=on_sample, on_output=on_output)
