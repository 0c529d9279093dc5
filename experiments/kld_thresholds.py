# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The largest divergences of clean flights, from which the KLD thresholds are taken.

    python -m experiments.kld_thresholds                           # 100 simulated flights
    python -m experiments.kld_thresholds ../shared/flights/bags    # recorded ones, all clean

The simulated flights have their own seeds, which no protocol judges. The faithful thresholds
are 1.5 times their largest values; the hardened ones are twice the largest of the recorded flights
of every kind, and above those of the simulated.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from hijack_detect.bags.reader import BagReader
from hijack_detect.bags.samples import Rejected, read_samples
from hijack_detect.detectors.kld import KldDetector
from hijack_detect.detectors.kld_values import NAMES, KldParameters
from hijack_detect.evaluation.trials.cases import flight_samples
from hijack_detect.evaluation.trials.corpus import bag_paths
from hijack_detect.monitor.graph import Stage
from hijack_detect.monitor.policies import policy_parameters
from hijack_detect.simulation.flight import generate_flight
from hijack_detect.simulation.plan import FlightPlan
from hijack_detect.streams.samples import Sample

SEED, FLIGHTS = 90_000, 100
"""Chosen: no protocol has these seeds."""
INPUTS = ("fix", "velocity", "satellites")
MODES = {
    "faithful": policy_parameters("paper").of(KldParameters),
    "hardened": KldParameters(),
}
Samples = list[tuple[str, Sample]]


def simulated() -> Iterator[tuple[str, Samples]]:
    """Straight and curved flights in turn."""
    for number in range(FLIGHTS):
        plan = FlightPlan(("straight", "curved")[number % 2])
        yield f"seed {SEED + number}", list(flight_samples(generate_flight(plan, SEED + number)))


def recorded(folder: Path) -> Iterator[tuple[str, Samples]]:
    """Every bag below a folder."""
    for path in bag_paths(folder):
        with BagReader(path) as reader:
            samples = read_samples(reader, reader.inputs(), on_rejected=Rejected().add)
            yield path.name, list(samples)


def largest(samples: Iterable[tuple[str, Sample]], parameters: KldParameters) -> dict[str, float]:
    """Largest sum of forward and backward divergence of each parameter, nats."""
    stage = Stage(lambda: KldDetector(parameters))
    found: dict[str, float] = defaultdict(float)
    for name, sample in samples:
        for verdict in stage.push(name, sample) if name in INPUTS else ():
            values = verdict.values
            for of in NAMES:
                if f"{of}.forward" in values:
                    total = values[f"{of}.forward"] + values[f"{of}.backward"]
                    found[of] = max(found[of], total)
    return found


@click.command()
@click.argument("folder", type=click.Path(exists=True, path_type=Path), required=False)
def main(folder: Path | None) -> None:
    """Print the largest divergences of each flight, or of all simulated ones."""
    console = Console(width=120)
    rows: dict[str, dict[str, dict[str, float]]] = {mode: {} for mode in MODES}
    for name, samples in simulated() if folder is None else recorded(folder):
        for mode, parameters in MODES.items():
            rows[mode][name] = largest(samples, parameters)
    for mode, flights in rows.items():
        table = Table("flight", *NAMES, title=f"{mode}: largest divergence, nat")
        if folder is not None:
            for name, found in flights.items():
                table.add_row(name, *(f"{found[of]:.3g}" if of in found else "–" for of in NAMES))
        worst = [max(found.get(of, 0.0) for found in flights.values()) for of in NAMES]
        table.add_row(f"largest of {len(flights)}", *(f"{value:.3g}" for value in worst))
        table.add_row("threshold", *(f"{MODES[mode].threshold(of):g}" for of in NAMES))
        console.print(table)


if __name__ == "__main__":
    main()
