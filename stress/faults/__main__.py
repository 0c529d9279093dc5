# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The fault matrix: every fault against real processes over DDS.

    python -m stress.faults build/bench docs/reliability.md

Each takes 100 s; `--jobs` of them run at a time, each in its own ROS domain. What was found is
kept in FOLDER/faults, and not measured again.
"""

from __future__ import annotations

import queue
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import track

from hijack_detect.evaluation.scores.evaluation_page import TextTable
from stress.faults.cases import ADVERSARIES, CASES
from stress.faults.flight import BEGIN_S, flight
from tools.documents import fill, kept, write

PATH = click.Path(path_type=Path)
FIRST_DOMAIN = 95
MOST_CHANGES = 4
ADVERSARY_HEADS = ("from 45 to 55 s", "`hijack_alert` from then on", "longest silence", "warned")
HEADS = ("fault at 45 s", "first said", "after", "NORMAL again", "longest silence", "alert")


def _kept(folder: Path, name: str) -> Path:
    return folder / "faults" / f"{name}.json"


def run(folder: Path, domains: queue.Queue[int], name: str) -> None:
    """Measure one fault, if that has not been done."""
    if _kept(folder, name).is_file():
        return
    domain = domains.get()
    command = [sys.executable, "-m", "stress.faults.run", name, str(folder), str(domain)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    domains.put(domain)
    if done.returncode:
        click.echo(f"{name}: {done.stderr[-2000:]}", err=True)
    else:
        write(_kept(folder, name), done.stdout)


def table(found: dict[str, dict[str, Any]]) -> TextTable:
    """One row a fault."""

    def seconds(value: float | None) -> str:
        return "" if value is None else f"{max(0.0, value):.1f} s"

    rows = []
    for name, one in found.items():
        alert = "" if one["alert_s"] is None else f"at {one['alert_s']:.1f} s"
        first = "" if one["said"] is None else one["said"].replace(" ", ": ", 1)
        row = (CASES[name].words, first, seconds(one["after_s"]), seconds(one["back_s"]))
        rows.append((*row, seconds(one["longest_silence_s"]), alert))
    return TextTable("", HEADS, tuple(rows))


def adversary_table(found: dict[str, dict[str, Any]]) -> TextTable:
    """One row an attacker: what a mission manager received, and what the monitor warned of."""
    rows = []
    for name, one in found.items():
        changes = [
            f"{str(alert).lower()} at {at_s:.1f} s"
            for at_s, alert in one["heard"]
            if at_s > BEGIN_S
        ]
        if len(changes) > MOST_CHANGES:
            changes[MOST_CHANGES - 1 :] = [f"{len(changes)} changes in all"]
        warning = next((text for text in one["warnings"] if "publishers on" in text), None)
        warning = warning or next((text for text in one["warnings"] if "reset" in text), "")
        silence = f"{one['longest_silence_s']:.1f} s"
        rows.append((CASES[name].words, ", ".join(changes), silence, warning.split(":")[0]))
    return TextTable("", ADVERSARY_HEADS, tuple(rows))


@click.command()
@click.argument("folder", type=PATH)
@click.argument("document", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--only", type=click.Choice(list(CASES)), multiple=True, help="Faults [all].")
@click.option("--jobs", type=click.IntRange(1, 20), default=3, show_default=True)
def main(folder: Path, document: Path, only: tuple[str, ...], jobs: int) -> None:
    """Measure with bags in FOLDER, and write the table into DOCUMENT."""
    flight(folder)  # makes the bag, once
    domains: queue.Queue[int] = queue.Queue()
    for number in range(jobs):
        domains.put(FIRST_DOMAIN + number)
    names = list(only or CASES)
    with ThreadPoolExecutor(jobs) as pool:
        results = pool.map(partial(run, folder, domains), names)
        for _ in track(results, "faults", len(names), console=Console(stderr=True)):
            pass
    found = kept({name: _kept(folder, name) for name in CASES})
    acted = {name: one for name, one in found.items() if name in ADVERSARIES}
    broken = {name: one for name, one in found.items() if name not in ADVERSARIES}
    tables = {"faults": table(broken), "adversary": adversary_table(acted)}
    fill(document, tables.get)


if __name__ == "__main__":
    main()
