# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attacks one recorded flight many times, at the cost of little more than what is attacked.

The monitor runs over the clean flight once. Where an attack begins, it is copied as it is, and
the copy goes on with the attacked samples, for a minute or to the flight's end. Outputs of a copy
equal those of a whole run with the same scenario from there on, to the bit: before the
first sample that the attack can change, both have seen the same.
"""

from __future__ import annotations

import copy
import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Generic, Protocol, TypeVar

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import OfflineRun, run_samples
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.messages import Absence
from hijack_detect.streams.samples import (
    NANOSECONDS,
    FixSample,
    Sample,
    SatelliteSample,
    VelocitySample,
)

HORIZON_S = 60.0
"""Time for which an attack is followed. Chosen, not swept."""
GPS = (FixSample, VelocitySample, SatelliteSample)
"""Samples that an attack can change."""


class Attacked(Protocol):
    """An attack on the flight."""

    @property
    def onset_s(self) -> float:
        """Onset, seconds after the flight's first message."""
        ...

    @property
    def scenario(self) -> Scenario | None:
        """The attack; it must not begin before the onset. None goes on with the clean flight."""
        ...


A = TypeVar("A", bound=Attacked)


def run_forked(
    reader: BagReader,
    attacks: Sequence[A],
    parameters: MonitorParameters,
    *,
    horizon_s: float = HORIZON_S,
    on_clean: Callable[[str, Any], None] | None = None,
) -> Iterator[tuple[A, OfflineRun]]:
    """Run every attack from its onset on.

    A run holds the outputs from the sample on with which it began, which is up to the monitor's
    delay before the onset, until a sample beyond the horizon; it ends with the flight. Samples
    are kept for one horizon only, and one run at a time.

    Args:
        reader: The bag.
        attacks: The attacks, in any order.
        parameters: Parameters of every part of the monitor.
        horizon_s: How long after its onset an attack is followed, seconds.
        on_clean: Called with part and output of all outputs of the monitor on the clean flight.
            It is up to a horizon ahead of the runs.

    Yields:
        Each attack with its run, in order of onset.

    Raises:
        BagError: The bag cannot be read, or has no Imu or NavSatFix.
        ScenarioError: A segment lies outside the flight.
    """
    for attack in attacks:
        if attack.scenario is not None:
            attack.scenario.check_within(reader.duration_s)
    onsets = [
        _Onset(reader.start_ns, onset_s, list(group), horizon_s)
        for onset_s, group in itertools.groupby(
            sorted(attacks, key=lambda one: one.onset_s), key=lambda one: one.onset_s
        )
    ]
    monitor, followed = Monitor(parameters), list[_Onset[A]]()
    for name, sample in read_samples(reader, reader.inputs(), on_rejected=Rejected().add):
        if isinstance(sample, GPS):
            while onsets and sample.stamp_ns >= onsets[0].onset_ns:
                onsets[0].monitor = copy.deepcopy(monitor)
                followed.append(onsets.pop(0))
            for onset in onsets:
                onset.remember(sample)
        for onset in followed:
            onset.add(name, sample)
        while followed and followed[0].over:
            yield from followed.pop(0).runs()
        for part, output in monitor.push(name, [sample]):
            if on_clean is not None:
                on_clean(part, output)
    for onset in followed:
        yield from onset.runs()


class _Onset(Generic[A]):
    """The attacks that begin at one time, and the samples from there on."""

    def __init__(self, start_ns: int, onset_s: float, attacks: Sequence[A], horizon_s: float):
        self._start_ns = start_ns
        self.onset_ns = start_ns + round(onset_s * NANOSECONDS)
        self._end_ns = self.onset_ns + round(horizon_s * NANOSECONDS)
        self._attacks = [
            (one, None if one.scenario is None else _Reports(one.scenario, start_ns))
            for one in attacks
        ]
        self._samples: list[tuple[str, Sample]] = []
        self._beyond = 0
        self.monitor: Monitor | None = None

    def remember(self, sample: Sample) -> None:
        """Show the attacks what was true before them."""
        for _, reports in self._attacks:
            if reports is not None:
                reports.of(sample)

    def add(self, name: str, sample: Sample) -> None:
        """Keep a sample for the runs."""
        self._samples.append((name, sample))
        self._beyond = self._beyond + 1 if sample.stamp_ns > self._end_ns else 0

    @property
    def over(self) -> bool:
        """Whether the horizon has been passed: by two samples, as one may have a broken stamp."""
        return self._beyond > 1

    def runs(self) -> Iterator[tuple[A, OfflineRun]]:
        """Each attack on its own copy of the monitor."""
        for attack, reports in self._attacks:
            run = OfflineRun(self._start_ns)
            samples = self._attacked(reports, run)
            assert self.monitor is not None
            yield attack, run_samples(samples, copy.deepcopy(self.monitor), run)

    def _attacked(self, reports: _Reports | None, run: OfflineRun) -> Iterator[tuple[str, Sample]]:
        for name, sample in self._samples:
            if reports is None:
                yield name, sample
                continue
            changed = reports.of(sample)
            if isinstance(sample, FixSample):
                run.separations.append((sample.stamp_ns, reports.spoofer.offset_m))
            yield name, changed


class _Reports:
    """What one attack makes of the samples, as a monitor takes it."""

    def __init__(self, scenario: Scenario, start_ns: int) -> None:
        self.spoofer, self._absence = Spoofer(scenario, start_ns), Absence()

    def of(self, sample: Sample) -> Sample:
        """What is made of a sample of any input."""
        marked = self._absence(self.spoofer.report(sample))
        assert marked is not None
        return marked
