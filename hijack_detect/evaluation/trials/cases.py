# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Flights to judge a method on: recorded or simulated, clean or attacked."""

from __future__ import annotations

import contextlib
import heapq
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from hijack_detect.analysis.log_clock import LogClock
from hijack_detect.bags.reader import BagReader
from hijack_detect.estimation.geodesy import separation_m
from hijack_detect.logs.formats import opened
from hijack_detect.monitor.graph import Monitor
from hijack_detect.monitor.policies import MonitorParameters
from hijack_detect.replay.offline import OfflineRun, run_offline, run_samples
from hijack_detect.replay.truth import Attack, attack_times, known_attack, truth_track
from hijack_detect.simulation.flight import Flight, generate_flight
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.spoofing.scenario import Scenario
from hijack_detect.spoofing.spoofer import Spoofer
from hijack_detect.streams.samples import NANOSECONDS, PressureSample, Sample

HIJACKED = "hijacked"
"""The class of every attacked flight."""
MAX_SCALE = 200
"""Most times the flights of a protocol: beyond that the seeds of one class would run into those of
the next."""
SETTLED_S = 12.0
"""The earliest onset: this long after forward flight began, or was commanded on a simulated one.
Chosen, not swept."""
OnOutput = Callable[[str, Any], None]
OnSample = Callable[[Sample], None]


@dataclass(frozen=True)
class CaseRun:
    """One flight after its run.

    Attributes:
        run: The monitor's outputs.
        attack: The attack on it, None if it is clean.
        end_ns: Stamp at which it ends, nanoseconds.
    """

    run: OfflineRun
    attack: Attack | None
    end_ns: int


class Case(Protocol):
    """One flight; it can be sent to another process."""

    @property
    def name(self) -> str:
        """Name in reports."""
        ...

    @property
    def kind(self) -> str:
        """Its class: `straight`, `curved`, `hijacked`, ..."""
        ...

    @property
    def injected(self) -> bool:
        """Whether it is a recorded flight with an attack put in."""
        ...

    @property
    def scenario(self) -> Scenario | None:
        """The attack that is put in, or that the simulated vehicle is flown with."""
        ...

    def run(
        self,
        parameters: MonitorParameters,
        *,
        on_sample: OnSample | None = None,
        on_output: OnOutput | None = None,
        clock: LogClock | None = None,
    ) -> CaseRun:
        """Run it through the monitor.

        Args:
            parameters: Parameters of every part.
            on_sample: Called with every sample.
            on_output: Called with part and output of everything that any part puts out.
            clock: Takes every sample of a log before the others do; the stamps of a simulated
                flight are right as they are.

        Raises:
            ValueError: The flight cannot be read or made; the text names it.
        """
        ...


def class_of(case: Case, attack: Attack | None) -> str:
    """The class of a flight, now that it is known whether it was attacked.

    Raises:
        ValueError: It is labelled as hijacked without a time.
    """
    if attack is None and case.kind == HIJACKED:
        raise ValueError(f"{case.name}: is labelled as hijacked, without a time")
    return case.kind if attack is None or case.scenario is not None else HIJACKED


@dataclass(frozen=True)
class CorpusLabel:
    """Entry of a folder's `labels.json` for one flight, times in seconds from its start.

    Attributes:
        vehicle: Name of the vehicle.
        attack: Start and end of the attack on it, None for none.
        alert_ok_from_s: From here on an alert is right, for a receiver that really failed.
    """

    vehicle: str
    attack: tuple[float, float] | None = None
    alert_ok_from_s: float | None = None


@dataclass(frozen=True)
class BagCase:
    """A flight in a bag or a log, with a scenario to inject, if any.

    The kind is `hijacked` for an attacked flight, or the name of its attack. `label` is that of
    the folder's `labels.json`; without it a `label.json` beside the flight counts.
    """

    path: Path
    name: str
    kind: str
    scenario: Scenario | None = None
    label: CorpusLabel | None = None

    def __repr__(self) -> str:
        """With the whole URL of a bag that is elsewhere, which its path does not have."""
        fields = (str(self.path), self.name, self.kind, self.scenario, self.label)
        return f"BagCase({', '.join(map(repr, fields))})"

    @contextlib.contextmanager
    def opened(self) -> Iterator[BagReader]:
        """The bag, or the one that is made of the log.

        Raises:
            BagError: It cannot be read.
        """
        with opened(self.path) as (reader, _):
            yield reader

    def attack_on(self, reader: BagReader) -> Attack | None:
        """Known attack: from the scenario, the folder's label, or the bag.

        Raises:
            BagError: The label beside the bag cannot be used, or the bag is damaged.
        """
        if self.scenario is not None or self.label is None:
            return known_attack(reader, self.scenario).attack
        if self.label.attack is None:
            return None
        start, end = (reader.start_ns + round(at * NANOSECONDS) for at in self.label.attack)
        return Attack(start, end)

    @property
    def injected(self) -> bool:
        """See Case."""
        return self.scenario is not None

    def run(
        self,
        parameters: MonitorParameters,
        *,
        on_sample: OnSample | None = None,
        on_output: OnOutput | None = None,
        clock: LogClock | None = None,
    ) -> CaseRun:
        """See Case."""
        with self.opened() as reader:
            attack = self.attack_on(reader)
            if clock is not None:
                clock.adopt_first = attack is None

            def take(sample: Sample) -> None:
                if clock is not None:
                    clock.take(sample, reader.at_ns)
                if on_sample is not None:
                    on_sample(sample)

            run = run_offline(
                reader,
                parameters,
                self.scenario,
                truth=truth_track(reader) if self.scenario is None else None,
                on_sample=take,
                on_output=on_output,
            )
            return CaseRun(run, attack, reader.end_ns)


def check_scale(scale: int) -> None:
    """Refuse a scale of a protocol. Raises ValueError: it is not within 1 to MAX_SCALE."""
    if not 1 <= scale <= MAX_SCALE:
        raise ValueError(f"scale is {scale}, it must be within 1 to {MAX_SCALE}")


@dataclass(frozen=True)
class SimulatedCase:
    """A flight of the closed-loop simulator: the spoofed GPS steers the vehicle."""

    name: str
    kind: str
    plan: FlightPlan
    seed: int
    scenario: Scenario | None = None

    @property
    def injected(self) -> bool:
        """See Case: the attack is part of this flight."""
        return False

    def run(
        self,
        parameters: MonitorParameters,
        *,
        on_sample: OnSample | None = None,
        on_output: OnOutput | None = None,
        clock: LogClock | None = None,
    ) -> CaseRun:
        """See Case."""
        start_ns, scenario = self.plan.start_ns, self.scenario
        receiver = None if scenario is None else Spoofer(scenario, start_ns)
        flight = generate_flight(self.plan, self.seed, receiver)
        run = OfflineRun(start_ns)
        run.separations = [
            (reported.stamp_ns, separation_m(measured, reported))
            for measured, reported in zip(flight.measured_fixes, flight.fixes, strict=True)
        ]
        monitor = Monitor(parameters)
        run_samples(flight_samples(flight), monitor, run, on_sample=on_sample, on_output=on_output)
        attack = None if scenario is None else attack_times(scenario, start_ns)
        return CaseRun(run, attack, start_ns + round(self.plan.duration_s * NANOSECONDS))


def flight_samples(flight: Flight) -> Iterator[tuple[str, Sample]]:
    """Input name and sample of a simulated flight, in order of stamp as a bag of it has them."""
    inputs: dict[str, Iterable[Sample]] = {
        "imu": flight.imu,
        "fix": flight.fixes,
        "velocity": flight.velocities,
        "mag": flight.magnetics,
        "satellites": flight.satellites,
        "pressure": [PressureSample(one.stamp_ns, one.value) for one in flight.pressures],
    }

    def stream(name: str) -> Iterator[tuple[int, str, Sample]]:
        return ((sample.stamp_ns, name, sample) for sample in inputs[name])

    for _, name, sample in heapq.merge(*map(stream, inputs), key=lambda entry: entry[0]):
        yield name, sample
