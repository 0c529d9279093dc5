# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Attacks under the innovation gates of PX4 and ArduPilot: tables, and a JSON file.

    python -m experiments.autopilot_gates OUT.json [--flights ../shared/flights] [--jobs 2]

An EKF of this project runs under each gate with the autopilot's own noise values, so that a lie
that is accepted drags it along, and one that is rejected lets it coast until a time-out sets it
to the GPS. Found means that the gate rejected something during the attack, before any reset; that
is more than the autopilot reports. `no attack` is how often the same minutes of the clean
flight do that; a second table leaves these minutes out.
"""

from __future__ import annotations

import dataclasses
import json
import statistics
import sys
from collections.abc import Sequence
from pathlib import Path

import click

from experiments.autopilot_gates.flights import (
    GATES,
    NO_ATTACK,
    Flight,
    LabelledFlight,
    RecordedFlight,
    Results,
    SimulatedFlight,
    run,
)
from experiments.autopilot_gates.outcome import Alarm, Clean, Outcome
from hijack_detect.evaluation.trials.corpus import bag_paths
from hijack_detect.evaluation.trials.parallel import Failure, Pool, map_cases

FIRST_SEED, SIMULATED = 40_000, 40


def cell(found: Sequence[Alarm | None]) -> str:
    """Attacks found, and median time and distance of these."""
    alarms = [alarm for alarm in found if alarm is not None]
    if not alarms:
        return f"0 of {len(found)} | |"
    after = statistics.median(alarm.after_s for alarm in alarms)
    off = statistics.median(alarm.off_m for alarm in alarms)
    return f"{len(alarms)} of {len(found)} | {after:.1f} s | {off:.0f} m"


def attack_table(outcomes: Sequence[Outcome]) -> str:
    """One line for each attack: first and lasting rejection under each gate."""
    lines = [
        "| attack | gate | first rejection | median | off by | 1 s in a row | median | off by "
        "| largest ratio, median | reset onto the GPS |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for attack in dict.fromkeys(one.attack for one in outcomes):
        for gate in GATES:
            ones = [one for one in outcomes if (one.attack, one.autopilot) == (attack, gate)]
            if not ones:
                continue
            ratio = statistics.median(one.worst_after for one in ones)
            resets = sum(bool(one.resets_s) for one in ones)
            first, lasting = cell([o.first for o in ones]), cell([o.lasting for o in ones])
            lines.append(
                f"| {attack} | {gate} | {first} | {lasting} | {ratio:.2f} "
                f"| {resets} of {len(ones)} |"
            )
    return "\n".join(lines)


def quiet(outcomes: Sequence[Outcome]) -> list[Outcome]:
    """The attacks at onsets after which the same gate rejects nothing of the clean flight."""

    def place(one: Outcome) -> tuple[str, float, str]:
        return one.flight, one.onset_s, one.autopilot

    kept = {place(one) for one in outcomes if one.attack == NO_ATTACK and one.first is None}
    return [one for one in outcomes if place(one) in kept]


def clean_table(ones: Sequence[Clean]) -> str:
    """One line for each flight in which a gate rejected something, and one for all."""
    lines = [
        "| flight | gate | h | rejections | of 1 s | resets | largest ratio |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {one.flight} | {one.autopilot} | {one.hours:.3f} | {one.rejections} | {one.lasting} "
        f"| {one.resets} | {one.worst:.2f} |"
        for one in ones
        if one.rejections
    ]
    for gate in GATES:
        mine = [one for one in ones if one.autopilot == gate]
        hours = sum(one.hours for one in mine)
        rates = [sum(getattr(o, key) for o in mine) / hours for key in ("rejections", "lasting")]
        lines.append(
            f"| all {len(mine)} | {gate} | {hours:.2f} | {rates[0]:.1f} per hour "
            f"| {rates[1]:.1f} per hour | {sum(o.resets for o in mine)} "
            f"| {max(o.worst for o in mine):.2f} |"
        )
    return "\n".join(lines)


def tables(kinds: Sequence[tuple[str, Results]]) -> str:
    """Everything as Markdown, by kind of flight."""
    text = []
    for kind, results in kinds:
        text.append(f"\n#### {kind}, attacked\n\n{attack_table(results.outcomes)}")
        if kept := quiet(results.outcomes):
            text.append(f"\n#### {kind}, attacked where the clean flight stays quiet")
            text.append("\n" + attack_table(kept))
        text.append(f"\n#### {kind}, clean or before the attack\n\n{clean_table(results.clean)}")
    return "\n".join(text)


@click.command()
@click.argument("out", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "--flights",
    default="../shared/flights",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Folder with the folders sitl (labelled) and bags (clean).",
    show_default=True,
)
@click.option("--match", default="", help="Only flights with this in the name.")
@click.option("--jobs", default=1, show_default=True, help="Processes.")
def main(out: Path, flights: Path, match: str, jobs: int) -> None:
    """Print the tables and write OUT."""
    kinds: dict[str, list[Flight]] = {
        "Recorded flights": [RecordedFlight(path) for path in bag_paths(flights / "bags")],
        "An autopilot in the loop": [LabelledFlight(path) for path in bag_paths(flights / "sitl")],
        "Simulated flights": [SimulatedFlight(FIRST_SEED + k) for k in range(SIMULATED)],
    }
    work = [(kind, one) for kind, ones in kinds.items() for one in ones if match in one.name]
    done = map_cases(
        run,
        [one for _, one in work],
        pool=Pool(jobs),
        on_done=lambda count: click.echo(f"{count} of {len(work)} flights", err=True),
    )
    found: dict[str, Results] = {}
    for (kind, _), result in zip(work, done, strict=True):
        if isinstance(result, Failure):
            sys.exit(f"{result.name}: {result.reason}")
        into = found.setdefault(kind, Results())
        into.outcomes += result.outcomes
        into.clean += result.clean
    out.write_text(
        json.dumps({kind: dataclasses.asdict(one) for kind, one in found.items()}, indent=1) + "\n",
        encoding="utf-8",
    )
    click.echo(tables(list(found.items())))


if __name__ == "__main__":
    main()
