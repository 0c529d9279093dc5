"""Runs a bag through the monitor without ROS: what the nodes would say, to the bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.detectors.fusion import FusionResult
from hijack_detect.detectors.verdict import Verdict
from hijack_detect.evaluation.graph import DETECTORS, Monitor, MonitorParameters
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import FixSample, Sample, VelocitySample


@dataclass
class OfflineRun:
    """Everything that was said about one bag."""

    start_ns: int
    """Log time of the bag's first message; scenario times count from here."""
    verdicts: dict[str, list[Verdict]] = field(default_factory=dict)
    """Verdicts of each detector, in order of stamp."""
    results: list[FusionResult] = field(default_factory=list)
    rejected: Rejected = field(default_factory=Rejected)
    separations: list[tuple[int, float]] = field(default_factory=list)
    """Stamp of each fix and metres between the true and the reported position."""

    def separation_at(self, stamp_ns: int) -> float:
        """Metres between true and reported position at the last fix up to a stamp."""
        before = [metres for stamp, metres in self.separations if stamp <= stamp_ns]
        return before[-1] if before else 0.0


def spoofed_samples(
    reader: BagReader,
    scenario: Scenario | None,
    run: OfflineRun,
    *,
    preset: str = "auto",
) -> Iterator[tuple[str, Sample]]:
    """Samples of a bag with a scenario applied; fills `rejected` and `separations` of the run.

    Raises:
        BagError: The bag cannot be read, or has no Imu or NavSatFix.
        ScenarioError: A segment lies outside the flight.
    """
    topics = reader.inputs(preset)
    spoofer = None
    if scenario is not None:
        scenario.check_within(reader.duration_s)
        spoofer = Spoofer(scenario, reader.start_ns)
    for name, sample in read_samples(reader, topics, on_rejected=run.rejected.add):
        if spoofer is None:
            yield name, sample
        elif isinstance(sample, FixSample):
            reported = spoofer.fix(sample)
            run.separations.append((sample.stamp_ns, spoofer.offset_m))
            yield name, reported
        elif isinstance(sample, VelocitySample):
            yield name, spoofer.velocity(sample)
        else:
            yield name, sample


def run_offline(
    reader: BagReader,
    parameters: MonitorParameters,
    scenario: Scenario | None = None,
    *,
    preset: str = "auto",
    on_sample: Callable[[Sample], None] | None = None,
) -> OfflineRun:
    """Run a bag through the monitor.

    Args:
        reader: The bag.
        parameters: Parameters of every part.
        scenario: Attacks to inject, if any.
        preset: Topic names, see `bags.topics`.
        on_sample: Called with every sample, for progress.

    Raises:
        BagError: The bag cannot be read, or has no Imu or NavSatFix.
        ScenarioError: A segment lies outside the flight.
    """
    run = OfflineRun(reader.start_ns, {name: [] for name in DETECTORS})
    monitor = Monitor(parameters)
    for name, sample in spoofed_samples(reader, scenario, run, preset=preset):
        if on_sample is not None:
            on_sample(sample)
        for part, output in monitor.push(name, sample):
            if part in run.verdicts:
                run.verdicts[part].append(output)
            elif part == "fusion":
                run.results.append(output)
    return run
