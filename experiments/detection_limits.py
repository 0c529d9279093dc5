# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Docs/detection-limits.md: runs all attacks, fills in the tables and draws the figures.

    python -m experiments.detection_limits docs/detection-limits.md --results build/limits

(a) recorded flights, attacked at seeded onsets with every family; (b) the labelled flights of an
autopilot in the loop; (c) the classes of the protocol `limits` in the closed-loop simulator; (d) a
map of drifts there. A run that was stopped goes on where it was, see `limits_runs`.

A line `<!-- table PART KIND ARGUMENTS -->` of the text is followed by a table, which is replaced.
PART is recorded, sitl, simulated or map, KIND one of `limits_tables.KINDS`. A table of a part
without records stays as it is, as do those of other scripts.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import click

from experiments import limits_figures, limits_tables
from experiments.limits_runs import PARTS, load, run, works
from hijack_detect.evaluation.scores.evaluation_tables import TextTable
from hijack_detect.monitor.policies import POLICIES, policy_parameters
from tools.documents import fill

PATH = click.Path(path_type=Path)


@click.command()
@click.argument("document", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--results", type=PATH, required=True, help="Folder of the records.")
@click.option("--flights", type=PATH, default=Path("../shared/flights"), show_default=True)
@click.option("--only", type=click.Choice(list(PARTS)), multiple=True, help="Parts to run [all].")
@click.option("--scale", type=click.IntRange(1, 200), default=1, help="Of the classes, times 30.")
@click.option("--map-scale", type=click.IntRange(1, 200), default=2, help="Of the map, times 6.")
@click.option("--moving", type=click.IntRange(0, 1000), default=10, help="Onsets in motion [10].")
@click.option("--any-phase", type=click.IntRange(0, 1000), default=5, help="Other onsets [5].")
@click.option("--policy", type=click.Choice(list(POLICIES)), default="default")
@click.option("--jobs", type=click.IntRange(1), default=2, show_default=True)
@click.option("--draw-only", is_flag=True, help="Run nothing: tables and figures of what is there.")
def main(
    document: Path,
    results: Path,
    flights: Path,
    only: tuple[str, ...],
    scale: int,
    map_scale: int,
    moving: int,
    any_phase: int,
    policy: str,
    jobs: int,
    draw_only: bool,
) -> None:
    """Run what is missing in RESULTS, then write the tables into DOCUMENT, figures beside it."""
    parts = only or tuple(PARTS)
    for part in () if draw_only else parts:
        wanted = list(works(part, flights, map_scale if part == "d" else scale))
        failed = run(
            wanted,
            results,
            policy_parameters(policy),
            jobs=jobs,
            moving=moving,
            any_phase=any_phase,
            on_done=Progress(PARTS[part], len(wanted)).show,
        )
        for failure in failed:
            print(f"{failure.name}: {failure.reason}", file=sys.stderr)
    records = {name: load(results, part) for part, name in PARTS.items()}

    def table(part: str, kind: str, *arguments: str) -> TextTable | None:
        found = records.get(part)
        return limits_tables.KINDS[kind](found, *arguments) if found else None

    fill(document, table)
    for part in parts:
        name = PARTS[part]
        for path in limits_figures.draw_all(document.parent / "figures", name, records[name]):
            print(path, file=sys.stderr)


class Progress:
    """Lines on stderr, so that a log of the run shows how far it is."""

    def __init__(self, name: str, total: int) -> None:
        """Begin now."""
        self._name, self._total, self._begun = name, total, time.monotonic()

    def show(self, done: int) -> None:
        """Say how many pieces are done."""
        minutes = (time.monotonic() - self._begun) / 60.0
        print(f"{self._name}: {done}/{self._total} after {minutes:.1f} min", file=sys.stderr)


if __name__ == "__main__":
    main()
