# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Limits of the detectors, chosen with one vehicle left out and shown on that vehicle.

    python -m experiments.left_out docs/detection-limits.md --rows build/left_out.json

Every clean flight of `real`, `logs`, `bags` and `sitl` runs once through the default monitor (six
minutes on one core); of each detector the largest margin (score over limit) of the verdicts that
can tell is kept. The limit without a vehicle is FACTOR times the largest score of the others, in
parts of the limit in force; a limit that is learnt in flight scales with it. A flight beyond the
limit in force is a known fault and does not count in the choice. Fills in the tables `left_out
vehicles` and `left_out detectors` of the document; with --no-flights from the rows that are there.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from experiments.vehicles import Flight, corpus
from hijack_detect.analysis.account import Account
from hijack_detect.bags.errors import BagError
from hijack_detect.detectors.verdict import JUDGED, Verdict
from hijack_detect.evaluation.scores.evaluation_tables import NONE, TextTable, proportion
from hijack_detect.evaluation.scores.metrics import Proportion
from hijack_detect.evaluation.scores.model import Model
from hijack_detect.evaluation.scores.watch import watch
from hijack_detect.evaluation.trials.cases import HIJACKED
from hijack_detect.monitor.parts import DETECTORS, WEIGHTS
from hijack_detect.monitor.policies import MonitorParameters, policy_parameters
from hijack_detect.streams.samples import NANOSECONDS
from tools.documents import fill, write

FACTOR = 1.25
"""What a limit leaves to the largest clean score; those in force leave 1.1 to 1.7. Fixed before the
flights were run (docs/detection-limits.md)."""
ALERTING = tuple(name for name, one in WEIGHTS.items() if one.may_alert)
"""Detectors whose alarm makes an alert."""
PATH = click.Path(path_type=Path)


class FlightRow(Model):
    """What the detectors made of one clean flight, until its receiver really failed.

    Attributes:
        name: The flight's name.
        vehicle: Its vehicle.
        kind: Its class.
        at_risk_s: Time in the air in which an alert was possible, until the first one.
        alert: Cause of the first alert, None without.
        told_s: Part of `at_risk_s` in which each detector could tell.
        margins: Largest margin of each detector, where it could ever tell.
    """

    name: str
    vehicle: str
    kind: str
    at_risk_s: float
    alert: str | None
    told_s: dict[str, float]
    margins: dict[str, float]


Rows = Sequence[FlightRow]


def fly(parameters: MonitorParameters, flight: Flight) -> FlightRow:
    """Run a clean flight through the monitor.

    Raises:
        BagError: The flight cannot be read.
    """
    account = Account(DETECTORS, parameters.fusion, 0)
    done = flight.case.run(parameters, on_sample=account.take, on_output=account.take_output)
    start_ns, end_ns = done.run.start_ns, max(done.end_ns, account.newest_ns)
    until_ns = None if flight.fails_s is None else start_ns + round(flight.fails_s * NANOSECONDS)
    watched = watch(account, start_ns, end_ns, until_ns, counted=True)

    def margin(verdicts: Sequence[Verdict]) -> float | None:
        could_tell = (one for one in verdicts if one.state in JUDGED)
        return max(
            (one.margin for one in could_tell if until_ns is None or one.stamp_ns < until_ns),
            default=None,
        )

    margins = {name: margin(verdicts) for name, verdicts in done.run.verdicts.items()}
    return FlightRow(
        name=flight.case.name,
        vehicle=flight.vehicle,
        kind=flight.case.kind,
        at_risk_s=watched.at_risk_s,
        alert=None if watched.first is None else watched.first.cause,
        told_s=watched.told_s,
        margins={name: float(f"{one:.4g}") for name, one in margins.items() if one is not None},
    )


@dataclass(frozen=True)
class Chosen:
    """Limits of one detector, in parts of the limit in force.

    Attributes:
        largest: Largest clean margin of each vehicle on which the detector could ever tell.
        within: The same without flights beyond the limit in force: what limits are chosen by.
        limits: By vehicle, the limit chosen without it; infinite where there is no other.
        limit: The limit chosen on all vehicles.
    """

    largest: Mapping[str, float]
    within: Mapping[str, float]
    limits: Mapping[str, float]
    limit: float

    def left_out(self, vehicle: str, margin: float) -> float:
        """A margin of a vehicle under the limit chosen without it."""
        return margin / self.limits[vehicle] if margin else 0.0


def chosen(rows: Rows, detector: str) -> Chosen:
    """Choose the limit of a detector, and without each vehicle in turn."""
    margins = [(row.vehicle, row.margins[detector]) for row in rows if detector in row.margins]
    largest = _largest(margins)
    within = _largest([one for one in margins if one[1] < 1.0])

    def rule(margins: Sequence[float]) -> float:
        return FACTOR * max(margins, default=math.inf)

    limits = {
        vehicle: rule([one for other, one in within.items() if other != vehicle])
        for vehicle in largest
    }
    return Chosen(largest, within, limits, rule(list(within.values())))


def _largest(margins: Sequence[tuple[str, float]]) -> dict[str, float]:
    found: dict[str, float] = {}
    for vehicle, margin in margins:
        found[vehicle] = max(found.get(vehicle, 0.0), margin)
    return found


def beyond(rows: Rows, of: Mapping[str, Chosen], *, left_out: bool) -> list[FlightRow]:
    """Flights on which a margin reaches the limit: in force, or chosen without their vehicle."""
    return [
        row
        for row in rows
        if any(
            (of[name].left_out(row.vehicle, margin) if left_out else margin) >= 1.0
            for name, margin in row.margins.items()
            if name in of
        )
    ]


def vehicles_table(rows: Rows) -> TextTable:
    """Margins of each vehicle: under the limit in force, and under the one chosen without it."""
    of = {name: chosen(rows, name) for name in DETECTORS}

    def cell(name: str, vehicle: str) -> str:
        margin = of[name].largest.get(vehicle)
        if margin is None:
            return NONE
        pair = (margin, of[name].left_out(vehicle, margin))
        return ", ".join(f"**{one:.2f}**" if one >= 1.0 else f"{one:.2f}" for one in pair)

    found = []
    for vehicle in sorted({row.vehicle for row in rows}):
        own = [row for row in rows if row.vehicle == vehicle]
        hours = sum(row.at_risk_s for row in own) / 3600.0
        cells = (cell(name, vehicle) for name in DETECTORS)
        found.append((vehicle, str(len(own)), f"{hours:.2f}", *cells))
    return TextTable("Margins", ("vehicle", "flights", "h at risk", *DETECTORS), tuple(found))


def detectors_table(rows: Rows) -> TextTable:
    """The vehicle that decides each limit, the limit without it, and what is beyond that."""
    found = []
    for name in DETECTORS:
        one = chosen(rows, name)
        order = sorted(one.within.items(), key=lambda pair: -pair[1])
        if len(order) < 2:  # no vehicle to choose by, or to show it on
            found.append((name, str(len(order)), *(NONE,) * 7))
            continue
        (first, most), (second, next_most) = order[:2]
        hours = sum(row.told_s.get(name, 0.0) for row in rows) / 3600.0
        counts = (str(len(beyond(rows, {name: one}, left_out=out))) for out in (False, True))
        found.append(
            (
                name,
                str(len(order)),
                f"{hours:.2f}",
                f"{most:.2f} ({first})",
                f"{next_most:.2f} ({second})",
                f"{one.limit:.2f}, {one.limits[first]:.2f}",
                f"{most / next_most:.2f}" if next_most else NONE,
                *counts,
            )
        )
    of = {name: chosen(rows, name) for name in ALERTING}
    counts = (str(len(beyond(rows, of, left_out=out))) for out in (False, True))
    total = f"{len({row.vehicle for row in rows})}"
    hours = sum(row.at_risk_s for row in rows) / 3600.0
    found.append(("any that alerts", total, f"{hours:.2f}", *(NONE,) * 4, *counts))
    return TextTable(
        "Limits",
        (
            "detector",
            "vehicles",
            "h",
            "largest clean margin",
            "the next vehicle's",
            "limit by the rule with and without the first",
            "factor needed",
            "flights beyond: in force",
            "left out",
        ),
        tuple(found),
    )


TABLES: Mapping[str, Callable[[Rows], TextTable]] = {
    "vehicles": vehicles_table,
    "detectors": detectors_table,
}
"""By the second word of a mark, after `left_out`."""


def flown(flights: Path) -> list[FlightRow]:
    """Run all clean flights, with a line on stderr for each."""
    parameters, begun = policy_parameters("default"), time.monotonic()
    wanted = [one for one in corpus(flights) if one.case.kind != HIJACKED]
    rows = []
    for count, flight in enumerate(wanted, 1):
        label = f"{count}/{len(wanted)} {flight.case.name} ({flight.vehicle})"
        try:
            row = fly(parameters, flight)
        except BagError as error:
            print(f"{label}: left out: {error}", file=sys.stderr)
            continue
        rows.append(row)
        margins = " ".join(f"{name} {margin:.2f}" for name, margin in row.margins.items())
        minutes = (time.monotonic() - begun) / 60.0
        print(f"{label} after {minutes:.1f} min: {margins} {row.alert or ''}", file=sys.stderr)
    return rows


def summary(rows: Rows) -> str:
    """How many vehicles have a flight beyond a limit of a detector that makes alerts."""
    of = {name: chosen(rows, name) for name in ALERTING}
    total = len({row.vehicle for row in rows})
    parts = []
    for out, words in ((False, "in force"), (True, "chosen without the vehicle")):
        found = beyond(rows, of, left_out=out)
        share = proportion(Proportion.of(len({row.vehicle for row in found}), total))
        names = ", ".join(row.name for row in found)
        parts.append(f"vehicles beyond a limit {words}: {share} ({names})".replace("\n", " "))
    return "\n".join(parts)


@click.command()
@click.argument("document", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--rows", "kept", type=PATH, help="Write a row for each flight here, as JSON.")
@click.option("--no-flights", is_flag=True, help="Make the tables of the rows that are there.")
@click.option("--flights", type=PATH, default=Path("../shared/flights"), show_default=True)
def main(document: Path, kept: Path | None, no_flights: bool, flights: Path) -> None:
    """Run all clean flights of FLIGHTS and fill in the tables of DOCUMENT."""
    if no_flights:
        if kept is None:
            raise click.UsageError("--no-flights goes with --rows")
        rows = [FlightRow.model_validate(one) for one in json.loads(kept.read_text("utf-8"))]
    else:
        rows = flown(flights)
        if kept is not None:
            write(kept, json.dumps([row.model_dump() for row in rows], indent=1) + "\n")

    def table(part: str, *words: str) -> TextTable | None:
        return TABLES[words[0]](rows) if part == "left_out" else None

    fill(document, table)
    click.echo(summary(rows))


if __name__ == "__main__":
    main()
