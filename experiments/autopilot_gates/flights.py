# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Flights to try the gates on; each can be sent to another process."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from experiments.autopilot_gates.ardupilot import ArduPilotFilter
from experiments.autopilot_gates.attacks import ATTACK_S, drift, scenarios
from experiments.autopilot_gates.epochs import Epochs, cut, recorded_headings
from experiments.autopilot_gates.gate_filter import GateFilter, Judged
from experiments.autopilot_gates.outcome import Clean, Outcome, alarms, clean
from experiments.autopilot_gates.px4 import Px4Filter
from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.estimation.geodesy import separation_m
from hijack_detect.evaluation.trials.cases import SETTLED_S, flight_samples
from hijack_detect.evaluation.trials.onsets import forward_flight, seeded_onsets
from hijack_detect.replay.truth import label_attack, read_label, truth_track
from hijack_detect.simulation.flight import generate_flight
from hijack_detect.simulation.plan import FlightPlan, forward_end_s, forward_start_s
from hijack_detect.spoofing.scenario import Scenario, parse_scenario
from hijack_detect.spoofing.spoofer import RECENT, Spoofer
from hijack_detect.streams.samples import NANOSECONDS

GATES: Mapping[str, type[GateFilter]] = {"PX4": Px4Filter, "ArduPilot": ArduPilotFilter}
ONSETS = 10
"""Chosen, not swept."""
NO_ATTACK = "no attack"
SIMULATED_ATTACK = "drift 0.4 m/s² to 4 m/s"
SIMULATED_ATTACK_S = 30.0
"""Chosen, not swept."""


@dataclass
class Results:
    """What came out of one flight."""

    outcomes: list[Outcome] = field(default_factory=list)
    clean: list[Clean] = field(default_factory=list)


@dataclass(frozen=True)
class LabelledFlight:
    """A flight of a real autopilot in the loop; if it was attacked, its GPS is spoofed already."""

    path: Path

    @property
    def name(self) -> str:
        """Name of the bag."""
        return self.path.name

    def run(self) -> Results:
        """Run both gates over the flight.

        Raises:
            ValueError: The bag cannot be read.
        """
        with BagReader(self.path) as reader:
            samples = [one for _, one in read_samples(reader, reader.inputs())]
            truth, label, start_ns = truth_track(reader), read_label(reader.path), reader.start_ns
        epochs = cut(samples)
        attack = None if label is None else label_attack(label, start_ns)
        if attack is None or label is None:
            return Results(clean=[clean(self.name, g, j) for g, j in flown(epochs).items()])
        assert truth is not None
        offsets = [truth.separation_m(one.fix) for one in epochs.items]
        named = label["attack"]
        sizes = " ".join(f"{key} {value:g}" for key, value in named["params"].items())
        return one_attack(
            self.name,
            f"{named['kind']}: {sizes}",
            epochs,
            offsets,
            (start_ns, attack.onset_ns, attack.end_ns),
        )


@dataclass(frozen=True)
class SimulatedFlight:
    """A flight of the project's simulator, dragged off in closed loop; odd seeds fly turns."""

    seed: int

    @property
    def name(self) -> str:
        """What it is called in reports."""
        return f"simulated_{self.seed}"

    def run(self) -> Results:
        """Run both gates over the flight."""
        plan = FlightPlan("curved" if self.seed % 2 else "straight")
        rng = np.random.default_rng(self.seed)
        last_s = forward_end_s(plan) - SIMULATED_ATTACK_S
        onset_s = round(rng.uniform(forward_start_s(plan) + SETTLED_S, last_s), 1)
        model = drift(0.4, 4.0, 90.0 * (self.seed // 2 % 4))
        scenario = parse_scenario({"segments": [{"start": onset_s, "model": model}]})
        flight = generate_flight(plan, self.seed, Spoofer(scenario, plan.start_ns))
        epochs = cut(sample for _, sample in flight_samples(flight))
        off = {
            reported.stamp_ns: separation_m(measured, reported)
            for measured, reported in zip(flight.measured_fixes, flight.fixes, strict=True)
        }
        offsets = [off[one.stamp_ns] for one in epochs.items]
        onset_ns = plan.start_ns + round(onset_s * NANOSECONDS)
        times = (plan.start_ns, onset_ns, None)
        return one_attack(self.name, SIMULATED_ATTACK, epochs, offsets, times)


@dataclass(frozen=True)
class RecordedFlight:
    """A clean recorded flight, attacked at seeded onsets in its forward flight.

    There is no barometer in it: the altitude before the attack stands for one. There is no
    magnetometer in it: the heading of the recording autopilot stands for one.
    """

    path: Path

    @property
    def name(self) -> str:
        """Name of the bag."""
        return self.path.name

    def run(self) -> Results:
        """Run both gates over the flight, then over each attack from a copy at its onset.

        Raises:
            ValueError: The bag cannot be read.
        """
        with BagReader(self.path) as reader:
            topics = reader.inputs()
            read = read_samples(reader, topics, on_rejected=Rejected().add)
            epochs = cut([one for _, one in read], recorded_headings(reader))
            spans, start_ns = forward_flight(reader), reader.start_ns
            latest_s = reader.duration_s - ATTACK_S
        onsets = seeded_onsets(spans, latest_s, ONSETS, self.name)
        indices = [epochs.first_from(start_ns + round(s * NANOSECONDS)) for s in onsets]
        copies: dict[int, dict[str, GateFilter]] = {}
        judged = flown(epochs, copies, indices)
        results = Results(clean=[clean(self.name, gate, ones) for gate, ones in judged.items()])
        for number, (onset_s, index) in enumerate(zip(onsets, indices, strict=True)):
            onset_ns = start_ns + round(onset_s * NANOSECONDS)
            before = {gate: ones[:index] for gate, ones in judged.items()}
            if not all(ones and ones[-1].settled for ones in before.values()):
                continue
            end = epochs.first_from(onset_ns + round(ATTACK_S * NANOSECONDS))
            untouched = {gate: ones[index:end] for gate, ones in judged.items()}
            quiet = [0.0] * (end - index)
            results.outcomes += self._outcomes(
                NO_ATTACK, onset_s, onset_ns, before, untouched, quiet
            )
            for name, scenario in scenarios(onset_s, number).items():
                attacked, offsets = _attacked(
                    epochs, index, scenario, start_ns, copy.deepcopy(copies[index])
                )
                results.outcomes += self._outcomes(
                    name, onset_s, onset_ns, before, attacked, offsets
                )
        return results

    def _outcomes(
        self,
        attack: str,
        onset_s: float,
        onset_ns: int,
        before: Mapping[str, Sequence[Judged]],
        during: Mapping[str, Sequence[Judged]],
        offsets: Sequence[float],
    ) -> list[Outcome]:
        return [
            outcome(self.name, attack, gate, (onset_s, onset_ns), before[gate], ones, offsets)
            for gate, ones in during.items()
        ]


Flight = LabelledFlight | RecordedFlight | SimulatedFlight


def run(flight: Flight) -> Results:
    """Run one flight, in any process.

    Raises:
        ValueError: A bag cannot be read.
    """
    return flight.run()


def flown(
    epochs: Epochs,
    copies: dict[int, dict[str, GateFilter]] | None = None,
    at: Sequence[int] = (),
) -> dict[str, list[Judged]]:
    """Run both gates over a whole flight.

    Args:
        epochs: The flight.
        copies: Filled with copies of the filters from before each wanted epoch.
        at: Indices of these epochs.
    """
    filters = {name: make() for name, make in GATES.items()}
    judged: dict[str, list[Judged]] = {name: [] for name in filters}
    for index, epoch in enumerate(epochs.items):
        if copies is not None and index in at:
            copies[index] = copy.deepcopy(filters)
        position = epochs.frame.enu(epoch.fix)
        for name, gate in filters.items():
            judged[name].append(gate.step(epoch, position, epoch.velocity.velocity))
    return judged


def _attacked(
    epochs: Epochs,
    index: int,
    scenario: Scenario,
    start_ns: int,
    filters: Mapping[str, GateFilter],
) -> tuple[dict[str, list[Judged]], list[float]]:
    """Run copies of the filters on from an onset to the attack's end."""
    spoofer = Spoofer(scenario, start_ns)
    for epoch in epochs.items[max(index - RECENT, 0) : index]:
        spoofer.fix(epoch.fix)
        spoofer.velocity(epoch.velocity)
    judged: dict[str, list[Judged]] = {name: [] for name in filters}
    offsets = []
    for epoch in epochs.items[index:]:
        if not spoofer.active(epoch.stamp_ns):
            break
        position = epochs.frame.enu(spoofer.fix(epoch.fix))
        velocity = spoofer.velocity(epoch.velocity).velocity
        offsets.append(spoofer.offset_m)
        for name, gate in filters.items():
            judged[name].append(gate.step(epoch, position, velocity))
    return judged, offsets


def one_attack(
    name: str,
    attack: str,
    epochs: Epochs,
    offsets: Sequence[float],
    times_ns: tuple[int, int, int | None],
) -> Results:
    """Run both gates over a flight whose fixes are spoofed from some time on.

    Args:
        name: The flight.
        attack: Name of the attack.
        epochs: The flight.
        offsets: Metres between true and reported position at each epoch.
        times_ns: Stamps of the flight's start, of the onset, and of the attack's end.
    """
    start_ns, onset_ns, end_ns = times_ns
    first = epochs.first_from(onset_ns)
    last = len(epochs.items) if end_ns is None else epochs.first_from(end_ns)
    results = Results()
    for gate, ones in flown(epochs).items():
        results.clean.append(clean(name, gate, ones[:first]))
        onset = ((onset_ns - start_ns) / NANOSECONDS, onset_ns)
        during, off = ones[first:last], offsets[first:last]
        results.outcomes.append(outcome(name, attack, gate, onset, ones[:first], during, off))
    return results


def outcome(
    flight: str,
    attack: str,
    gate: str,
    onset: tuple[float, int],
    before: Sequence[Judged],
    during: Sequence[Judged],
    offsets: Sequence[float],
) -> Outcome:
    """Judge one attack under one gate; `onset` is in seconds of the flight and as a stamp."""
    first, lasting = alarms(during, offsets, onset[1])
    return Outcome(
        flight,
        attack,
        gate,
        round(onset[0], 2),
        first,
        lasting,
        max((one.worst for one in before if one.settled), default=0.0),
        max((one.worst for one in during), default=0.0),
        [(one.stamp_ns - onset[1]) / NANOSECONDS for one in during if one.resets],
    )
